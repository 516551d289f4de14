"""Stability selection (Meinshausen, Buehlmann, JRSS B 2010; Shah, Samworth, JRSS B 2013) with the lasso (scikit-learn).

The first features of a lasso path are selected on random halves of the blocks of time. With f features, q of which are
selected on each half, at most q^2 / (f (2 share - 1)) wrong ones are expected at a given share of the halves.
"""

from __future__ import annotations

import numpy as np
from sklearn.linear_model import lars_path

from ..answers import Answer, Case, FloatArray
from .problem import Channel, at_least, regression

#: Blocks of time; pairs of halves; features selected on a half; share of the halves that selects.
BLOCKS, PAIRS, FEATURES, SHARE = 40, 25, 3, 0.9


def answer(case: Case) -> Answer:
    """Return the features that most halves select; the probability is the share of the halves."""
    return regression(case, lambda channel: at_least(SHARE, frequency(channel)))


def frequency(channel: Channel) -> FloatArray:
    """Return the share of the halves that select each feature, shape (f,)."""
    y, x = channel.projected
    used = np.flatnonzero(x.std(axis=0) > 1e-6)
    x = x[:, used] / x[:, used].std(axis=0)
    block, selected = np.arange(len(y)) * BLOCKS // len(y), np.zeros(channel.columns.shape[1])
    rng = np.random.default_rng(1)
    for _ in range(PAIRS):
        first = np.isin(block, rng.permutation(BLOCKS)[: BLOCKS // 2])
        for rows in (first, ~first):
            _, active, _ = lars_path(x[rows], y[rows], method="lasso", max_iter=FEATURES)
            selected[used[active]] += 1.0
    return selected / (2 * PAIRS)
