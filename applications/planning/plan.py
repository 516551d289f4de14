"""The program of a bench that determines a tire best in a given time, and what it determines."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from typing import Annotated, Any, ClassVar, TypedDict

import numpy as np
import numpy.typing as npt

from ...boundary.errors import no_single_text
from ...boundary.json_schema import document, json_value, schema_of
from ...boundary.named_options import named
from ...fitting.checks.residuals import Residuals
from ...fitting.checks.undetermined import undetermined
from ...measurements import Recording, TableLike, VirtualBench, recording_from
from ...tires import TireLike, tire_from
from .aims import Target, targets
from .bench_file import Bench, PlanError, read_bench
from .information import Experiment, Information, covariances, information, sandwich, tires_around, with_offsets
from .maneuvers import library
from .program import TestProgram
from .selection import ManeuverSelection

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
Progress = Callable[[str, float], None]


class TimedIntervals(TypedDict):
    """The predicted intervals after a bench time, s."""

    seconds: float
    intervals: dict[str, float]


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

    def over_time(self) -> list[TimedIntervals]:
        """Return the widths after each minute of the program."""
        timed = list[TimedIntervals]()
        for end in np.arange(60.0, self.seconds + 60.0, 60.0).tolist():
            if done := np.flatnonzero(self.times <= end).tolist():
                covariance = covariances(self.experiment, self.information.take(done), self.times[done])
                widths = {target.name: target.width(covariance) for target in self.targets}
                timed.append({"seconds": min(end, self.seconds), "intervals": widths})
        return timed


@dataclass(frozen=True)
class ComparedProgram:
    """The program of `--compare`, and after which bench time the planned one equals it."""

    name: str
    seconds: float
    intervals: dict[str, float]
    equal_after: Annotated[float | None, "s; null if it does not"]


@dataclass(frozen=True, eq=False)
class PlanResult:
    """A planned program.

    - `program`: the steps in their order.
    - `aims`: as given, or the effects that it separates.
    - `prediction`: what it determines; None for a program that separates effects.
    - `today`: the same of the program to which it is compared.
    - `undetermined`: coefficients that remain undetermined, or pairs of effects that it does not separate, and why.
    - `separations`: how well the program separates effects.
    """

    #: Version of plan.json. New keys increment the second number, changed meanings the first.
    version: ClassVar[str] = "1.0"
    ok: ClassVar[bool] = True
    JSON_KEYS: ClassVar = (
        "version", "ok", "program.seconds", "number_of_steps as steps", "aims", "intervals", "over_time",
        "undetermined", "compared", "separations",
    )  # fmt: skip

    program: TestProgram
    aims: tuple[str, ...]
    prediction: Prediction | None = None
    today: Prediction | None = None
    undetermined: Annotated[Mapping[str, str], "what remains undetermined, and why"] = field(default_factory=dict)
    separations: tuple[Separation, ...] = ()

    @cached_property
    def over_time(self) -> list[TimedIntervals]:
        """The widths after each minute."""
        return self.prediction.over_time() if self.prediction else []

    @property
    def equal_after(self) -> float | None:
        """The bench time after which every interval is as wide as that of today's program or narrower, s.

        A difference of `EQUAL` counts as equal: offsets of the bench limit some intervals of all programs.
        """
        limits = {name: (1.0 + EQUAL) * width for name, width in (self.today.widths if self.today else {}).items()}
        equal = (at["seconds"] for at in self.over_time if all(at["intervals"][n] <= limits[n] for n in limits))
        return next(equal, None) if limits else None

    @property
    def number_of_steps(self) -> int:
        """Number of the steps of the program."""
        return len(self.program.steps)

    @property
    def intervals(self) -> dict[str, float]:
        """Relative half widths of the predicted 95 % intervals by quantity."""
        return self.prediction.widths if self.prediction else {}

    @property
    def compared(self) -> ComparedProgram | None:
        """The program to which it is compared."""
        today = self.today
        return ComparedProgram(today.name, today.seconds, today.widths, self.equal_after) if today else None

    def to_json(self) -> dict[str, Any]:
        """Return the contents of plan.json; a number that is not finite is null."""
        return dict(json_value(self))


def plan_schema() -> dict[str, Any]:
    """Return the JSON Schema of plan.json."""
    return document("plan", PlanResult.version, "Planned test program", schema_of(PlanResult, missing=True))


@named()
def plan(
    tire: TireLike | Sequence[TireLike],
    bench: Bench | str | Path,
    *,
    aims: Sequence[str] = ("all",),
    minutes: float = 20.0,
    today: TableLike | None = None,
    progress: Progress | None = None,
) -> PlanResult:
    """Plan the program that determines a tire best in a given bench time.

    Parameters
    ----------
    tire : Tire, path of a .tir file or name of a published tire, or a sequence of them
        What is known of the tire. Several of one model are a family, over which the program is averaged; otherwise
        random tires around it are.
    bench : path of a bench file, or Bench
        What the bench can do; ``tirefmu plan --example`` prints such a file.
    aims : sequence of str
        "all", "forces", "friction", "stiffness", or names of coefficients.
    minutes : float
        Bench time with warm-up and pauses.
    today : path, DataFrame or Recording, optional
        A program of inputs over time to compare with.
    progress : callable
        Called with the activity and the share of the time that is planned.

    Returns
    -------
    PlanResult
        The program, and the intervals that it will give.

    Raises
    ------
    PlanError
        If the bench file is invalid, the time is too short, or no program on this bench determines an aim.
    UnknownName, WrongType
        If an aim or a tire does not exist.

    Examples
    --------
    >>> from tirefmu.applications.planning.bench_file import Limits
    >>> bench = Bench({"Fz": Limits(220.0, 1120.0, 3.0, levels=2), "alpha": Limits(-0.2, 0.2, 2.0, 0.14)})
    >>> result = plan("trento_hoosier", bench, aims=["stiffness"], minutes=1.0)
    >>> result.program.seconds <= 60.0, list(result.prediction.widths)
    (True, ['stiffness_y'])
    """
    bench = bench if isinstance(bench, Bench) else read_bench(bench)
    no_single_text("aims", aims)
    experiment = Experiment(_tires(tire), bench.noise)
    wanted = targets(experiment, bench, aims)
    if not wanted:
        raise PlanError(f"no slip of this bench has an influence on {', '.join(aims)}")
    current = _predicted(experiment, recording_from(today), wanted, bench) if today is not None else None
    progress = progress or (lambda what, share: None)
    progress("library of maneuvers", 0.0)
    maneuvers = library(bench, experiment.tires[0])
    of_library = information(experiment, [maneuver.table(bench.sample_rate) for maneuver in maneuvers])
    _check_aims(wanted, experiment, of_library, bench)
    value = _value(wanted, current)
    selection = ManeuverSelection.of(
        experiment, bench, maneuvers, (of_library.products, of_library.with_drift(experiment)),
        lambda products, noise: value(with_offsets(experiment, products, noise)),
    )  # fmt: skip
    chosen = selection.chosen(minutes, lambda share: progress("choosing maneuvers", share))
    progress("order against drift", 0.0)

    def of_program(program: TestProgram, order: Sequence[int]) -> float:
        steps = of_library.take([order[step.number] for step in program.steps])
        return value(covariances(experiment, steps, program.times))

    program = selection.exchanged_order(chosen, minutes, of_program)
    progress("predicting intervals", 0.0)
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


def _value(wanted: Sequence[Target], current: Prediction | None) -> Callable[[FloatArray], float]:
    """Return the criterion as a function of the covariances of the coefficients, shape (t, p, p).

    The sum over the targets of the logarithm of their mean relative variance in a fit, averaged over the tires
    (Chaloner and Verdinelli, Bayesian experimental design: a review, Statistical Science 10, 1995): halving the
    interval of one target counts as much as halving that of another. With a program to compare with, it is the sum of
    the squares of the ratios to its variances instead, to which a target that is determined worse contributes most.
    """
    squares = np.array([target.squares for target in wanted])

    def variances(covariance: FloatArray) -> FloatArray:
        return np.asarray(np.maximum(np.einsum("atpq,tpq->at", squares, covariance), 1e-30))

    if current is None:
        return lambda covariance: float(np.log(variances(covariance)).mean(axis=1).sum())
    reference = variances(current.covariances)
    return lambda covariance: float(np.square(variances(covariance) / reference).mean(axis=1).sum())


def _check_aims(wanted: Sequence[Target], experiment: Experiment, learned: Information, bench: Bench) -> None:
    """Raise for an aim that all maneuvers together, each many times, do not determine, apart from offsets."""
    p = len(experiment.free)
    limit = sandwich(MANY * learned.products[:, :, :p, :p].sum(axis=0), MANY * learned.noise.sum(axis=0))
    for target in wanted:
        if (width := target.width(limit)) <= UNDETERMINED:
            continue
        limits, load = bench.limits.get(target.slip), "" if "Fz" in bench.limits else ", and the load does not vary"
        raise PlanError(
            f"no program on this bench determines {target.name}: with all sweeps {MANY:g} times its 95 % interval is "
            f"+-{100.0 * width:.0f} %; "
            + (
                f"{target.slip} is limited to {limits.low:.3g} .. {limits.high:.3g}{load}"
                if limits and limits.sweeps
                else f"the bench does not sweep {target.slip}"
            )
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
    experiment, variances = prediction.experiment, np.einsum("tpp->tp", prediction.covariances).mean(axis=0)
    names = [(name,) for name, v in zip(experiment.free, variances, strict=True) if v > SIZE_SHARE**2]
    recording = VirtualBench(experiment.tires[0], experiment.noise).run(program.virtual).with_signs("adapted-sae")
    table = recording.table.assign(recording=0, segment=recording.segment_numbers())
    residuals = Residuals.of(table, (recording.source,), experiment.tires[0])
    rows = len(table) / experiment.correlation_factor(table["t"].to_numpy(float))
    effective = dict.fromkeys(experiment.channels, rows)
    groups = undetermined(residuals, experiment.free, names, effective)
    return {name: part.reason for part in groups for name in part.coefficients}
