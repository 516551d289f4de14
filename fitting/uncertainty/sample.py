"""A sample of the rows of a channel at the solution of a stage, with the Jacobian at these rows."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np

from ...numerics.arrays import FloatArray, IntArray
from ...numerics.smoothing import noise_of
from ..problem.rows import Rows
from ..problem.weighted_residuals import Problem

#: Fewest rows of a channel, and largest number of sampled rows.
MIN_ROWS, MAX_ROWS = 200, 4000
#: Rows between sampled ones above which noise is read from neighboring rows: its correlation has decayed then.
FAR_APART = 8.0


@dataclass(frozen=True, eq=False)
class Sample:
    """Some rows of a channel: one at random of each few rows.

    - `channel`: its index among the outputs. `rows`: the sampled ones of `of` rows. `number`, shape (n,): of each row
      among all rows of the problem.
    - `jacobian`, shape (n_free, n): of the channel by the scaled free values.
    - `weight`, `residual`, `computed`, shape (n,). `place`, shape (n,): of each row among all rows, from 0 to 1.
    - `noise`: variance of the sum of the noise of n sampled rows over n; infinite if sampled rows are near each other.
    """

    channel: int
    rows: Rows
    number: IntArray
    of: int
    jacobian: FloatArray
    weight: FloatArray
    residual: FloatArray
    computed: FloatArray
    place: FloatArray
    noise: float

    @property
    def gradient(self) -> FloatArray:
        """J^T W of all rows, as estimated from the sample, shape (n_free, n)."""
        return self.jacobian * self.weight * (self.of / len(self.weight))


def samples_of(problem: Problem, x: FloatArray) -> Iterator[Sample]:
    """Yield a sample of each channel that a stage fits; `x`, shape (n_free,): scaled free values of the solution."""
    residual = problem.residual(x)
    for channel in np.flatnonzero((problem.weights > 0).any(axis=0)):
        present = np.flatnonzero(np.isfinite(problem.rows.measured[:, channel]))
        if len(present) >= MIN_ROWS:
            yield _sample(problem, x, int(channel), present, residual[channel, present])


def _sample(problem: Problem, x: FloatArray, channel: int, present: IntArray, every: FloatArray) -> Sample:
    edges = np.linspace(0, len(present), min(len(present), MAX_ROWS) + 1).astype(np.int64)
    number = edges[:-1] + np.random.default_rng(0).integers(np.diff(edges))
    part = replace(problem, rows=problem.rows.take(present[number]))
    jacobian, weight = np.zeros((len(problem.free), len(number))), np.zeros(len(number))
    start = 0
    for segments, root, outputs in part.jacobian_chunks(x, len(number)):
        rows = slice(start, start + len(segments))
        start = rows.stop
        weight[rows] = root[channel] ** 2
        if channel in outputs:
            free, derivatives = outputs[channel]
            jacobian[free, rows] = derivatives
    residual = part.residual(x)[channel]
    computed = part.rows.measured[:, channel] + residual
    noise, apart = np.inf, len(present) / len(number)
    if apart > FAR_APART:
        deviation, correlation = noise_of(every)
        noise = deviation**2 * (1.0 + correlation**apart) / (1.0 - correlation**apart)
    place = number / len(present)
    return Sample(channel, part.rows, present[number], len(present), jacobian, weight, residual, computed, place, noise)
