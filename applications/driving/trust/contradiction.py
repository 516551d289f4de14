"""Whether the entries of a car together contradict its file."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.stats import chi2

from ..estimate import Estimate
from ..inputs.unknowns import Unknowns

#: Share of the variance of the file that a drive takes away from a combination of entries that it can contradict.
SEEN = 0.1
#: Probability below which the deviation is a contradiction. Judgement: uncertainties of a file are rough, and a
#: sensor at three of them is no other car.
IMPROBABLE = 1e-6


@dataclass(frozen=True)
class Contradiction:
    """The joint deviation of the entries of a car from their file.

    - `deviation`: chi-squared: squares of the deviations of independent combinations of entries, over the variances
      that they have if the file is right. `degrees_of_freedom`: their number.
    - `p`: probability of a larger deviation if the file is right.
    """

    deviation: float
    degrees_of_freedom: int
    p: float

    @property
    def certain(self) -> bool:
        """Whether the drive contradicts the car."""
        return self.p < IMPROBABLE


def contradiction_of(estimate: Estimate, unknowns: Unknowns) -> Contradiction:
    """Return the joint deviation of an estimate.

    If the file is right, standardized deviations scatter about 0 with the part of their variance that the drive takes
    away.
    """
    n = len(unknowns.car)
    values, vectors = np.linalg.eigh(np.eye(n) - estimate.covariance[:n, :n])
    seen = values > SEEN
    deviation = float(np.sum((vectors.T @ estimate.z[:n])[seen] ** 2 / values[seen]))
    degrees = int(seen.sum())
    return Contradiction(deviation, degrees, float(chi2.sf(deviation, max(degrees, 1))))
