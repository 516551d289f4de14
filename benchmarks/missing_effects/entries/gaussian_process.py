"""A Gaussian process on the residual of the baseline model: a correction of the forces without names (scikit-learn)."""

from __future__ import annotations

import numpy as np
import pandas as pd
from sklearn.gaussian_process import GaussianProcessRegressor
from sklearn.gaussian_process.kernels import RBF, ConstantKernel, WhiteKernel

from ..answers import UNKNOWN, Answer, Case
from .problem import channels_of, inputs_of, scaled

#: Rows of the process; largest length of a variable on which the residual depends, in deviations of the input.
ROWS, LENGTH = 400, 3.0
#: Share of the variance of held-out rows that a correction explains from which it is reported and used.
GAIN = 0.05


def answer(case: Case) -> Answer:
    """Return UNKNOWN if the process predicts rows that it has not seen; the probability is the explained share."""
    n = len(case.recording)
    x = scaled(inputs_of(case), n)
    points = np.stack(list(x.values()), axis=1)
    rows = np.random.default_rng(1).permutation(n)
    train, held = rows[:ROWS], rows[ROWS : 2 * ROWS]
    variables, forces, largest = set[str](), {}, 0.0
    for name, channel in channels_of(case).items():
        fit = channel.forces([])
        y = channel.projected[0]
        kernel = ConstantKernel(1.0) * RBF(np.ones(len(x)), (0.1, 1e3)) + WhiteKernel(1.0)
        model = GaussianProcessRegressor(kernel, normalize_y=True, random_state=1).fit(points[train], y[train])
        gain = 1.0 - float(np.var(y[held] - model.predict(points[held])) / np.var(y[held]))
        if gain > GAIN:
            fit = fit + channel.noise * model.predict(points[n:])
            lengths = model.kernel_.k1.k2.length_scale
            variables |= {key for key, length in zip(x, lengths, strict=True) if length < LENGTH}
        forces[name], largest = fit, max(largest, gain)
    found = (UNKNOWN,) if largest > GAIN else ()
    return Answer(found, {UNKNOWN: min(max(largest, 0.0), 1.0)}, tuple(sorted(variables)), pd.DataFrame(forces))
