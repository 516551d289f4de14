"""Candidate effects, the fit of the baseline model, and the test of each effect on its residual.

Finite probes represent each effect, because the derivative at the neutral value is zero for some. The response of the
forces to a probe is a regression column, with the baseline model projected out. Two tests give its p-value: one with
the covariance of coloured noise, one with a jackknife over time blocks.
"""
