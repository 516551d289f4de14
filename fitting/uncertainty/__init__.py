"""Uncertainty of a fit: noise that is correlated in time, errors of the form of the model, derivatives."""
