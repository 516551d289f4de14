"""Sparse Bayesian regression: automatic relevance determination (MacKay, 1992; Tipping, 2001), by scikit-learn."""

from __future__ import annotations

import numpy as np
from scipy.stats import norm
from sklearn.linear_model import ARDRegression

from ..answers import Answer, Case, FloatArray
from .problem import Channel, regression

#: Distance of a coefficient from zero in posterior deviations from which a feature is reported.
DEVIATIONS = 3.0


def answer(case: Case) -> Answer:
    """Return the features whose coefficients remain; the probability is that of their sign, scaled from 0 to 1."""
    return regression(case, selected)


def selected(channel: Channel) -> tuple[list[int], FloatArray]:
    """Return the features whose coefficients differ from zero, and the probability of each, shape (f,)."""
    y, x = channel.projected
    model = ARDRegression(fit_intercept=False).fit(x, y)
    kept = model.lambda_ < model.threshold_lambda
    distance = np.zeros(x.shape[1])
    distance[kept] = np.abs(model.coef_[kept]) / np.sqrt(np.diag(model.sigma_))
    return [int(i) for i in np.flatnonzero(distance > DEVIATIONS)], 1.0 - 2.0 * norm.sf(distance)
