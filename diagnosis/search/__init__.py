"""Stepwise search for missing effects: probe, refit, rank, apply the acceptance criteria, repeat."""
