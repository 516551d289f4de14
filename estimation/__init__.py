"""Estimation shared by the fit and the diagnosis: damped Gauss-Newton, noise, resampling, what repeats."""
