"""Sparse regression by an ensemble of sequentially thresholded least squares (PySINDy; Fasel et al., 2022)."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt
import pysindy

from ..answers import Answer, Case, FloatArray
from .problem import Channel, at_least, regression

#: Thresholds in noise deviations, of which held-out blocks select one; models of an ensemble; share that selects.
THRESHOLDS, MODELS, SHARE = (0.05, 0.1, 0.3, 1.0), 20, 0.5


def answer(case: Case) -> Answer:
    """Return what the ensembles select; the probability is the share of the models with a feature."""
    return regression(case, lambda channel: at_least(SHARE, inclusion(channel)))


def inclusion(channel: Channel) -> FloatArray:
    """Return the share of the models that contain each feature, shape (f,)."""
    y, x = channel.projected
    held = np.arange(len(y)) * 10 // len(y) % 5 == 2

    def ensemble(rows: npt.NDArray[np.bool_], threshold: float) -> FloatArray:
        np.random.seed(1)  # PySINDy draws from this generator
        single = pysindy.STLSQ(threshold=threshold, alpha=1.0)
        optimizer = pysindy.EnsembleOptimizer(single, bagging=True, n_models=MODELS)
        optimizer.fit(x[rows], y[rows, None])
        return np.array(optimizer.coef_list)[:, 0]

    def error(threshold: float) -> float:
        return float(np.mean((y[held] - x[held] @ ensemble(~held, threshold).mean(axis=0)) ** 2))

    models = ensemble(np.ones(len(y), dtype=bool), min(THRESHOLDS, key=error))
    return np.asarray(np.mean(models != 0.0, axis=0))
