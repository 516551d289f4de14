"""Whether the entries of a car together contradict its file."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.stats import chi2

from ..estimate import Estimate
from ..inputs.unknowns import Unknowns

#: Share of the variance of the file that a drive takes away from a combination of entries that it can contradict.
SEEN = 0.1
#: Information on an entry that is not in the file, relative to that of its uncertainty.
UNTOLD = 1e-4
#: Probability below which the deviation is a contradiction. Judgement: uncertainties of a file are approximate, and
#: one sensor at three standard deviations does not mean another car.
IMPROBABLE = 1e-6


@dataclass(frozen=True)
class Contradiction:
    """The joint deviation of the entries of a car from their file.

    - `deviation`: chi-squared: squares of the deviations of independent combinations of entries, over the variances
      that they have if the file is right. `degrees_of_freedom`: their number.
    - `p`: probability of a larger deviation if the file is right. `converged`: whether the estimate did.
    """

    deviation: float
    degrees_of_freedom: int
    p: float
    converged: bool

    @property
    def certain(self) -> bool:
        """Whether the drive contradicts the car: an estimate that is not at its optimum says nothing about it."""
        return self.converged and self.p < IMPROBABLE


def contradiction_of(estimate: Estimate, unknowns: Unknowns, without: str = "") -> Contradiction:
    """Return the joint deviation of an estimate.

    If the file is right, standardized deviations scatter about 0 with the part of their variance that the drive takes
    away. `without`: an entry of which the file says nothing; the others may then be elsewhere (linearized).
    """
    z, covariance = estimate.z, estimate.covariance
    kept = [i for i, name in enumerate(unknowns.car) if name != without]
    if without:
        precision = np.linalg.inv(covariance)
        free = precision - np.diag(np.arange(len(z)) == unknowns.car.index(without)).astype(np.float64) * (1.0 - UNTOLD)
        covariance = np.asarray(np.linalg.inv(free), dtype=np.float64)
        z = covariance @ (precision @ z)
    values, vectors = np.linalg.eigh(np.eye(len(kept)) - covariance[np.ix_(kept, kept)])
    seen = values > SEEN
    deviation = float(np.sum((vectors.T @ z[kept])[seen] ** 2 / values[seen]))
    degrees = int(seen.sum())
    return Contradiction(deviation, degrees, float(chi2.sf(deviation, max(degrees, 1))), estimate.converged)
