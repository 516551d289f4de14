"""Estimation methods of the fit and the diagnosis: damped Gauss-Newton, noise models, resampling, periodicity."""
