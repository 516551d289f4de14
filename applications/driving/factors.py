"""Scaling factors with intervals, whether the drive determines them, and the tires that have them."""

from __future__ import annotations

from collections.abc import Mapping, Set
from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt

from ...measurements.checks.recordings.coverage import lacking_peak
from ...tires import Tire
from .estimate import Estimate
from .inputs.unknowns import AXLES, CHANGED, FACTORS, SAME, Unknowns
from .interval import OUTPUTS

FloatArray = npt.NDArray[np.float64]

#: Posterior probability at which a change of a tire, a wrong entry of the car or an effect is a finding.
CERTAIN = 0.95
#: Normal deviate of 95 %.
WIDTH = 1.96
#: A factor is determined if the standard deviation of its logarithm is at most this, and a friction factor only if the
#: side force exceeds `PEAK_SHARE` of the peak (at a factor one standard deviation higher) for this time, s.
MAX_SPREAD, PEAK_TIME = 0.1, 0.5
#: Share of the largest side force to one side that an axle must reach to the other one. Turns to one side do not
#: separate a tire from an asymmetry of steering, road or sensors, so that ISO 4138 requires both. Judgement: half.
OTHER_SIDE = 0.5
#: Slip angles at which a peak is sought, rad.
_SLIPS = np.linspace(-0.6, 0.6, 241)


@dataclass(frozen=True)
class Factor:
    """A factor of an axle, relative to the tire of the file.

    `value`, `low`, `high`: estimate and 95 % interval. `determined`: whether the drive determines it; `reason`: why
    not. `changed`: the probability that it differs from 1.
    """

    value: float
    low: float
    high: float
    determined: bool
    reason: str
    changed: float

    @property
    def differs(self) -> bool:
        """Whether the drive states that it differs from 1, by more than two tires of one kind do."""
        return self.determined and self.changed > CERTAIN and self.beyond

    @property
    def beyond(self) -> bool:
        """Whether its interval excludes what two tires of one kind differ by."""
        return self.low > 1.0 + SAME or self.high < 1.0 - SAME

    @property
    def informed(self) -> bool:
        """Whether the drive has information on it: it gives the forces over the slip that was reached."""
        return bool(np.log(self.high / self.low) <= 2.0 * WIDTH * MAX_SPREAD)


def factors_of(
    estimate: Estimate, unknowns: Unknowns, tires: Mapping[str, Tire], step: float,
    changed: Mapping[tuple[str, str], float],
) -> dict[str, dict[str, Factor]]:  # fmt: skip
    """Return the factors by axle and name.

    `step`: length of an interval, s. `changed`: probabilities of changes, by default `CHANGED`.
    """
    deviation = np.sqrt(np.diag(estimate.covariance))
    result: dict[str, dict[str, Factor]] = {axle: {} for axle in AXLES}
    for axle in AXLES:
        one_sided = _is_one_sided(estimate, axle, step)
        for name in FACTORS:
            i = unknowns.factor(axle, name)
            center, spread = unknowns.spread[i] * estimate.z[i], unknowns.spread[i] * deviation[i]
            low, value, high = (float(np.exp(center + k * WIDTH * spread)) for k in (-1, 0, 1))
            reason = "" if spread <= MAX_SPREAD else "the drive has too little information on it"
            if not reason and one_sided:
                reason = "the car turns to one side only: an asymmetry is confounded with it"
            if not reason and name == "LMUY":
                share = used_share(estimate, axle, tires[axle], float(np.exp(center + spread)))
                reason = lacking_peak("Fy", _exceeded(share, step))
            result[axle][name] = Factor(value, low, high, not reason, reason, changed.get((axle, name), CHANGED))
    return result


def _is_one_sided(estimate: Estimate, axle: str, step: float) -> bool:
    """Return whether an axle has much larger side forces to one side than to the other one."""
    Fy, Fz = (estimate.outputs[:, OUTPUTS.index(f"{name}_{axle}")] for name in ("Fy", "Fz"))
    less, more = sorted(_exceeded(side * Fy / Fz, step) for side in (-1.0, 1.0))
    return less < OTHER_SIDE * more


def _exceeded(share: FloatArray, step: float) -> float:
    """Return what a share of a force is above for `PEAK_TIME`."""
    rows = max(round(PEAK_TIME / step), 1)
    return float(np.sort(share)[-rows]) if len(share) >= rows else 0.0


def believed(
    factors: Mapping[str, Mapping[str, Factor]], certain: Set[tuple[str, str]]
) -> dict[str, dict[str, Factor]]:  # fmt: skip
    """Return the factors with the probabilities that prediction leaves.

    The evidence has one vote and prediction the other: what the evidence calls changed, but what does not predict, is
    at most as likely as not.
    """
    doubted = {
        (axle, name): replace(factor, changed=factor.changed / 2)
        for axle, row in factors.items()
        for name, factor in row.items()
        if factor.changed > CHANGED and (axle, name) not in certain
    }
    return {
        axle: {name: doubted.get((axle, name), factor) for name, factor in row.items()} for axle, row in factors.items()
    }


def withheld(factors: Mapping[str, Mapping[str, Factor]], reason: str) -> dict[str, dict[str, Factor]]:
    """Return the factors as not determined, for a further reason.

    Intervals assume that the model of the car is right and that the estimate is at its optimum.
    """
    return {
        axle: {name: replace(factor, determined=False, reason=factor.reason or reason) for name, factor in row.items()}
        for axle, row in factors.items()
    }


def used_share(estimate: Estimate, axle: str, tire: Tire, friction: float) -> FloatArray:
    """Return the side force over its peak for a friction factor, shape (n,)."""
    Fy, Fz = (estimate.outputs[:, OUTPUTS.index(f"{name}_{axle}")] for name in ("Fy", "Fz"))
    scaled = tire.with_values(LMUY=tire.values["LMUY"] * friction)
    loads = np.linspace(max(Fz.min(), 0.05 * Fz.max()), Fz.max() * 1.001, 9)
    curves = scaled.forces(alpha=_SLIPS[:, None], Fz=loads[None, :], code="numpy")["Fy"]
    return np.asarray(np.abs(Fy) / np.interp(Fz, loads, np.abs(curves).max(axis=0)))


def scaled_tires(tires: Mapping[str, Tire], factors: Mapping[str, Mapping[str, Factor]]) -> dict[str, Tire]:
    """Return the tires with the factors on which the drive has information in their scaling coefficients.

    LMUY that is not determined for want of a peak is one: LKY without it would not give the forces of the drive.
    """
    return {
        axle: tire.with_values(
            **{name: tire.values[name] * factors[axle][name].value for name in FACTORS if factors[axle][name].informed}
        )
        for axle, tire in tires.items()
    }
