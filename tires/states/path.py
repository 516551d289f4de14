"""The history of a state along a path: of a hysteresis or of play (`tirefmu.symbolic.laws`)."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Protocol

import numpy as np
import numpy.typing as npt

from ..code.modules import state_laws
from .transient import recursion

FloatArray = npt.NDArray[np.float64]
IntArray = npt.NDArray[np.intp]

#: Names of the laws by kind and number of lags. The functions are looked up when they are called: the package must be
#: importable for the generation of their code.
LAWS = {
    ("hysteresis", 1): "dahl", ("hysteresis", 2): "dahl_size", ("play", 1): "play", ("play", 2): "play_size",
}  # fmt: skip


class Follower(Protocol):
    """The time history of a lag."""

    @property
    def value(self) -> FloatArray:
        """The values at the rows, shape (n,)."""

    def between(self, interval: IntArray, share: FloatArray) -> FloatArray:
        """Return the values at shares of intervals, shape (m,)."""


@dataclass(frozen=True)
class PathCourse:
    """The history of a hysteresis or of play along one lag, or along the magnitude of two."""

    lags: Sequence[Follower]
    rate: FloatArray
    start: FloatArray
    restarts: IntArray
    kind: str

    def _law(self, z: float | FloatArray, rows: IntArray, ends: list[FloatArray]) -> FloatArray:
        law = getattr(state_laws, LAWS[self.kind, len(self.lags)])
        return np.asarray(law(z, *(lag.value[rows] for lag in self.lags), *ends, 1.0 / self.rate[rows]))

    @cached_property
    def value(self) -> FloatArray:
        """The values at the rows, shape (n,)."""
        rows = np.arange(len(self.start) - 1)
        ends = [lag.value[1:] for lag in self.lags]
        if self.kind == "play":
            return self._clipped(rows, ends)
        gained = self._law(0.0, rows, ends)  # the law is linear in the state
        decay = self._law(1.0, rows, ends) - gained
        decay[self.restarts], gained[self.restarts] = 0.0, self.start[self.restarts + 1]
        return recursion(self.start[0], decay, gained)

    def _clipped(self, rows: IntArray, ends: list[FloatArray]) -> FloatArray:
        """Return the values at the rows, those of parts of the rows at once.

        The law adds a way and clips. Any start of a part leads to its sum with the way so far, clipped to what the
        least and the largest start lead to.
        """
        path = self.lags[0].value if len(self.lags) == 1 else np.hypot(*(lag.value for lag in self.lags))
        way, least, most = np.diff(path) * self.rate[:-1], self._law(-1.0, rows, ends), np.ones(len(rows))
        least[self.restarts] = most[self.restarts] = self.start[self.restarts + 1]
        length = int(np.sqrt(len(rows))) + 1
        limited = (way.clip(-2.0, 2.0), least, most)  # from end to end
        ways, lowest, highest = (np.pad(row, (0, -len(row) % length)).reshape(-1, length).T for row in limited)
        moved, reached = np.cumsum(ways, axis=0), np.empty((length, 2, ways.shape[1]))
        extremes: FloatArray = np.array([[-np.inf], [np.inf]])
        for k in range(length):
            reached[k] = extremes = np.minimum(highest[k], np.maximum(extremes + ways[k], lowest[k]))
        begins = [float(self.start[0])]
        for way_of_part, (low, high) in zip(moved[-1].tolist(), extremes.T.tolist(), strict=True):
            begins.append(min(high, max(begins[-1] + way_of_part, low)))
        values = np.clip(begins[:-1] + moved, reached[:, 0], reached[:, 1]).T.ravel()[: len(rows)]
        return np.concatenate([begins[:1], values])

    def between(self, interval: IntArray, share: FloatArray) -> FloatArray:
        """Return the values at shares (0 to 1) of the intervals that begin at rows, shape (m,)."""
        return self._law(self.value[interval], interval, [lag.between(interval, share) for lag in self.lags])
