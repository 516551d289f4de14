"""Benchmark of missing effects: recordings from seeds, answers of methods, and their score (`README.md`)."""
