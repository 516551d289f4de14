"""Candidate effects, the fit of the baseline model, and the test of each effect on its residual."""
