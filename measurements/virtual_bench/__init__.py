"""The virtual test bench: test programs, sensor noise, recordings of a known tire."""
