"""Which effect of the library the tires of a drive lack: estimates with each of them compared.

An explanation is an estimate of the whole drive: without an effect, or with one whose coefficients are unknowns like
the factors of the tires. Its evidence integrates over the motion, the car, the factors and these coefficients, with the
unexplained force that it needs. Residuals that are correlated over time count as fewer.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt

from tirefmu.estimation.correlation import correlation_length
from tirefmu.tires import Tire

from .effects import Missing, effect_columns, factor_values, motion_of
from .estimate import Added, Estimate, Forces
from .inputs.car import Car
from .inputs.grid import Grid
from .interval import BALANCE
from .rivals import evidence_of, probabilities_of
from .unknowns import Unknowns

FloatArray = npt.NDArray[np.float64]

#: Effects that are compared by an estimate of their own. Convention: computing time.
COMPARED = 4
#: Gives the grid and the estimate with the forces of an effect.
Refit = Callable[[Forces], tuple[Grid, Estimate]]


@dataclass(frozen=True)
class Explanation:
    """An estimate with an effect, or without one: `missing` is None."""

    missing: Missing | None
    grid: Grid
    estimate: Estimate
    probability: float = 0.0


def explanations(
    base: Explanation, unknowns: Unknowns, car: Car, tires: dict[str, Tire], refit: Refit
) -> list[Explanation]:
    """Return the estimate without an effect and those with the most likely ones, with their probabilities.

    Likely ones first.
    """
    if not base.estimate.converged:
        return [replace(base, probability=1.0)]
    compared = [base]
    for missing in _shortlist(base, unknowns, car, tires):
        try:
            compared.append(Explanation(missing, *refit(_forces(missing, unknowns, car, base))))
        except np.linalg.LinAlgError:
            continue
    logs = np.array([_evidence(explanation, unknowns) for explanation in compared])
    best = compared[int(np.argmax(logs))]
    residuals = best.estimate.residuals.values[:, -len(BALANCE) :].T
    length = np.mean([correlation_length(row, best.grid.segment) for row in residuals])
    logs = (logs - logs.max()) / length + [one.missing.log_prior if one.missing else 0.0 for one in compared]
    share = np.exp(logs - logs.max())
    ranked = zip(compared, share / share.sum(), strict=True)
    return sorted((replace(one, probability=float(p)) for one, p in ranked), key=lambda one: -one.probability)


def lacking(ranked: Sequence[Explanation]) -> float:
    """Return the probability that the tires lack an effect of the library."""
    return sum(explanation.probability for explanation in ranked if explanation.missing)


def _evidence(explanation: Explanation, unknowns: Unknowns) -> float:
    estimate = explanation.estimate
    return estimate.evidence + probabilities_of(explanation.grid, estimate, unknowns).wrong_car


def _forces(missing: Missing, unknowns: Unknowns, car: Car, base: Explanation) -> Forces:
    """Return the forces of an effect over the motion that is estimated so far."""

    def forces(grid: Grid, states: FloatArray, z: FloatArray) -> Added:
        n, so_far = len(unknowns), replace(base.estimate, states=states, z=z)
        u = z[n:] if len(z) > n else np.zeros(len(missing.center))
        return missing.forces(motion_of(grid, so_far, unknowns, car), u, factor_values(unknowns, z))

    return forces


def _shortlist(base: Explanation, unknowns: Unknowns, car: Car, tires: dict[str, Tire]) -> list[Missing]:
    """Return the effects that raise the evidence of the linearized estimate most, if any do, in their best form."""
    motion = motion_of(base.grid, base.estimate, unknowns, car)
    columns = effect_columns(motion, tires, factor_values(unknowns, base.estimate.z))
    if not columns:
        return []
    information, score = base.estimate.information(base.grid, np.stack([column for _, column in columns], axis=2))
    without = evidence_of(information, score, np.repeat([1.0, 0.0], [len(base.estimate.z), len(columns)]))
    n, gains = len(base.estimate.z), dict[str, tuple[float, Missing]]()
    for i, (missing, _) in enumerate(columns):
        spread = np.concatenate([np.ones(n), np.arange(len(columns)) == i])
        gain = evidence_of(information, score, spread) - without
        if gain > gains.get(missing.name, (0.0, missing))[0]:
            gains[missing.name] = gain, missing
    return [missing for _, missing in sorted(gains.values(), key=lambda pair: -pair[0])[:COMPARED]]
