"""The program that separates effects: which of two the tire has, whatever the other coefficients are.

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
from itertools import product
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt
import pandas as pd

from ...boundary.bounded_file import text_file
from ...boundary.errors import UnknownName
from ...numerics.one_thread import one_blas_thread
from ...symbolic.added import library as library_effects
from ...symbolic.detection import LARGEST_IN_SIZES
from ...symbolic.model import Model
from ...tires import Tire, TireLike, tire_from
from .bench_file import Bench, PlanError
from .information import Experiment, information, thinned, tires_around
from .maneuvers import library
from .plan import PlanResult, Progress, Separation
from .selection import ManeuverSelection

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
    tire: TireLike, bench: Bench, pairs: Sequence[tuple[str, str]], *, minutes: float = 2.0,
    progress: Progress | None = None,
) -> PlanResult:  # fmt: skip
    """Plan the program that separates effects.

    `tire`: what is known of it; effects of the pairs are removed first. `bench`: the tire on it is warm. `pairs`:
    effects of which the tire has one. `progress`: as for `plan`. Pairs that no program of this bench and time
    separates at their typical sizes are in `PlanResult.undetermined`. Raises `PlanError` if these are all pairs, and
    `UnknownName` if the tire cannot have an effect.

    >>> from tirefmu.applications.planning.bench_file import Limits
    >>> bench = Bench({"Fz": Limits(220.0, 1120.0, 3.0, levels=2), "alpha": Limits(-0.2, 0.2, 2.0, 0.14)})
    >>> result = plan_between("trento_hoosier", bench, [("load_friction", "load_stiffness")], minutes=1.0)
    >>> [pair.evidence > 5.0 for pair in result.separations]
    [True, True]
    """
    bench = replace(bench, warm_up=0.0, repeat_every=0.0)
    discrimination = Discrimination.of(tire_from(tire), bench, pairs)
    base = discrimination.experiment.tires[0]
    progress = progress or (lambda what, share: None)
    progress("library of maneuvers", 0.0)
    maneuvers = library(bench, base, memory=True)
    tables = [maneuver.table(bench.sample_rate) for maneuver in maneuvers]
    parts = (discrimination.products(tables, pd.concat(tables, ignore_index=True)),)
    selection = ManeuverSelection.of(discrimination.experiment, bench, maneuvers, parts, discrimination.criterion)
    chosen = selection.chosen(minutes, lambda share: progress("choosing maneuvers", share))
    program = selection.program(chosen, alternate=False)
    progress("simulating the program", 0.0)
    separations = discrimination.separations(discrimination.products(program.tables, program.rows).sum(axis=0))
    hidden = _inseparable(separations, minutes, base)
    if len(hidden) == len(pairs):
        raise PlanError(next(iter(hidden.values())))
    aims = tuple(f"{a} or {b}" for a, b in pairs)
    return PlanResult(program, aims, undetermined=hidden, separations=separations)


def _inseparable(separations: Sequence[Separation], minutes: float, tire: Tire) -> dict[str, str]:
    """Return the pairs that a program does not separate, and why: an effect is not visible, or two look the same."""
    limit, detections = f"no program of {minutes:g} min on this bench", tire.symbolic_model.detections
    reasons = {}
    for pair, other in zip(separations[::2], separations[1::2], strict=True):
        name, best = f"{pair.effect} or {pair.rival}", max(pair.evidence, other.evidence)
        unseen = [part.effect for part in (pair, other) if part.alone < SEPARATED]
        if unseen:
            reasons[name] = f"{limit} shows {unseen[0]} at its typical size"
        elif best < SEPARATED:
            declared = [c for part in (pair, other) if part.effect in detections
                        for c in detections[part.effect].confounded if c.other == part.rival]  # fmt: skip
            reasons[name] = (
                f"{limit} separates {pair.effect} and {pair.rival}: the expected evidence is {best:.2g} nats"
                + "".join(f"; {part.separate_by}" for part in declared[:1])
            )
    return reasons


@dataclass(frozen=True, eq=False)
class Discrimination:
    """Tires without the effects, and the tires that have one form of one effect.

    - `pairs`: effect and rival, both ways.
    - `forms`: by effect, changes of coefficients from the tire without it.
    """

    experiment: Experiment
    pairs: tuple[tuple[str, str], ...]
    forms: Mapping[str, Sequence[Mapping[str, float]]]

    @classmethod
    def of(cls, tire: Tire, bench: Bench, pairs: Sequence[tuple[str, str]]) -> Discrimination:
        """Return the tires of a discrimination; raises `UnknownName` if the tire cannot have an effect."""
        names = list(dict.fromkeys(name for pair in pairs for name in pair))
        possible = {*tire.symbolic_model.effects, *library_effects()}
        for name in names:
            if name not in possible:
                raise UnknownName(f"effect of {tire.model}", name, possible)
        base = replace(tire, effects=tire.has - set(names))
        directed = tuple(both for a, b in pairs for both in ((a, b), (b, a)))
        return cls(Experiment(tires_around(base)[:TIRES], bench.noise), directed, {n: _forms(base, n) for n in names})

    @cached_property
    def columns(self) -> dict[str, npt.NDArray[np.intp]]:
        """The columns of each effect among the products."""
        ends = len(self.experiment.free) + np.cumsum([0, *(len(forms) for forms in self.forms.values())])
        return {name: np.arange(ends[i], ends[i + 1]) for i, name in enumerate(self.forms)}

    def products(self, tables: Sequence[pd.DataFrame], joined: pd.DataFrame) -> FloatArray:
        """Return the products of maneuvers in variances of the noise, shape (m, t, q, q).

        `joined`: the rows of the tables, with the time over which they are simulated.
        """
        ends, responses = np.cumsum([len(table) for table in tables])[:-1], []
        for tire in self.experiment.tires:
            parts = np.split(self._responses(tire, joined), ends)
            responses.append(np.concatenate([part[thinned(len(part), POINTS)] for part in parts]))
        factor = self.experiment.correlation_factor(tables[0]["t"].to_numpy(float))
        return information(self.experiment, tables, responses, POINTS).products / factor

    def criterion(self, total: FloatArray) -> float:
        """Return minus the mean logarithm of the evidence of every form of an effect against its rival."""
        return -float(np.mean([np.log1p(self._evidences(total, *pair)).mean() for pair in self.pairs]))

    def separations(self, total: FloatArray) -> tuple[Separation, ...]:
        """Return the evidence of the hardest form of each effect against its rival.

        Forms without an influence on the measured channels of this program are not counted unless all are.
        """
        separations = []
        for effect, rival in self.pairs:
            tested, evidence = self.columns[effect], self._evidences(total, effect, rival).mean(axis=0)
            alone = 0.5 * total[:, tested, tested].mean(axis=0)
            hardest = evidence[alone >= min(SEPARATED, alone.max())].min()
            separations.append(Separation(effect, rival, float(hardest), float(alone.max())))
        return tuple(separations)

    def _evidences(self, total: FloatArray, effect: str, rival: str) -> FloatArray:
        """Return half the squared response of each form that remains after the fit of all else, shape (t, forms)."""
        tested, n = self.columns[effect], total.shape[-1]
        errors = np.hypot(self.experiment.deviations("offset"), self.experiment.deviations("drift"))
        size = np.ones(n)
        size[self.columns[rival]], size[n - len(errors) :] = LARGEST_IN_SIZES, np.maximum(errors, 1e-12)
        untested = [column for name, columns in self.columns.items() if name != rival for column in columns]
        fitted = np.delete(np.arange(n), untested)
        matrix = total[:, fitted[:, None], fitted] + np.diag(size[fitted] ** -2)
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

    def value(key: str, size: float) -> float:
        neutral = declared[key].neutral
        inside = neutral is not None and declared[key].lower <= neutral <= declared[key].upper
        return neutral + size if neutral is not None and inside else size

    return [
        {**{key: grid[0] for key, grid in form.grid.items()}, **{key: value(key, size) for key, size in probe.items()}}
        for form in forms[-1].points()
        for probe in form.probes
    ]


def pairs_of(answer: str | Path) -> tuple[Path, list[tuple[str, str]]]:
    """Return the base tire of a diagnosis and the effects that it does not separate (`pairs_in`).

    `answer`: the folder of ``tirefmu diagnose -o``. Raises `PlanError` if it has no diagnosis, or the diagnosis has
    nothing that a program can separate.
    """
    path = Path(answer) / "diagnosis.json"
    try:
        content = json.loads(text_file(path, PlanError))
        tire = Path(answer) / content["base_tire"]
        pairs = pairs_in(content, tire_from(tire).symbolic_model)
    except (ValueError, KeyError, TypeError, AttributeError):
        raise PlanError(f"{path}: is not the result of a diagnosis") from None
    if not pairs:
        advice = "; ".join(content.get("next_measurement", ()))
        raise PlanError(f"{path}: no two effects that a program can separate" + (f": {advice}" if advice else ""))
    return tire, pairs


def pairs_in(content: Mapping[str, Any], model: Model) -> list[tuple[str, str]]:
    """Return the effects that a diagnosis does not separate.

    `content`: of diagnosis.json. An effect of a plausible explanation has the effects of another one, which lacks it,
    as rivals; an identified effect has those that are confounded with it.
    """
    plausible = [set(part["effects"]) for part in content["explanations"] if part["probability"] >= PLAUSIBLE]
    pairs = {pair for some in plausible for rival in plausible for pair in product(some - rival, rival - some)}
    for name in (finding["effect"] for finding in content["found"]):
        pairs |= {(name, other) for other in content["confounded_with"].get(name, ())}
    possible = {*model.effects, *library_effects()}
    return sorted({(min(pair), max(pair)) for pair in pairs if possible.issuperset(pair)})
