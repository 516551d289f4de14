"""The program of a bench that determines a tire best in a given time, and what it determines."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any

import numpy as np
import numpy.typing as npt

from tirefmu.boundary.json_schema import json_value
from tirefmu.fitting.evidence.residuals import Residuals
from tirefmu.fitting.evidence.undetermined import undetermined
from tirefmu.measurements import Recording, VirtualBench
from tirefmu.tires import TireLike, tire_from

from .aims import Target, targets
from .bench_file import Bench, Heat, PlanError
from .information import (
    Experiment,
    Information,
    channel_weights,
    covariances,
    energies,
    fisher,
    information,
    inverse_of,
    tires_around,
)
from .maneuvers import Maneuver, held_levels, library, neighbors
from .plan_content import VERSION, PlanContent, Separation
from .program import TestProgram, cost, ordered
from .selection import Selection

FloatArray = npt.NDArray[np.float64]
#: An aim with a wider relative 95 % interval (half width) is not determined: nothing is known to a factor of two.
UNDETERMINED = 0.5
#: Number of repetitions of the whole library that an aim may need.
MANY = 100.0
#: A coefficient is not determined if its standard deviation exceeds this share of its typical size.
SIZE_SHARE = 0.5
#: Widths that differ by a smaller share are equal.
EQUAL = 0.05
#: Seconds of a recorded program that count as one maneuver.
PART = 10.0
#: Largest number of variants in the refinement; rounds in which its time is adjusted, until this share is used.
VARIANTS, ROUNDS, CLOSE = 300, 4, 0.96
Progress = Callable[[str, float], None]


@dataclass(frozen=True, eq=False)
class Prediction:
    """What a program determines.

    - `name`: of the program.
    - `seconds`: bench time.
    - `times`, shape (m,): middle of each maneuver, s.
    """

    name: str
    seconds: float
    times: FloatArray
    information: Information
    experiment: Experiment
    targets: tuple[Target, ...]

    @cached_property
    def covariances(self) -> FloatArray:
        """Of the coefficients in sizes, by tire, shape (t, p, p)."""
        return covariances(self.experiment, self.information, self.times)

    @cached_property
    def widths(self) -> dict[str, float]:
        """Relative half width of the 95 % interval of each target, root mean square over its operating points."""
        return {target.name: target.width(self.covariances) for target in self.targets}

    def over_time(self) -> list[tuple[float, dict[str, float]]]:
        """Return the widths after each minute of the program."""
        minutes = np.arange(60.0, self.seconds + 60.0, 60.0)
        found = []
        for end in minutes:
            done = np.flatnonzero(self.times <= end).tolist()
            if done:
                part = Prediction("", float(end), self.times[done], self.information.take(done), self.experiment,
                                  self.targets)  # fmt: skip
                found.append((float(min(end, self.seconds)), part.widths))
        return found

    def undetermined(self) -> dict[str, float]:
        """Return the standard deviation, in typical sizes, of each coefficient that the program does not determine."""
        deviation = np.sqrt(np.einsum("tpp->tp", self.covariances).mean(axis=0))
        return {n: float(d) for n, d in zip(self.experiment.free, deviation, strict=True) if d > SIZE_SHARE}


@dataclass(frozen=True, eq=False)
class PlanResult:
    """A planned program.

    Attributes
    ----------
    program : TestProgram
        The steps in their order.
    prediction : Prediction, optional
        What it determines; none for a program that separates effects.
    today : Prediction, optional
        The same of the program to which it is compared.
    undetermined : dict of str to str
        Coefficients that remain undetermined, and why.
    aims : tuple of str
    separations : tuple of Separation
        How well the program separates effects.
    """

    program: TestProgram
    aims: tuple[str, ...]
    prediction: Prediction | None = None
    today: Prediction | None = None
    undetermined: Mapping[str, str] = field(default_factory=dict)
    separations: tuple[Separation, ...] = ()

    def equal_after(self) -> float | None:
        """Return the bench time after which every interval is as wide as that of today's program or narrower, s.

        A difference of `EQUAL` counts as equal: offsets of the bench limit some intervals of all programs.
        """
        if self.today is None or self.prediction is None:
            return None
        for seconds, widths in self.prediction.over_time():
            if all(widths[name] <= (1.0 + EQUAL) * self.today.widths[name] for name in widths):
                return seconds
        return None

    def to_json(self) -> dict[str, Any]:
        """Return the contents of plan.json; a number that is not finite is null."""
        content: PlanContent = {
            "version": VERSION, "ok": True,
            "seconds": self.program.seconds, "steps": len(self.program.steps), "aims": list(self.aims),
            "intervals": self.prediction.widths if self.prediction else {},
            "over_time": [
                {"seconds": s, "intervals": w} for s, w in (self.prediction.over_time() if self.prediction else ())
            ],
            "undetermined": dict(self.undetermined),
            "compared": None if self.today is None else {
                "name": self.today.name, "seconds": self.today.seconds, "intervals": self.today.widths,
                "equal_after": self.equal_after(),
            },
            "separations": self.separations,
        }  # fmt: skip
        return dict(json_value(content))


def plan(
    tire: TireLike | Sequence[TireLike],
    bench: Bench,
    *,
    aims: Sequence[str] = ("all",),
    minutes: float = 20.0,
    today: Recording | None = None,
    progress: Progress | None = None,
) -> PlanResult:
    """Plan the program that determines a tire best in a given bench time.

    Parameters
    ----------
    tire : Tire, path or published name, or a sequence of them
        What is known of the tire; several of one model: a family, over which the program is averaged. Otherwise random
        tires around it are.
    bench : Bench
        What the bench can do.
    aims : sequence of str
        "all", "forces", "friction", "stiffness", or names of coefficients.
    minutes : float
        Bench time, with warm-up and pauses.
    today : Recording, optional
        A program of inputs over time to compare with.
    progress : callable, optional
        Called with the activity and the share of the bench time that is planned.

    Returns
    -------
    PlanResult

    Raises
    ------
    PlanError
        If the time is too short, or no program on this bench determines an aim.
    UnknownName
        If an aim does not exist.

    Examples
    --------
    >>> from tirefmu.planning.bench_file import Limits
    >>> bench = Bench({"Fz": Limits(220.0, 1120.0, 3.0, levels=2), "alpha": Limits(-0.2, 0.2, 2.0, 0.14)})
    >>> result = plan("trento_hoosier", bench, aims=["stiffness"], minutes=2.0)
    >>> result.program.seconds <= 120.0, list(result.prediction.widths)
    (True, ['stiffness_y'])
    """
    report = progress or (lambda what, share: None)
    experiment = Experiment(_tires(tire), bench.noise)
    wanted = targets(experiment, bench, aims)
    if not wanted:
        raise PlanError(f"no slip of this bench has an influence on {', '.join(aims)}")
    report("library of maneuvers", 0.0)
    budget = 60.0 * minutes - bench.warm_up
    current = _predicted(experiment, today, wanted, bench) if today is not None else None
    compared = current.covariances if current is not None else None
    selection, maneuvers = _selection(experiment, library(bench, experiment.tires[0]), wanted, bench, budget, compared)
    _check_aims(selection, bench)
    chosen = selection.chosen([], lambda share: report("choosing maneuvers", share))
    if not chosen:
        raise PlanError(f"{minutes:g} min are too short for one sweep after a warm-up of {bench.warm_up:g} s")
    report("refining", 0.0)
    distinct = list(dict.fromkeys(chosen))
    variants = dict.fromkeys(maneuvers[i] for i in distinct)
    variants |= dict.fromkeys(
        [v for i in distinct for v in neighbors(maneuvers[i], bench, experiment.tires[0])][:VARIANTS]
    )
    start = [maneuvers[i] for i in chosen]
    selection, maneuvers = _selection(experiment, list(variants), wanted, bench, budget, compared)
    program = _fitting_program(selection, maneuvers, [maneuvers.index(one) for one in start], bench, report)
    report("predicting intervals", 0.0)
    tables = [step.maneuver.table(bench.sample_rate) for step in program.steps]
    known = information(experiment, tables, channel_weights(experiment, tables))
    prediction = Prediction("plan", program.seconds, program.times, known, experiment, wanted)
    return PlanResult(program, tuple(aims), prediction, current, _reasons(prediction, program))


def _tires(tire: TireLike | Sequence[TireLike]) -> tuple[Any, ...]:
    if isinstance(tire, Sequence) and not isinstance(tire, str):
        tires = tuple(tire_from(one).in_signs("adapted-sae") for one in tire)
        if len({(one.model, one.has) for one in tires}) != 1:
            raise PlanError("the tires of a family must have one model with the same effects")
        return tires
    return tires_around(tire_from(tire))


def _selection(
    experiment: Experiment, maneuvers: list[Maneuver], wanted: tuple[Target, ...], bench: Bench, budget: float,
    compared: FloatArray | None,
) -> tuple[Selection, list[Maneuver]]:  # fmt: skip
    """Return the choice among maneuvers that do not heat the tread too much, and these maneuvers."""
    tables, energy = [one.table(bench.sample_rate) for one in maneuvers], np.zeros(len(maneuvers))
    if bench.heat != Heat():
        energy = energies(experiment, tables)
        kept = np.flatnonzero(energy <= bench.heat.energy_of_a_sweep)
        if not kept.size:
            raise PlanError(
                f"[heat] energy_of_a_sweep: every sweep has more sliding energy, {energy.min():.4g} J at least"
            )
        energy, maneuvers, tables = energy[kept], [maneuvers[i] for i in kept], [tables[i] for i in kept]
    nominal = held_levels(bench, experiment.tires[0])
    seconds = np.array([cost(one, bench, joule, nominal) for one, joule in zip(maneuvers, energy, strict=True)])
    spread = experiment.spread.values()
    offsets, drifts = (np.array([getattr(part, name) for part in spread]) for name in ("offset", "drift"))
    known = information(experiment, tables, channel_weights(experiment, tables)).with_independent(drifts)
    matrices = fisher(experiment, tables)
    return Selection(matrices, known, offsets, wanted, seconds, energy, budget, bench.heat.energy, compared), maneuvers


def _check_aims(selection: Selection, bench: Bench) -> None:
    """Raise for an aim that all maneuvers together, each many times, do not determine."""
    limit = inverse_of(MANY * selection.fisher.sum(axis=0))
    for target in selection.targets:
        p = target.rows.shape[-1]
        width = target.width(limit[:, :p, :p])
        if width > UNDETERMINED:
            raise PlanError(
                f"no program on this bench determines {target.name}: with all sweeps {MANY:g} times its 95 % interval "
                f"is +-{100.0 * width:.0f} %; {_lacking(bench, target)}"
            )


def _lacking(bench: Bench, target: Target) -> str:
    """Return which limit of the bench is the narrowest for a target."""
    slip = "kappa" if target.name.endswith("x") or target.name == "Fx" else "alpha"
    limits = bench.limits.get(slip)
    if limits is None or limits.rate == 0.0:
        return f"the bench does not sweep {slip}"
    return f"{slip} is limited to {limits.low:.3g} .. {limits.high:.3g}" + (
        "" if "Fz" in bench.limits else ", and the load does not vary"
    )


def _fitting_program(
    selection: Selection, maneuvers: list[Maneuver], start: list[int], bench: Bench, report: Progress
) -> TestProgram:
    """Exchange maneuvers with their variants and order them, with more or less time if changes need less or more."""
    budget, best = selection.budget, None
    for _ in range(ROUNDS):
        chosen = selection.chosen(start, lambda share: report("exchanging maneuvers", share))
        program = ordered([maneuvers[i] for i in chosen], selection.energy[chosen].tolist(), bench)
        used = program.seconds - bench.warm_up
        if used <= budget and (best is None or program.seconds > best.seconds):
            best = program
        if CLOSE * budget <= used <= budget:
            break
        allowed = selection.budget * min(0.99 * budget / used, 1.3)
        selection, start = replace(selection, budget=allowed), chosen if used <= budget else []
    if best is None:
        raise PlanError(f"{(budget + bench.warm_up) / 60.0:.3g} min are too short for the changes of this bench")
    return best


def _predicted(experiment: Experiment, program: Recording, wanted: tuple[Target, ...], bench: Bench) -> Prediction:
    """Return what a program of inputs over time determines; it is cut into parts of some seconds."""
    table = program.with_signs("adapted-sae").table
    for name in ("t", "kappa", "alpha"):
        if name not in table:
            raise PlanError(f"{program.source}: a program needs a column {name}")
    t = table["t"].to_numpy(float)
    groups = table.groupby([program.segment_numbers(), (t // PART).astype(int)], sort=False)
    parts = [rows.reset_index(drop=True) for _, rows in groups]
    times = np.array([float(part["t"].mean()) for part in parts])
    known = information(experiment, parts, channel_weights(experiment, parts))
    return Prediction(program.source, float(np.ptp(t)) + bench.warm_up, times, known, experiment, wanted)


def _reasons(prediction: Prediction, program: TestProgram) -> dict[str, str]:
    """Return why each coefficient that a program does not determine remains undetermined."""
    experiment, names = prediction.experiment, [(name,) for name in prediction.undetermined()]
    recording = VirtualBench(experiment.tires[0], experiment.noise).run(program.virtual).with_signs("adapted-sae")
    table = recording.table.assign(recording=0, segment=recording.segment_numbers())
    residuals = Residuals.of(table, (recording.source,), experiment.tires[0])
    rows = len(table) / experiment.correlation_factor(table["t"].to_numpy(float))
    effective = dict.fromkeys(experiment.channels, rows)
    found = undetermined(residuals, experiment.free, names, effective)
    return {name: one.reason for one in found for name in one.coefficients}
