"""The program that tells effects apart: which of two the tire has, whatever the other coefficients are.

T-optimality (Atkinson and Fedorov, The design of experiments for discriminating between two rival models, Biometrika
62, 1975): the response of an effect that the tire has is large in what remains after all coefficients, the offsets of
the bench and every form of the rival are fitted to it. Half of its weighted square is the expected logarithm of the
likelihood ratio. Effects with memory are simulated: a maneuver begins at equilibrium, the chosen program is
simulated as a whole.
"""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path

import numpy as np
import numpy.typing as npt
import pandas as pd

from tirefmu.boundary.bounded_file import text_file
from tirefmu.boundary.errors import UnknownName
from tirefmu.estimation.one_thread import one_blas_thread
from tirefmu.symbolic.added import library as library_effects
from tirefmu.symbolic.detection import LARGEST_IN_SIZES
from tirefmu.symbolic.models import model_named
from tirefmu.tires import Tire, TireLike, tire_from

from .bench_file import Bench, Heat, PlanError
from .information import Experiment, energies, fisher, thinned, tires_around
from .maneuvers import held_levels, library_with_memory
from .plan import PlanResult, Progress
from .plan_content import Separation
from .program import TestProgram, cost, ordered

FloatArray = npt.NDArray[np.float64]
#: Rows of a maneuver that are evaluated: effects with memory change within tenths of a second.
POINTS = 300
#: Tires over which a program is averaged.
TIRES = 2
#: Least expected evidence, nats: odds of 150 to 1.
SEPARATED = 5.0
#: Least probability of an explanation that a further measurement has to rule out.
PLAUSIBLE = 0.02


def plan_between(
    tire: TireLike,
    bench: Bench,
    pairs: Sequence[tuple[str, str]],
    *,
    minutes: float = 2.0,
    progress: Progress | None = None,
) -> PlanResult:
    """Plan the program that tells effects apart.

    Parameters
    ----------
    tire : Tire, path or published name
        What is known of the tire. Effects of the pairs that it has are removed first.
    bench : Bench
        What the bench can do; the tire is warm.
    pairs : sequence of (str, str)
        Effects of which the tire has one.
    minutes : float
        Bench time.
    progress : callable, optional
        Called with the activity and the share of the bench time that is planned.

    Returns
    -------
    PlanResult
        With the expected evidence of each effect against its rival.

    Raises
    ------
    PlanError
        If no program of this bench and time separates the effects, at their typical sizes.
    UnknownName
        If the tire cannot have an effect.

    Examples
    --------
    >>> from tirefmu.planning.bench_file import Limits
    >>> bench = Bench({"Fz": Limits(220.0, 1120.0, 3.0, levels=2), "alpha": Limits(-0.2, 0.2, 2.0, 0.14)})
    >>> result = plan_between("trento_hoosier", bench, [("load_friction", "load_stiffness")], minutes=1.0)
    >>> [one.evidence > 5.0 for one in result.separations]
    [True, True]
    """
    report = progress or (lambda what, share: None)
    bench = replace(bench, warm_up=0.0, repeat_every=0.0)
    discrimination = Discrimination.of(tire_from(tire), bench, pairs)
    report("library of maneuvers", 0.0)
    maneuvers = library_with_memory(bench, discrimination.experiment.tires[0])
    tables = [maneuver.table(bench.sample_rate) for maneuver in maneuvers]
    matrices = discrimination.information(tables)
    energy = energies(discrimination.experiment, tables) if bench.heat != Heat() else np.zeros(len(tables))
    nominal = held_levels(bench, discrimination.experiment.tires[0])
    seconds = np.array([cost(one, bench, joule, nominal) for one, joule in zip(maneuvers, energy, strict=True)])
    possible = energy <= bench.heat.energy_of_a_sweep
    chosen: list[int] = []
    total = np.zeros_like(matrices[0])
    while True:
        left = 60.0 * minutes - seconds[chosen].sum()
        index = np.flatnonzero((seconds <= left) & possible)
        report("choosing maneuvers", 1.0 - left / (60.0 * minutes))
        if not index.size:
            break
        now = discrimination.value(total)
        gains = [(discrimination.value(total + matrices[i]) - now) / seconds[i] for i in index]
        chosen.append(int(index[np.argmax(gains)]))
        total = total + matrices[chosen[-1]]
    if not chosen:
        raise PlanError(f"{minutes:g} min are too short for one maneuver of this bench")
    program = ordered([maneuvers[i] for i in chosen], energy[chosen].tolist(), bench, alternate=False)
    report("simulating the program", 0.0)
    separations = discrimination.separations(discrimination.information_of(program))
    _check(separations, minutes, discrimination.experiment.tires[0])
    return PlanResult(program, tuple(f"{a} or {b}" for a, b in pairs), separations=separations)


def _check(separations: Sequence[Separation], minutes: float, tire: Tire) -> None:
    """Raise for an effect that a program cannot see, and for two effects that it cannot separate."""
    for one, other in zip(separations[::2], separations[1::2], strict=True):
        for each in (one, other):
            if each.alone < SEPARATED:
                raise PlanError(f"no program of {minutes:g} min on this bench shows {each.effect} at its typical size")
        best = max(one.evidence, other.evidence)
        if best < SEPARATED:
            raise PlanError(
                f"no program of {minutes:g} min on this bench tells {one.effect} and {one.rival} apart: the expected "
                f"evidence is {best:.2g} nats{_advice(tire, one)}"
            )


def _advice(tire: Tire, separation: Separation) -> str:
    """Return the measurement that the files of the effects declare."""
    detections = tire.symbolic_model.detections
    for effect, rival in ((separation.effect, separation.rival), (separation.rival, separation.effect)):
        for pair in detections[effect].confounded if effect in detections else ():
            if pair.other == rival:
                return f"; {pair.separate_by}"
    return ""


@dataclass(frozen=True, eq=False)
class Discrimination:
    """Tires without the effects, and the tires that have one form of one effect.

    - `forms`: by effect, changes of coefficients from the tire without it.
    """

    experiment: Experiment
    pairs: tuple[tuple[str, str], ...]
    forms: Mapping[str, Sequence[Mapping[str, float]]]

    @classmethod
    def of(cls, tire: Tire, bench: Bench, pairs: Sequence[tuple[str, str]]) -> Discrimination:
        """Return the tires of a discrimination; raises `UnknownName` if the tire cannot have an effect."""
        names = list(dict.fromkeys(name for pair in pairs for name in pair))
        known = {*tire.symbolic_model.effects, *library_effects()}
        for name in names:
            if name not in known:
                raise UnknownName(f"effect of {tire.model}", name, known)
        base = replace(tire, effects=tire.has - set(names))
        return cls(
            Experiment(tires_around(base)[:TIRES], bench.noise), tuple(pairs), {n: _forms(base, n) for n in names}
        )

    @cached_property
    def columns(self) -> dict[str, npt.NDArray[np.intp]]:
        """The columns of each effect among the responses."""
        ends = np.cumsum([0, *(len(forms) for forms in self.forms.values())])
        return {name: np.arange(ends[i], ends[i + 1]) for i, name in enumerate(self.forms)}

    def information(self, tables: Sequence[pd.DataFrame]) -> FloatArray:
        """Return the information of maneuvers, each from equilibrium, shape (m, t, q, q)."""
        return self._information(tables, pd.concat(tables, ignore_index=True))

    def information_of(self, program: TestProgram) -> FloatArray:
        """Return the information of a program that is simulated as a whole, shape (t, q, q)."""
        tables = [step.maneuver.table(program.bench.sample_rate) for step in program.steps]
        return np.asarray(self._information(tables, program.rows).sum(axis=0))

    def _information(self, tables: Sequence[pd.DataFrame], joined: pd.DataFrame) -> FloatArray:
        """Return the information of tables that are simulated one after another, with the time of `joined`."""
        ends, responses = np.cumsum([len(table) for table in tables])[:-1], []
        for tire in self.experiment.tires:
            parts = np.split(self._responses(tire, joined), ends)
            responses.append(np.concatenate([part[thinned(len(part), POINTS)] for part in parts]))
        return fisher(self.experiment, tables, responses, POINTS)

    def value(self, total: FloatArray) -> float:
        """Return the criterion: mean logarithm of the evidence of every form of an effect against its rival."""
        evidences = [self._evidences(total, *pair) for a, b in self.pairs for pair in ((a, b), (b, a))]
        return float(np.mean([np.log1p(one).mean() for one in evidences]))

    def separations(self, total: FloatArray) -> tuple[Separation, ...]:
        """Return the evidence of the hardest form of each effect against its rival.

        Forms without an influence on the measured channels of this program are not counted unless all are.
        """
        found = []
        for a, b in self.pairs:
            for effect, rival in ((a, b), (b, a)):
                evidence = self._evidences(total, effect, rival).mean(axis=0)
                tested = len(self.experiment.free) + self.columns[effect]
                alone = 0.5 * total[:, tested, tested].mean(axis=0)
                hardest = evidence[alone >= min(SEPARATED, alone.max())].min()
                found.append(Separation(effect, rival, float(hardest), float(alone.max())))
        return tuple(found)

    def _evidences(self, total: FloatArray, effect: str, rival: str) -> FloatArray:
        """Return half the squared response of each form that remains after the fit of all else, shape (t, forms)."""
        p, e = len(self.experiment.free), sum(len(one) for one in self.columns.values())
        fitted = np.concatenate([np.arange(p), p + self.columns[rival], np.arange(p + e, total.shape[-1])])
        tested = p + self.columns[effect]
        prior = np.ones(len(fitted))
        prior[p : p + len(self.columns[rival])] = LARGEST_IN_SIZES**-2
        matrix = total[:, fitted[:, None], fitted] + np.diag(prior)
        cross = total[:, fitted[:, None], tested]
        scale = 1.0 / np.sqrt(np.einsum("tii->ti", matrix))[:, :, None]
        with one_blas_thread():
            solved = np.linalg.solve(matrix * scale * np.swapaxes(scale, 1, 2), cross * scale)
        explained = np.einsum("tij,tij->tj", cross * scale, solved)
        return np.asarray(0.5 * np.maximum(total[:, tested, tested] - explained, 0.0))

    def _responses(self, tire: Tire, table: pd.DataFrame) -> FloatArray:
        """Return the change of the channels by each form of each effect, shape (n, c, e)."""
        channels = list(self.experiment.channels)
        without = tire.evaluate(table, signs="adapted-sae")[channels].to_numpy(float)
        columns = []
        for name, forms in self.forms.items():
            for values in forms:
                having = replace(tire, effects=tire.has | {name}, values={**tire.values, **values})
                columns.append(having.evaluate(table, signs="adapted-sae")[channels].to_numpy(float) - without)
        return np.stack(columns, axis=2)


def _forms(tire: Tire, name: str) -> list[Mapping[str, float]]:
    """Return the values of an effect's coefficients at each point and probe of its most general form."""
    model = replace(tire, effects=tire.has | {name}).symbolic_model
    detection, declared = model.detections.get(name), model.coefficients
    forms = [form for form in (detection.forms if detection else ()) if not form.given and form.free[0] in declared]
    if not forms:
        raise PlanError(f"{name} of {tire.model} has no declared size: no program can be planned for it")
    found: list[Mapping[str, float]] = []
    for form in forms[-1].points():
        point = {key: value[0] for key, value in form.grid.items()}
        for probe in form.probes:
            found.append({**point, **{key: _value(declared[key], size) for key, size in probe.items()}})
    return found


def _value(declaration: object, size: float) -> float:
    neutral, lower, upper = (getattr(declaration, key) for key in ("neutral", "lower", "upper"))
    return size if neutral is None or not lower <= neutral <= upper else neutral + size


def pairs_of(answer: str | Path) -> tuple[Path, list[tuple[str, str]]]:
    """Return the base tire of a diagnosis and the effects that it does not tell apart.

    Parameters
    ----------
    answer : str or Path
        The folder of ``tirefmu diagnose -o``.

    Returns
    -------
    tuple of Path and list of (str, str)
        Each identified effect with an explanation that is plausible without it, or confounded with it.

    Raises
    ------
    PlanError
        If the folder has no diagnosis, or the diagnosis has nothing that a program can separate.
    """
    path = Path(answer) / "diagnosis.json"
    try:
        content = json.loads(text_file(path, PlanError))
        found = [one["effect"] for one in content["found"]]
        confounded, tire = content["confounded_with"], Path(answer) / content["base_tire"]
        explanations = [one for one in content["explanations"] if one["probability"] >= PLAUSIBLE]
        wanted = {*found, *(name for one in explanations for name in one["effects"])}
        model = model_named(_model_of(tire))
    except (ValueError, KeyError, TypeError, AttributeError):
        raise PlanError(f"{path}: is not the result of a diagnosis") from None
    known = {*model.effects, *library_effects()}
    pairs = {
        tuple(sorted((name, other)))
        for one in explanations
        for name in wanted - set(one["effects"])
        for other in one["effects"]
        if any(name in b["effects"] and other not in b["effects"] for b in explanations)
    }
    pairs |= {tuple(sorted((name, other))) for name in found for other in confounded.get(name, ())}
    possible = sorted((a, b) for a, b in pairs if {a, b} <= known)
    if not possible:
        advice = "; ".join(content.get("next_measurement", ()))
        raise PlanError(f"{path}: no two effects that a program can separate" + (f": {advice}" if advice else ""))
    return tire, possible


def _model_of(tire: Path) -> str:
    return tire_from(tire).model
