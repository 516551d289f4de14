"""The time history of an oscillator. Its position and speed are two states (`tirefmu.symbolic.laws.oscillator`)."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
import numpy.typing as npt

from ..code.modules import state_laws

FloatArray = npt.NDArray[np.float64]
IntArray = npt.NDArray[np.intp]
Values = float | FloatArray


@dataclass(frozen=True)
class Oscillation:
    """The time history of an oscillator over a recording. Its target and rates follow the inputs.

    - `target`, `frequency`, `damping`, shape (n,).
    - `h`, shape (n - 1,): steps, s; after a negative step, a new recording begins with the start value there.
    - `start`, shape (n,).
    - `hold`: inputs are held from each row to the next; otherwise they are linear.
    """

    target: FloatArray
    frequency: FloatArray
    damping: FloatArray
    h: FloatArray
    start: FloatArray
    hold: bool

    def _ends(
        self, interval: IntArray, share: FloatArray, position: FloatArray, speed: FloatArray, follows: Values = 1.0
    ) -> FloatArray:
        """Return position and speed, shape (2, ..., m), at shares of the intervals that begin at rows.

        `interval`, shape (m,). `share`, shape (m,). `position`, `speed`, shape (..., m or 1): at the rows. `follows`,
        shape (..., 1): 0 without a target.
        """
        h = np.maximum(self.h[interval], 0.0) * share
        first = np.stack([self.target, self.frequency, self.damping])[:, interval]
        last = first
        if not self.hold:
            following = np.stack([self.target, self.frequency, self.damping])[:, interval + 1]
            last = first + (following - first) * share
        mean = (first + last) / 2.0
        targets = (follows * target for target in (first[0], mean[0], last[0]))
        given = (position, speed, *targets, mean[1] * h, mean[2] * h, h)
        return np.stack([state_laws.oscillator(*given), state_laws.oscillator_speed(*given)])

    @cached_property
    def values(self) -> FloatArray:
        """Position and speed at the rows, shape (2, n)."""
        from scipy.linalg.blas import dtbsv  # loaded here: most evaluations have no memory

        n = len(self.h)
        interval, whole, again = np.arange(n), np.ones(n), self.h < 0.0
        # The law is linear in target, position and speed.
        unit = np.eye(3)[:, :, None]
        of_target, of_position, of_speed = np.moveaxis(self._ends(interval, whole, unit[1], unit[2], unit[0]), 1, 0)
        gained = np.where(again, np.stack([self.start[1:], np.zeros(n)]), of_target)
        of_position, of_speed = (np.where(again, 0.0, ends) for ends in (of_position, of_speed))
        # Position and speed alternate; a row of the band has their contributions to those of the next row.
        band = np.zeros((4, 2 * n + 2), order="F")
        band[2, :-2:2], band[3, :-2:2] = -of_position
        band[1, 1:-2:2], band[2, 1:-2:2] = -of_speed
        right = np.concatenate([[[self.start[0]], [0.0]], gained], axis=1).T.ravel()
        return np.asarray(dtbsv(3, band, right, lower=1, diag=1)).reshape(-1, 2).T

    def between(self, interval: IntArray, share: FloatArray) -> FloatArray:
        """Return position and speed at shares (0 to 1) of the intervals that begin at rows, shape (2, m)."""
        return self._ends(interval, share, *self.values[:, interval])


@dataclass(frozen=True)
class Part:
    """Position (0) or speed (1) of an oscillation, as the time history of a state."""

    whole: Oscillation
    index: int

    @property
    def value(self) -> FloatArray:
        """The values at the rows, shape (n,)."""
        return np.asarray(self.whole.values[self.index])

    @property
    def rate(self) -> FloatArray:
        """The frequency or the damping at the rows, shape (n,), 1/s."""
        return self.whole.damping if self.index else self.whole.frequency

    def between(self, interval: IntArray, share: FloatArray) -> FloatArray:
        """Return the values at shares of intervals, shape (m,)."""
        return np.asarray(self.whole.between(interval, share)[self.index])
