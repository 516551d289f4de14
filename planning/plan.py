"""The program of a bench that determines a tire best in a given time, and what it determines."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import Annotated, Any, TypedDict

import numpy as np
import numpy.typing as npt

from tirefmu.boundary.json_schema import document, json_value, schema_of
from tirefmu.fitting.evidence.residuals import Residuals
from tirefmu.fitting.evidence.undetermined import undetermined
from tirefmu.measurements import Recording, VirtualBench
from tirefmu.tires import TireLike, tire_from

from .aims import Target, targets
from .bench_file import Bench, Heat, PlanError
from .information import (
    Experiment,
    Information,
    common_scores,
    covariances,
    energies,
    information,
    sandwich,
    tires_around,
)
from .maneuvers import Maneuver, held_levels, library
from .program import TestProgram, cost
from .selection import Selection

FloatArray = npt.NDArray[np.float64]
#: Version of plan.json. New keys increment the second number, changed meanings the first.
VERSION = "1.0"
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
#: Exchanges of two steps that are tried against drift.
TRIALS = 300
Progress = Callable[[str, float], None]


class TimedIntervals(TypedDict):
    """The predicted intervals after a bench time, s."""

    seconds: float
    intervals: dict[str, float]


class ComparedProgram(TypedDict):
    """The program of `--compare`, and after which bench time the planned one equals it."""

    name: str
    seconds: float
    intervals: dict[str, float]
    equal_after: Annotated[float | None, "s; null if it does not"]


@dataclass(frozen=True)
class Separation:
    """How well a program separates an effect from another one.

    - `effect`, `rival`: if the tire has the effect, and the rival is fitted instead.
    - `evidence`: expected logarithm of the likelihood ratio, for the form of the effect that is hardest to separate.
    - `alone`: the same against a tire whose coefficients are known and that lacks the effect, for the strongest form.
    """

    effect: str
    rival: str
    evidence: float
    alone: float


class PlanContent(TypedDict):
    """The keys of plan.json; see `PlanResult`."""

    version: str
    ok: bool
    seconds: Annotated[float, "bench time"]
    steps: int
    aims: list[str]
    intervals: Annotated[dict[str, float], "relative half widths of the predicted 95 % intervals by quantity"]
    over_time: list[TimedIntervals]
    undetermined: Annotated[dict[str, str], "coefficients that remain undetermined, and why"]
    compared: ComparedProgram | None
    separations: Sequence[Separation]


def plan_schema() -> dict[str, Any]:
    """Return the JSON Schema of plan.json."""
    return document("plan", VERSION, "Planned test program", schema_of(PlanContent, missing=True))


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
        found = []
        for end in np.arange(60.0, self.seconds + 60.0, 60.0).tolist():
            done = np.flatnonzero(self.times <= end).tolist()
            if done:
                covariance = covariances(self.experiment, self.information.take(done), self.times[done])
                widths = {target.name: target.width(covariance) for target in self.targets}
                found.append((min(end, self.seconds), widths))
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

    @cached_property
    def over_time(self) -> list[tuple[float, dict[str, float]]]:
        """The widths after each minute."""
        return self.prediction.over_time() if self.prediction else []

    @property
    def equal_after(self) -> float | None:
        """The bench time after which every interval is as wide as that of today's program or narrower, s.

        A difference of `EQUAL` counts as equal: offsets of the bench limit some intervals of all programs.
        """
        limits = {name: (1.0 + EQUAL) * width for name, width in (self.today.widths if self.today else {}).items()}
        equal = (time for time, widths in self.over_time if all(widths[name] <= limits[name] for name in limits))
        return next(equal, None) if limits else None

    def to_json(self) -> dict[str, Any]:
        """Return the contents of plan.json; a number that is not finite is null."""
        content: PlanContent = {
            "version": VERSION, "ok": True,
            "seconds": self.program.seconds, "steps": len(self.program.steps), "aims": list(self.aims),
            "intervals": self.prediction.widths if self.prediction else {},
            "over_time": [{"seconds": seconds, "intervals": widths} for seconds, widths in self.over_time],
            "undetermined": dict(self.undetermined),
            "compared": None if self.today is None else {
                "name": self.today.name, "seconds": self.today.seconds, "intervals": self.today.widths,
                "equal_after": self.equal_after,
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
    current = _predicted(experiment, today, wanted, bench) if today is not None else None
    report("library of maneuvers", 0.0)
    maneuvers, seconds, energy = affordable(experiment, library(bench, experiment.tires[0]), bench)
    known = information(experiment, [maneuver.table(bench.sample_rate) for maneuver in maneuvers])
    _check_aims(wanted, known, bench)
    criterion = _Criterion.between(experiment, wanted, current)
    parts = (known.products, criterion.with_drift(known))
    selection = Selection(maneuvers, parts, criterion, seconds, energy, bench.heat.energy)
    chosen = selection.chosen(bench, minutes, lambda share: report("choosing maneuvers", share))
    report("order against drift", 0.0)
    program = _against_drift(selection, criterion, chosen, known, experiment, bench, 60.0 * minutes)
    report("predicting intervals", 0.0)
    learned = information(experiment, program.tables)
    prediction = Prediction("plan", program.seconds, program.times, learned, experiment, wanted)
    return PlanResult(program, tuple(aims), prediction, current, _reasons(prediction, program))


def _tires(tire: TireLike | Sequence[TireLike]) -> tuple[Any, ...]:
    if isinstance(tire, Sequence) and not isinstance(tire, str):
        tires = tuple(tire_from(member).in_signs("adapted-sae") for member in tire)
        if len({(member.model, member.has) for member in tires}) != 1:
            raise PlanError("the tires of a family must have one model with the same effects")
        return tires
    return tires_around(tire_from(tire))


@dataclass(frozen=True, eq=False)
class _Criterion:
    """The criterion of a choice, of sums over its maneuvers.

    The sum over the targets of the logarithm of their mean relative variance in a fit, averaged over the tires
    (Chaloner and Verdinelli, Bayesian experimental design: a review, Statistical Science 10, 1995): halving the
    interval of one target counts as much as halving that of another. With a program to compare with, it is the sum of
    the squares of the ratios to its variances instead, to which a target that is determined worse contributes most.

    - `squares`, shape (n_targets, t, p, p): mean squares of the derivatives.
    - `offset`, `drift`, shape (k,): of the sources of noise; drift has an independent value in each maneuver.
    - `reference`, shape (n_targets, t): variances by the program to compare with; 1 without one.
    """

    squares: FloatArray
    offset: FloatArray
    drift: FloatArray
    reference: FloatArray | None

    @classmethod
    def between(cls, experiment: Experiment, wanted: Sequence[Target], current: Prediction | None) -> _Criterion:
        squares = np.array([target.squares for target in wanted])
        offset, drift = (np.array([getattr(part, name) for part in experiment.sources]) for name in ("offset", "drift"))
        return cls(squares, offset, drift, _traces(squares, current.covariances) if current else None)

    def with_drift(self, known: Information) -> FloatArray:
        """Return the noise of maneuvers with drift, shape (m, t, p, p)."""
        p = self.squares.shape[-1]
        return known.noise + common_scores(known.products[:, :, p:, :p], self.drift)

    def __call__(self, products: FloatArray, noise: FloatArray) -> float:
        p = self.squares.shape[-1]
        covariance = sandwich(products[:, :p, :p], noise + common_scores(products[:, p:, :p], self.offset))
        return self.of(covariance)

    def of(self, covariance: FloatArray) -> float:
        """Return the criterion of covariances of the coefficients, shape (t, p, p)."""
        variances = _traces(self.squares, covariance)
        if self.reference is None:
            return float(np.log(variances).mean(axis=1).sum())
        return float(np.square(variances / self.reference).mean(axis=1).sum())


def _traces(squares: FloatArray, covariance: FloatArray) -> FloatArray:
    return np.asarray(np.maximum(np.einsum("atpq,tpq->at", squares, covariance), 1e-30))


def affordable(
    experiment: Experiment, maneuvers: list[Maneuver], bench: Bench
) -> tuple[list[Maneuver], FloatArray, FloatArray]:
    """Return the maneuvers that do not heat the tread too much, with their bench time, s, and sliding energy, J."""
    energy = np.zeros(len(maneuvers))
    if bench.heat != Heat():
        energy = energies(experiment, [maneuver.table(bench.sample_rate) for maneuver in maneuvers])
        possible = np.flatnonzero(energy <= bench.heat.energy_of_a_sweep)
        if not possible.size:
            raise PlanError(
                f"[heat] energy_of_a_sweep: every sweep has more sliding energy, {energy.min():.4g} J at least"
            )
        maneuvers, energy = [maneuvers[i] for i in possible], energy[possible]
    nominal = held_levels(bench, experiment.tires[0])
    seconds = [cost(maneuver, bench, joule, nominal) for maneuver, joule in zip(maneuvers, energy, strict=True)]
    return maneuvers, np.array(seconds), energy


def _against_drift(
    selection: Selection, criterion: _Criterion, order: list[int], known: Information, experiment: Experiment,
    bench: Bench, limit: float,
) -> TestProgram:  # fmt: skip
    """Return the program of the best order: random exchanges of two steps within the bench time lower the criterion."""
    random, best = np.random.default_rng(0), np.inf
    program, trial = selection.program(order, bench), order
    for _ in range(TRIALS):
        candidate = selection.program(trial, bench)
        steps = [trial[step.number] for step in candidate.steps]
        value = criterion.of(covariances(experiment, known.take(steps), candidate.times))
        if candidate.seconds <= limit and value < best:
            program, order, best = candidate, trial, value
        i, j = random.integers(len(order), size=2)
        trial = list(order)
        trial[i], trial[j] = order[j], order[i]
    return program


def _check_aims(wanted: Sequence[Target], known: Information, bench: Bench) -> None:
    """Raise for an aim that all maneuvers together, each many times, do not determine, apart from offsets."""
    p = wanted[0].rows.shape[-1]
    curvature = MANY * known.products[:, :, :p, :p].sum(axis=0)
    limit = sandwich(curvature, MANY * known.noise.sum(axis=0))
    for target in wanted:
        width = target.width(limit)
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
    return Prediction(
        program.source, float(np.ptp(t)) + bench.warm_up, times, information(experiment, parts), experiment, wanted
    )


def _reasons(prediction: Prediction, program: TestProgram) -> dict[str, str]:
    """Return why each coefficient that a program does not determine remains undetermined."""
    experiment, names = prediction.experiment, [(name,) for name in prediction.undetermined()]
    recording = VirtualBench(experiment.tires[0], experiment.noise).run(program.virtual).with_signs("adapted-sae")
    table = recording.table.assign(recording=0, segment=recording.segment_numbers())
    residuals = Residuals.of(table, (recording.source,), experiment.tires[0])
    rows = len(table) / experiment.correlation_factor(table["t"].to_numpy(float))
    effective = dict.fromkeys(experiment.channels, rows)
    found = undetermined(residuals, experiment.free, names, effective)
    return {name: part.reason for part in found for name in part.coefficients}
