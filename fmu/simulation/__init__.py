"""How any FMU is run: unpacked within limits, loaded, and simulated in a separate process."""
