"""Calibration of probabilities: how often effects with a probability are missing, over many recordings."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise

import numpy as np
from discovery_score import Outcome

#: Edges of the groups of probabilities; below the first one an effect is taken as excluded.
EDGES = (0.01, 0.1, 0.5, 0.9, 0.99, 1.0)


def calibration(outcomes: Sequence[Outcome]) -> list[tuple[str, str, str, str]]:
    """Return a row for each group of probabilities: its range, number of effects, mean probability and share missing.

    Each recording counts each candidate, and UNKNOWN, that has a probability of at least `EDGES[0]`. The last row is
    the expected calibration error: the difference of mean and share, averaged over all that are counted.
    """
    pairs = np.array([pair for one in outcomes for pair in one.claims if pair[0] >= EDGES[0]]).reshape(-1, 2)
    rows, error = [], 0.0
    for low, high in pairwise(EDGES):
        group = pairs[(pairs[:, 0] >= low) & ((pairs[:, 0] < high) | (high == EDGES[-1]))]
        if len(group):
            claimed, true = group.mean(axis=0)
            error += len(group) * abs(claimed - true) / len(pairs)
            rows.append((f"{low:g} to {high:g}", str(len(group)), f"{claimed:.2f}", f"{true:.2f}"))
    return [*rows, ("expected calibration error", str(len(pairs)), f"{error:.3f}", "-")]
