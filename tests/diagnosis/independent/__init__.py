"""Recordings whose truth is an independent NumPy program: the second suite of the benchmark of the diagnosis."""
