"""Errors of stiffness and friction between the conditions in which both are read from the data.

In each operating condition the tire differs from the reading by an error and the noise of the reading. The error is a
function of load, camber and pressure: a Gaussian process, whose size follows from the differences. Half of it is
smooth; the other half differs between levels, as the state of a tire does between the parts of a test. Between
conditions it is interpolated. Beyond them it goes on with its slope, as no reading shows that it returns: its variance
grows with the square of the distance, from that which a formula has without readings, as the coefficients follow them.
What the readings show as an error of the tire is in the interval, too (Rasmussen and Williams, Gaussian Processes for
Machine Learning, 2006, eqs. 2.23 and 2.24).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import pandas as pd

from ...numerics.arrays import FloatArray
from .slip_stiffness import MODEL_ERROR

#: Inputs of the process. Its length scale is half the range of the readings, at least a share of their largest value
#: and at least a camber, rad.
INPUTS, LEAST_SHARE, LEAST_CAMBER = ("Fz", "gamma", "p"), 0.25, 0.05
#: Least relative standard deviation of a reading: repeated measurements of a tire differ by 1 to 2 %.
READING_ERROR = 0.015
#: Length scale of the part that differs between levels, relative to that of the smooth part.
ROUGH = 0.25
#: Fewest readings.
MIN_READINGS = 3


@dataclass(frozen=True, eq=False)
class ReadErrors:
    """Relative errors of a tire in operating conditions.

    - `conditions`: a row for each, with the columns `INPUTS` that are known.
    - `error`, `deviation`, shape (n,): tire over reading minus 1, and the standard deviation of the reading.
    """

    conditions: pd.DataFrame
    error: FloatArray
    deviation: FloatArray

    @classmethod
    def of(cls, conditions: pd.DataFrame, error: Sequence[float], deviation: Sequence[float]) -> ReadErrors | None:
        """Return the errors of readings; None if they are too few.

        >>> loads = pd.DataFrame({"Fz": [500.0, 1000.0, 1500.0, 2000.0]})
        >>> errors = ReadErrors.of(loads, [0.01, -0.01, 0.01, 0.0], [0.02] * 4)
        >>> near, far = errors.squares(pd.DataFrame({"Fz": [1200.0, 6000.0]})) ** 0.5
        >>> bool(near < 0.3 * far)
        True
        """
        if len(error) < MIN_READINGS:
            return None
        return cls(conditions, np.asarray(error), np.hypot(deviation, READING_ERROR))

    def squares(self, conditions: pd.DataFrame) -> FloatArray:
        """Return the expected square of the relative error in conditions, shape (n,)."""
        among, between = self._kernel(self.conditions), self._kernel(conditions)
        prior = self._variance(among)
        gain = np.linalg.solve(prior * among + np.diag(self.deviation**2), prior * between.T)
        mean = self.error @ gain
        interpolated = np.maximum(prior - prior * np.sum(between.T * gain, axis=0), 0.0)
        beyond = max(prior, MODEL_ERROR**2) * self._growth(conditions)  # readings elsewhere do not show less
        return np.asarray(mean**2 + interpolated + beyond)

    def _variance(self, among: FloatArray) -> float:
        """Return the variance of the process: what the readings show, and a typical one with the weight of few of them.

        `among`: the correlations of the readings, from which the number of independent ones follows.
        """
        shown = max(float(np.mean(self.error**2) - np.mean(self.deviation**2)), 0.0)
        independent = len(among) ** 2 / float(np.sum(among**2))
        return (independent * shown + MIN_READINGS * MODEL_ERROR**2) / (independent + MIN_READINGS)

    def _growth(self, conditions: pd.DataFrame) -> FloatArray:
        """Return the mean square of the change beyond the readings by the slope of the process, in its variances."""
        squares = np.zeros(len(conditions))
        for name, scale in self._scales(conditions).items():
            read, at = (table[name].abs().to_numpy(dtype=float) for table in (self.conditions, conditions))
            squares += ((at - np.clip(at, read.min(), read.max())) / scale) ** 2
        return np.asarray(0.5 * (1.0 + 1.0 / ROUGH**2) * squares)

    def _scales(self, conditions: pd.DataFrame) -> dict[str, float]:
        """Return the length scale of the smooth part in each input that is known."""
        scales = {}
        for name in (name for name in INPUTS if name in self.conditions and name in conditions):
            read = self.conditions[name].abs()
            least = LEAST_CAMBER if name == "gamma" else LEAST_SHARE * float(read.max())
            scales[name] = max(0.5 * float(read.max() - read.min()), least)
        return scales

    def _kernel(self, conditions: pd.DataFrame) -> FloatArray:
        """Return the correlations of conditions with the readings, shape (n, n_readings)."""
        squares = np.zeros((len(conditions), len(self.conditions)))
        for name, scale in self._scales(conditions).items():
            read, at = (table[name].abs().to_numpy(dtype=float) for table in (self.conditions, conditions))
            squares += ((at[:, None] - read) / scale) ** 2
        return np.asarray(0.5 * (np.exp(-0.5 * squares) + np.exp(-0.5 * squares / ROUGH**2)))
