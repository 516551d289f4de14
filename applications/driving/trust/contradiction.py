"""Whether the entries of a car together contradict its file."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated, ClassVar

import numpy as np
import numpy.typing as npt
from scipy.special import chdtrc, ndtr

from ..estimate import Estimate
from ..inputs.unknowns import Unknowns

FloatArray = npt.NDArray[np.float64]

#: Share of the variance of the file that a drive takes away from a combination of entries that it can contradict.
SEEN = 0.1
#: Information on an entry that is not in the file, relative to that of its uncertainty.
UNTOLD = 1e-4
#: Probability below which the deviation is a contradiction. Judgement: uncertainties of a file are approximate, and
#: one sensor at three standard deviations does not mean another car.
IMPROBABLE = 1e-6
#: Part of its uncertainty that an entry may have: those of a file are approximate, too large ones as well.
PART = 1 / 3


@dataclass(frozen=True)
class Contradiction:
    """The joint deviation of the entries of a car from their file.

    - `deviation`: chi-squared: squares of the deviations of independent combinations of entries, over the variances
      that they have if the file is right. `degrees_of_freedom`: their number.
    - `converged`: whether the estimate did.
    - `explained`: whether another car would explain the drive: no side forces remain, and tires explain no more.
    """

    JSON_KEYS: ClassVar = ("deviation", "degrees_of_freedom", "p", "explained", "unless")

    deviation: Annotated[float, "chi-squared"]
    degrees_of_freedom: int
    p: Annotated[float, "probability of a larger deviation if the file is right"]
    converged: bool
    unless: Annotated[tuple[str, ...], "effects with which the car agrees with its file, if the tires lack one"] = ()
    explained: Annotated[bool, "whether another car would explain the drive"] = True

    @property
    def certain(self) -> bool:
        """Whether car and tires together contradict the drive: an estimate beside its optimum states nothing."""
        return self.converged and self.p < IMPROBABLE

    @property
    def doubtful(self) -> bool:
        """Whether it were certain if an entry that deviates as expected had but a part of its uncertainty."""
        return _chance(self.deviation + 1.0 / PART**2 - 1.0, self.degrees_of_freedom) < IMPROBABLE

    @property
    def of_car(self) -> bool:
        """Whether it is the car that differs from its file: another one explains the drive, and no effect of tires."""
        return self.certain and self.explained and not self.unless


def contradiction_of(estimate: Estimate, unknowns: Unknowns, without: str = "") -> Contradiction:
    """Return the joint deviation of an estimate.

    If the file is right, standardized deviations scatter about 0 with the part of their variance that the drive takes
    away, and with what parts of the drive differ by. `without`: an entry of which the file states nothing; the others
    may then be elsewhere (linearized).
    """
    z, covariance = estimate.z, estimate.covariance - estimate.scatter
    kept = [i for i, name in enumerate(unknowns.car) if name != without]
    if without:
        precision = np.linalg.inv(covariance)
        free = precision - np.diag(np.arange(len(z)) == unknowns.car.index(without)).astype(np.float64) * (1.0 - UNTOLD)
        covariance = np.asarray(np.linalg.inv(free), dtype=np.float64)
        z = covariance @ (precision @ z)
    scatter = (estimate.scatter + np.zeros_like(covariance))[np.ix_(kept, kept)]
    deviation, degrees = joint_deviation(z[kept], covariance[np.ix_(kept, kept)], scatter)
    return Contradiction(deviation, degrees, _chance(deviation, degrees), estimate.converged)


def joint_deviation(z: FloatArray, covariance: FloatArray, scatter: FloatArray | float = 0.0) -> tuple[float, int]:
    """Return the joint deviation of standardized entries, shape (n,), and its degrees of freedom.

    `covariance`: of the posterior; `scatter`: more of it, of a model that is wrong.
    """
    values, vectors = np.linalg.eigh(np.eye(len(z)) - covariance)
    seen = vectors[:, values > SEEN]
    along, variance = seen.T @ z, seen.T @ (np.eye(len(z)) - covariance + scatter) @ seen
    return float(along @ np.linalg.solve(variance, along)), seen.shape[1]


def chances_of_entries(estimate: Estimate, unknowns: Unknowns) -> dict[str, float]:
    """Return for each entry the probability that any one of a right file deviates as far as it does.

    The joint deviation of many entries hides a single one. The bound for the largest of several normal variables holds
    for any correlation (Sidak, JASA 62, 1967).
    """
    n = len(unknowns.car)
    scatter = np.diag(estimate.scatter + np.zeros_like(estimate.covariance))[:n]
    variance = 1.0 - (np.diag(estimate.covariance)[:n] - scatter)
    seen = variance > SEEN
    alone = 2.0 * ndtr(-np.abs(estimate.z[:n]) / np.sqrt(np.where(seen, variance, np.inf) + scatter))
    any_one = -np.expm1(seen.sum() * np.log1p(-np.minimum(alone, 1.0 - 1e-16)))
    return dict(zip(unknowns.car, any_one.tolist(), strict=True))


def is_agreement(z: FloatArray, covariance: FloatArray) -> bool:
    """Return whether entries with a posterior covariance agree with their file; see `joint_deviation`."""
    return _chance(*joint_deviation(z, covariance)) >= IMPROBABLE


def _chance(deviation: float, degrees: int) -> float:
    return float(chdtrc(max(degrees, 1), deviation))
