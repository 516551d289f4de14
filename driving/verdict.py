"""The verdict on a drive: what differs in the tires, what in the car, and what nothing explains."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from tirefmu.tires import Tire

from .estimate import Estimate
from .factors import Factor
from .inputs.car import Car
from .inputs.car_entries import ENTRIES
from .unknowns import AXLES, Unknowns

#: An entry of the car that is this many of its standard deviations from the file contradicts it.
CAR_DEVIATION = 3.0
#: Deviation of the balance of forces, per load, beyond which the tires do not explain the drive. The lateral force of a
#: repeated bench measurement scatters by 1 to 2 %.
UNEXPLAINED = 0.03
#: What a factor is.
MEANING = {
    "LMUX": "longitudinal friction", "LMUY": "friction",
    "LKX": "longitudinal slip stiffness", "LKY": "cornering stiffness",
}  # fmt: skip


@dataclass(frozen=True)
class Finding:
    """A difference of a tire: `axle`, `name` of the factor, `effect` ("friction is lower"), the factor."""

    axle: str
    name: str
    effect: str
    factor: Factor


@dataclass(frozen=True)
class CarFinding:
    """An entry of the car that contradicts its file: `name`, `value`, `given`, `deviation` in standard deviations."""

    name: str
    value: float
    given: float
    deviation: float


@dataclass(frozen=True)
class Verdict:
    """The verdict.

    - `tires`: findings. `car`: entries that contradict the car file.
    - `unknown`: axles whose side force the tires do not explain.
    - `lines`: the verdict in words.
    """

    tires: tuple[Finding, ...]
    car: tuple[CarFinding, ...]
    unknown: tuple[str, ...]
    lines: tuple[str, ...]


def verdict_on(
    car: Car,
    tires: Mapping[str, Tire],
    unknowns: Unknowns,
    estimate: Estimate,
    factors: Mapping[str, Mapping[str, Factor]],
) -> Verdict:
    """Return the verdict on a drive."""
    findings = tuple(
        Finding(axle, name, f"{MEANING[name]} is {'lower' if factor.value < 1.0 else 'higher'}", factor)
        for axle in AXLES
        for name, factor in factors[axle].items()
        if factor.changed
    )
    values = unknowns.car_values(estimate.z)
    of_car = tuple(
        CarFinding(name, values[name], car.values[name], float(z))
        for name, z in zip(unknowns.car, estimate.z, strict=False)
        if abs(z) > CAR_DEVIATION
    )
    unknown = tuple(axle for i, axle in enumerate(AXLES) if estimate.deviations[i] > UNEXPLAINED)
    return Verdict(findings, of_car, unknown, tuple(_lines(findings, of_car, unknown, factors, estimate)))


def _lines(
    findings: tuple[Finding, ...], of_car: tuple[CarFinding, ...], unknown: tuple[str, ...],
    factors: Mapping[str, Mapping[str, Factor]], estimate: Estimate,
) -> list[str]:  # fmt: skip
    lines = [
        f"{each.axle} axle: {each.effect} than in the tire file: {each.name} {each.factor.value:.3g} "
        f"({each.factor.low:.3g} to {each.factor.high:.3g})"
        for each in findings
    ]
    if not findings:
        lines.append("no difference of the tires from their files is determined")
    for axle in AXLES:
        open_factors = [name for name, factor in factors[axle].items() if not factor.determined]
        if open_factors:
            reason = factors[axle][open_factors[-1]].reason
            lines.append(f"{axle} axle: not determined: {', '.join(open_factors)}: {reason}")
    lines += [
        f"car: {ENTRIES[each.name].meaning} contradicts its file: {each.value:.4g} instead of {each.given:.4g} "
        f"{ENTRIES[each.name].unit}, {abs(each.deviation):.1f} standard deviations"
        for each in of_car
    ]
    lines += [
        f"{axle} axle: the motion requires side forces that no factor explains: "
        f"{100 * estimate.deviations[AXLES.index(axle)]:.2g} % of the load"
        for axle in unknown
    ]
    return lines if estimate.converged else [*lines, "the estimate did not converge: the numbers are rough"]


def worst_car_deviation(estimate: Estimate, unknowns: Unknowns) -> float:
    """Return the largest deviation of an entry of the car from its file, in standard deviations."""
    return float(np.max(np.abs(estimate.z[: len(unknowns.car)]), initial=0.0))
