"""The verdict on a drive: what differs in the tires, what in the car, and what nothing explains and where."""

from __future__ import annotations

from collections.abc import Mapping, Sequence, Set
from dataclasses import dataclass, replace
from typing import Annotated

import numpy as np
import numpy.typing as npt

from ...numerics.ties import graded
from .estimate import Estimate
from .factors import CERTAIN, WIDTH, Factor
from .inputs.car import Car
from .inputs.car_entries import ENTRIES
from .inputs.grid import Grid
from .inputs.unknowns import AXLES, Unknowns
from .interval import OUTPUTS
from .rivals import LIKELY, DriveExplanation, Rival, lacking
from .simulation import changes
from .trust.contradiction import Contradiction, chances_of_entries, contradiction_of
from .trust.left_out import LeftOut

FloatArray = npt.NDArray[np.float64]

#: Deviation of the balance of forces, per load, beyond which the tires do not explain the drive. The lateral force of a
#: repeated bench measurement scatters by 1 to 2 %.
UNEXPLAINED = 0.03
#: Entries that are named with a contradiction.
NAMED = 3
#: What a factor that a drive determines is.
MEANING = {"LMUY": "friction", "LKY": "cornering stiffness"}


@dataclass(frozen=True)
class TireDifference:
    """A difference of a tire: `axle`, `name` of the factor, `effect` ("friction is lower"), factor."""

    axle: str
    name: str
    effect: str
    factor: Factor


@dataclass(frozen=True)
class CarFinding:
    """An entry of the car that contradicts its file: `deviation` in standard deviations, `probability`."""

    name: str
    value: float
    given: float
    deviation: float
    probability: float


@dataclass(frozen=True)
class EffectFinding:
    """An effect that the tires may lack: `effect`, its coefficients, `probability`."""

    effect: str
    coefficients: Mapping[str, float]
    probability: float


@dataclass(frozen=True)
class DriveVerdict:
    """The verdict.

    - `car`: entries that contradict the car file; `check`: others that deviate further than any one of a right file
      would in 95 % of drives, while the rest agrees with it; `contradiction`: all of them together. `left_out`: how the
      tires predict, None for a drive too short for that.
    - `better`: whether something was found of the tires, and they predict better.
    - `unknown`: axles whose side force the tires do not explain.
    - `lines`: the verdict in words.
    """

    tires: Annotated[tuple[TireDifference, ...], "differences of the tires"]
    car: tuple[CarFinding, ...]
    check: tuple[CarFinding, ...]
    contradiction: Contradiction
    left_out: LeftOut | None
    effect: Annotated[str | None, "of the library, that the new tires have"]
    effects: Annotated[tuple[EffectFinding, ...], "of the library, likely ones first"]
    lacking: Annotated[float, "probability that the tires lack an effect of the library"]
    unknown: tuple[str, ...]
    lines: tuple[str, ...]

    @property
    def better(self) -> bool:
        """See the class."""
        return bool((self.tires or self.effect) and self.left_out and self.left_out.better)


def verdict_on(
    best: DriveExplanation,
    ranked: Sequence[Rival],
    unknowns: Unknowns,
    car: Car,
    factors: Mapping[str, Mapping[str, Factor]],
    certain: Set[tuple[str, str]],
    wrong: Mapping[str, float],
    contradiction: Contradiction,
    predicted: LeftOut | None,
    where: str,
) -> DriveVerdict:
    """Return the verdict on a drive.

    `best`: the answer; `ranked`: `rivals_of` the estimate without an effect. `certain`: axle and name of factors that
    are findings. `wrong`: probability of each entry of the car to be wrong. `where`: sentence of `disagreement`.
    """
    estimate = best.estimate
    findings = tuple(
        TireDifference(axle, name, f"{MEANING[name]} is {'lower' if factor.value < 1.0 else 'higher'}", factor)
        for axle in AXLES
        for name, factor in factors[axle].items()
        if (axle, name) in certain
    )
    of_car, check = car_findings(estimate, unknowns, car, wrong, contradiction)
    if contradiction.certain and not of_car and lacking(ranked) > CERTAIN:  # other tires explain more than another car
        contradiction = replace(contradiction, explained=False)
    # Prediction has one vote of two, as for the factors.
    vote = 1.0 if best.missing or lacking(ranked) < 0.5 else 0.5
    likely = tuple(
        EffectFinding(rival.missing.name, rival.missing.values(rival.u), vote * rival.probability)
        for rival in ranked
        if rival.missing and rival.probability > LIKELY
    )
    unknown = unexplained_axles(estimate)
    lines = [*_factor_lines(findings, factors), *_car_lines(of_car, check, unknown, estimate)]
    if best.missing:
        lines.insert(0, _effects_line(likely))
    elif likely:
        lines.append(_unidentified_line(likely))
    if contradiction.doubtful:
        lines.insert(0, _contradiction_line(contradiction, estimate, unknowns))
    if estimate.converged:
        lines += [where, _prediction_line(predicted, bool(findings or best.missing))]
    else:
        lines.insert(0, "the estimate did not converge: no conclusion about the tires or the car is possible")
    effect = best.missing.name if best.missing else None
    return DriveVerdict(
        findings, of_car, check, contradiction, predicted, effect, likely, vote * lacking(ranked), unknown, tuple(lines)
    )


def car_findings(
    estimate: Estimate, unknowns: Unknowns, car: Car, wrong: Mapping[str, float], contradiction: Contradiction
) -> tuple[tuple[CarFinding, ...], tuple[CarFinding, ...]]:
    """Return the entries of a car that are wrong in its file, and those to be checked: see `DriveVerdict`."""
    if not (contradiction.of_car or (estimate.converged and not contradiction.certain)):
        return (), ()
    values, chances = unknowns.car_values(car, estimate.z), chances_of_entries(estimate, unknowns)
    deviations = np.sqrt(np.diag(estimate.covariance))
    deviating = [
        CarFinding(name, values[name], car.values[name], float(z), wrong[name])
        for name, z, deviation in zip(unknowns.car, estimate.z, deviations, strict=False)
        if chances[name] < 1.0 - CERTAIN
        and abs(z) > WIDTH * deviation
        and contradiction_of(estimate, unknowns, name).p > 1.0 - CERTAIN
    ]
    in_error = tuple(entry for entry in deviating if entry.probability > CERTAIN)
    return in_error, tuple(entry for entry in deviating if entry not in in_error)


def unexplained_axles(estimate: Estimate) -> tuple[str, ...]:
    """Return the axles with side forces that neither factors nor entries of the car explain."""
    return tuple(axle for i, axle in enumerate(AXLES) if estimate.unexplained[i] > UNEXPLAINED)


def _contradiction_line(contradiction: Contradiction, estimate: Estimate, unknowns: Unknowns) -> str:
    deviations = np.abs(estimate.z[: len(unknowns.car)])
    strongest = [unknowns.car[i] for i in np.argsort(-deviations, kind="stable")[:NAMED]]
    numbers = (
        f"chi-squared {contradiction.deviation:.3g} with {contradiction.degrees_of_freedom} degrees of freedom "
        f"(p {contradiction.p:.1g}), most in {', '.join(strongest)}"
    )
    if not contradiction.certain:
        return f"the car deviates from its file more than expected ({numbers}): no difference of the tires is certain"
    if contradiction.unless:
        names = " or ".join(contradiction.unless)
        return (
            f"the drive contradicts the car file ({numbers}), or the tires lack {names}, with which the car agrees "
            "with its file: no further conclusion about the tires is possible"
        )
    if not contradiction.explained:
        return (
            f"the drive contradicts the car file ({numbers}), but another car does not explain it, and no effect of "
            "the tires is identified: no conclusion about the tires or the car is possible"
        )
    return f"the drive contradicts the car file: {numbers}: no conclusion about the tires is possible"


def _prediction_line(predicted: LeftOut | None, something: bool) -> str:
    if predicted is None:
        return "the drive is too short to test the prediction of left-out parts: no tire is written"
    numbers = f"rms errors: {changes(predicted.before, predicted.after)}"
    if not predicted.better:
        return f"new tires do not predict left-out parts of the drive better than the given ones ({numbers})"
    some = "new tires predict left-out parts of the drive better than the given ones"
    return f"{some} ({numbers})" if something else f"{some} ({numbers}), but no single difference is certain"


def _effects_line(likely: tuple[EffectFinding, ...]) -> str:
    first, *others = likely
    values = ", ".join(f"{name} {value:.3g}" for name, value in first.coefficients.items())
    line = f"the tires lack {first.effect} ({values}; probability {first.probability:.2f})"
    names = " or ".join(f"{finding.effect} ({finding.probability:.2f})" for finding in others)
    return f"{line}, or {names}: the drive does not separate them" if others else line


def _unidentified_line(likely: tuple[EffectFinding, ...]) -> str:
    names = ", ".join(f"{finding.effect} {finding.probability:.2f}" for finding in likely)
    return f"no effect that the tires lack is identified (probabilities: {names}; identified above {CERTAIN:g})"


def _factor_lines(findings: tuple[TireDifference, ...], factors: Mapping[str, Mapping[str, Factor]]) -> list[str]:
    """Return a line for each difference, then one for the other factors of each axle."""
    lines = [
        f"{d.axle} axle: {d.effect} than in the tire file: {d.name} {d.factor.value:.3g} "
        f"({d.factor.low:.3g} to {d.factor.high:.3g})"
        for d in findings
    ]
    if not findings:
        lines.append("no certain difference between the tires and their files")
    for axle in AXLES:
        by_reason: dict[str, list[str]] = {}
        for name, factor in factors[axle].items():
            if not factor.determined:
                by_reason.setdefault(f"not determined ({factor.reason})", []).append(name)
            elif factor not in [d.factor for d in findings if (d.axle, d.name) == (axle, name)]:
                text = f"{name} {factor.value:.3g} ({factor.low:.3g} to {factor.high:.3g})"
                certainty = f"a difference that is not certain (probability {factor.changed:.2f})"
                reason = certainty if factor.beyond else "no certain difference from the tire file"
                by_reason.setdefault(reason, []).append(text)
        lines += [f"{axle} axle: {', '.join(names)}: {reason}" for reason, names in by_reason.items()]
    return lines


def _car_lines(
    of_car: tuple[CarFinding, ...], check: tuple[CarFinding, ...], unknown: tuple[str, ...], estimate: Estimate
) -> list[str]:
    lines = [
        f"car: {_meaning(entry)} is {'higher' if entry.deviation > 0.0 else 'lower'} than in its file: "
        f"{_deviation(entry)}"
        for entry in of_car
    ]
    lines += [
        f"car: check the {_meaning(entry)}, which may be wrong in its file: {_deviation(entry)}" for entry in check
    ]
    lines += [
        f"{axle} axle: the motion requires side forces that no factor explains: "
        f"{100 * estimate.unexplained[AXLES.index(axle)]:.2g} % of the load"
        for axle in unknown
    ]
    return lines


def _meaning(entry: CarFinding) -> str:
    return ENTRIES[entry.name].meaning.partition(";")[0].partition(":")[0]


def _deviation(entry: CarFinding) -> str:
    unit = f" {ENTRIES[entry.name].unit}".removesuffix(" 1")
    instead = f"{entry.value:.4g} instead of {entry.given:.4g}{unit}"
    return f"{instead}, {abs(entry.deviation):.1f} standard deviations of the file"


#: Name and unit of an input, and what its value is multiplied by.
INPUTS = {
    "alpha": ("slip angle", " deg", 180.0 / np.pi), "kappa": ("longitudinal slip", "", 1.0), "Fz": ("load", " N", 1.0),
    "V": ("speed", " m/s", 1.0), "t": ("time in the log", " s", 1.0),
}  # fmt: skip
#: Groups of equal size into which an input is divided; length of a phase, s; acceleration that is one, m/s^2; share of
#: what one input explains from which another one explains as much.
GROUPS, PHASE, ACCELERATING, ALIKE = 8, 2.0, 1.0, 0.9


def disagreement(grid: Grid, estimate: Estimate, lacking: FloatArray, car: Car) -> str:
    """Return a sentence. `lacking`, shape (n, 2): side force that the motion requires beyond the tires, N."""
    shares = lacking / np.array(car.axle_loads)
    axle = int(np.argmax(graded(np.mean(shares**2, axis=0))))
    values = {
        name: estimate.outputs[:, OUTPUTS.index(f"{name}_{AXLES[axle]}")] for name in ("alpha", "kappa", "V", "Fz")
    }
    size = shares[:, axle]
    along = size * np.sign(values["alpha"])
    groups = {name: _groups(np.abs(values.get(name, grid.t))) for name in INPUTS}
    explained = {name: sum(len(rows) * np.mean(along[rows]) ** 2 for rows in groups[name]) for name in INPUTS}
    name = max(explained, key=lambda name: graded(explained[name]))
    others = [INPUTS[other][0] for other in INPUTS if other != name and explained[other] > ALIKE * explained[name]]
    strongest = max(groups[name], key=lambda rows: graded(float(np.mean(size[rows] ** 2))))
    meaning, unit, scale = INPUTS[name]
    low, high = scale * np.quantile(np.abs(values.get(name, grid.t))[strongest], [0.0, 1.0])
    number = (grid.t // PHASE).astype(np.intp) - int(grid.t[0] // PHASE)
    phase = np.flatnonzero(number == np.argmax(graded(np.bincount(number, size**2).astype(np.float64))))
    first, last = grid.t[phase[[0, -1]]]
    return (
        f"{AXLES[axle]} axle: the drive disagrees most with its tire file, by {100 * np.sqrt(np.mean(size**2)):.2g} % "
        f"of the load (rms); most from {first:.0f} to {last:.0f} s ({_motion(grid, estimate, phase)}), and at a "
        f"{meaning} of {_short(low)} to {_short(high)}{unit}; the {meaning} explains "
        f"{100 * explained[name] / np.sum(size**2):.0f} % of it"
        f"{f', as {_listed(others)} may' if others else ''}"
    )


def _short(number: float) -> str:
    return f"{number:.3g}" if abs(number) < 1e3 else f"{number:.0f}"


def _listed(names: Sequence[str]) -> str:
    return " and ".join([*([", ".join(f"the {name}" for name in names[:-1])] if names[1:] else []), f"the {names[-1]}"])


def _groups(values: FloatArray) -> list[npt.NDArray[np.intp]]:
    return np.array_split(np.argsort(values, kind="stable"), GROUPS)


def _motion(grid: Grid, estimate: Estimate, rows: npt.NDArray[np.intp]) -> str:
    """Return what the car does in some intervals."""
    ends = estimate.states[grid.left[rows]], estimate.states[grid.right[rows]]
    along = float(np.mean(ends[1][:, 0] - ends[0][:, 0])) / grid.step
    across = (ends[0][:, 0] + ends[1][:, 0]) * (ends[0][:, 2] + ends[1][:, 2]) / 4
    turn = "straight"
    if np.abs(across).max() > ACCELERATING:
        both = across.min() < -ACCELERATING and across.max() > ACCELERATING
        turn = "a change of direction" if both else f"a {'left' if across.mean() > 0.0 else 'right'} turn"
    pace = "braking in " if along < -ACCELERATING else "accelerating in " if along > ACCELERATING else ""
    return f"{pace}{turn}".replace("in straight", "straight ahead")
