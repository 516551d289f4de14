"""Forward regression with t-tests that take rows as independent: what a diagnosis without further criteria finds."""

from __future__ import annotations

import numpy as np
from scipy.stats import norm

from ..answers import Answer, Case, FloatArray
from .problem import Channel, regression

#: Largest p value of a feature, divided by the number of features (Bonferroni); largest number of features.
P_VALUE, MOST = 0.05, 10


def answer(case: Case) -> Answer:
    """Return what a stepwise regression of each channel selects."""
    return regression(case, selected)


def selected(channel: Channel) -> tuple[list[int], FloatArray]:
    """Return the selected features and one minus the adjusted p value of each, shape (f,)."""
    y, x = channel.projected
    size = np.linalg.norm(x, axis=0)
    x = x / np.where(size > 1e-6 * np.sqrt(len(x)), size, np.inf)
    found, probability = list[int](), np.zeros(x.shape[1])
    while len(found) < MOST:
        score = np.abs(x.T @ y) / np.sqrt(np.mean(y**2))
        best = int(np.argmax(score))
        p = min(1.0, 2.0 * float(norm.sf(score[best])) * x.shape[1])
        if p > P_VALUE:
            break
        found.append(best)
        probability[best] = 1.0 - p
        direction = x[:, best]
        y = y - direction * (direction @ y)
        x = x - np.outer(direction, direction @ x)
        size = np.linalg.norm(x, axis=0)
        x = x / np.where(size > 0.05, size, np.inf)
    return found, probability
