"""The search for missing effects: probe, refit, rank, gate, repeat."""
