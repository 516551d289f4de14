"""A fit on its way: stage after stage solved, then told."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from math import nan

import numpy as np
import numpy.typing as npt
import pandas as pd

from tirefmu.measurements import Recording
from tirefmu.symbolic.errors import FitError
from tirefmu.symbolic.model import Model
from tirefmu.symbolic.notation import Coefficient
from tirefmu.tires.code import fastest_code
from tirefmu.tires.tire import Tire

from .constraints import TOLERANCE, VALIDITY, Constraint, grid, operating_range
from .ipopt import Solution
from .method import Solver
from .noise_floor import noise_floor
from .problem import Problem, Rows, coefficients_by_output, emphasis, equal_weights, noise_weights
from .recipe import Freed, Recipe, Stage
from .result import ChannelFit, FitResult, FittedCoefficient, Margin, StageFit, quality
from .uncertainty import Direction, uncertainty

FloatArray = npt.NDArray[np.float64]
#: Called with (stage, iteration, cost).
Progress = Callable[[str, int, float], None]

#: How much denser the grid is on which constraints are verified, how often what breaks them is added, and how much
#: of it at a time.
VERIFIED, ROUNDS, MOST_ADDED = 4, 12, 12
#: The pull of scaled coefficients to where a stage starts, by its weights: the residual weights make the cost about
#: 1/2, the others about the share of noise.
RIDGE = {"equal": 1e-8, "noise": 1e-5}
#: The sections of the .tir file that say what the coefficients refer to: they are given, and fitted only where a
#: stage names them.
GIVEN_SECTIONS = frozenset({
    "MODEL", "DIMENSION", "OPERATING_CONDITIONS", "VERTICAL", "STRUCTURAL", "CONTACT_PATCH",
    "INFLATION_PRESSURE_RANGE", "VERTICAL_FORCE_RANGE", "LONG_SLIP_RANGE", "SLIP_ANGLE_RANGE",
    "INCLINATION_ANGLE_RANGE", "SCALING_COEFFICIENTS", "TIREFMU_TRANSIENT",
})  # fmt: skip


@dataclass(frozen=True)
class _Release:
    """A coefficient freed: its first guess with its last bounds, the last stage that saw it, and whether one did."""

    bounds: Freed
    stage: str
    determined: bool


class Session:
    """A fit on its way: the tire so far and what the stages said."""

    def __init__(
        self,
        book: Model,
        tire: Tire,
        data: pd.DataFrame,
        plan: Recipe,
        progress: Progress | None,
        notes: list[str],
        *,
        solver: Solver,
        given: bool,
    ) -> None:
        self._given = given  # the tire's values are somebody's, not to be replaced by generic ones
        self._book, self._tire, self._data, self._plan = book, tire, data, plan
        self._progress: Progress = progress or (lambda stage, iteration, cost: None)
        self._notes, self._solver = notes, solver
        self._emphasis = emphasis(data, tire.outputs)
        self._ranges = operating_range(data, tire.inputs)
        self._broken: list[tuple[Constraint, FloatArray]] = []  # what verifying added, for later stages too
        self._grids: dict[tuple[tuple[str, ...], int], FloatArray] = {}
        self._stages: list[StageFit] = []
        self._ends: list[tuple[str, Problem, FloatArray]] = []
        self._freed: dict[str, _Release] = {}
        asked = [data[name].any() for _, name in book.on_demand if name in data]
        self._straight = not any(asked)  # no row turns: what acts in a turn alone reaches no channel
        self._fitted = [q.name for q in book.outputs if q.name in data and data[q.name].notna().any()]

    def run(self, stage: Stage) -> None:
        """Solve one stage and keep its values."""
        channels = self._chosen(stage)
        if not channels and not stage.free:
            return  # a recipe for all channels, of which these were not measured
        table = stage.select(self._data)
        table = table[table[channels].notna().any(axis=1)] if channels else table[:0]
        if table.empty:
            asked = ", ".join(stage.channels) or "the data"
            self._notes.append(f"stage {stage.name!r} skipped: no row of {asked} meets its conditions")
            return
        rows = Rows.of(table, self._tire, channels)
        self._guess(stage)
        every = {name: self._bounds(name, stage) for name in self._candidates(stage)}
        part = rows.sample(stage.rows) if stage.rows else rows
        free = self._determined(every, part, stage)
        if not free:
            self._notes.append(f"stage {stage.name!r} skipped: its rows determine none of its coefficients")
            return
        self._solve(stage, part, free, channels)

    def _chosen(self, stage: Stage) -> list[str]:
        return [name for name in self._fitted if not stage.channels or name in stage.channels]

    def _candidates(self, stage: Stage) -> list[str]:
        """Return what a stage may free: what reaches one of its channels in some row, by section and effect."""
        reaching = coefficients_by_output(self._book, straight=self._straight)
        reaches = frozenset[str]().union(*(reaching[name] for name in self._chosen(stage)))
        live = self._book.live(self._tire.has) & reaches
        if stage.free:
            return [name for name in stage.free if name in live]
        if stage.effects is not None:
            live &= self._book.live(self._tire.has.intersection(stage.effects))
        sections = {card.section for card in self._book.coefficients.values()} - GIVEN_SECTIONS
        allowed = set(stage.sections) or sections
        return [name for name, card in self._book.coefficients.items() if name in live and card.section in allowed]

    def _bounds(self, name: str, stage: Stage) -> Freed:
        card = self._book.coefficients[name]
        guess = self._tire.values[name]
        asked = stage.free.get(name, Freed(guess, card.lower, card.upper))
        return Freed(guess, asked.lower, asked.upper)

    def _guess(self, stage: Stage) -> None:
        """Put the stage's own guesses into the tire, or generic ones for what no stage has seen yet."""
        cards = self._book.coefficients
        if stage.free:
            guesses = {n: min(max(f.guess, f.lower), f.upper) for n, f in stage.free.items()}
        elif self._given:
            guesses = {}
        else:
            known = {name for name, release in self._freed.items() if release.determined}
            guesses = {n: _generic(cards[n]) for n in self._candidates(stage) if n not in known}
        self._tire = replace(self._tire, values={**self._tire.values, **guesses})

    def _determined(self, every: dict[str, Freed], rows: Rows, stage: Stage) -> dict[str, Freed]:
        """Leave out what the rows cannot see; undo its generic start value, which nobody measured."""
        seen = _influence(self._tire, rows.sample(2000), list(every))
        for name, freed in every.items():
            before = self._freed.get(name)
            if before is None or name in seen or not before.determined:
                first = freed.guess if before is None else before.bounds.guess
                self._freed[name] = _Release(replace(freed, guess=first), stage.name, name in seen)
        unseen = {n: self._book.coefficients[n].default for n in every if not self._freed[n].determined}
        if not stage.free and not self._given:
            self._tire = replace(self._tire, values={**self._tire.values, **unseen})
        return {name: freed for name, freed in every.items() if name in seen}

    def _solve(self, stage: Stage, rows: Rows, free: dict[str, Freed], channels: Sequence[str]) -> None:
        cards = self._book.coefficients
        scale = np.array([_size(cards[name].lower, cards[name].upper, f.guess) for name, f in free.items()])
        problem = Problem(self._tire, rows, tuple(free), equal_weights(rows), scale)
        start = np.array([f.guess for f in free.values()]) / scale
        if stage.weights == "noise":
            problem.weights = noise_weights(problem, start, self._emphasis)
        lower = np.array([f.lower for f in free.values()]) / scale
        upper = np.array([f.upper for f in free.values()]) / scale
        report = partial(self._progress, stage.name)
        solution = self._solved(
            problem, np.clip(start, lower, upper), lower, upper, channels, report,
            ridge=RIDGE[stage.weights], approach=self._is_approach(stage),
        )  # fmt: skip
        values = dict(zip(free, (solution.x * scale).tolist(), strict=True))
        self._tire = replace(self._tire, values={**self._tire.values, **values})
        if stage.rows is None or len(rows) < stage.rows:  # rows drawn at random tell nothing of time
            self._ends.append((stage.name, problem, solution.x))
        self._stages.append(
            StageFit(
                stage.name, len(rows), len(free), solution.iterations, solution.converged, solution.reason,
                solution.cost, self._stage_r2(rows),
            )
        )  # fmt: skip

    def _is_approach(self, stage: Stage) -> bool:
        """Return whether a stage and the next one take random rows: the next goes on with no more effort per step."""
        following = self._plan.stages[self._plan.stages.index(stage) + 1 :]
        return stage.rows is not None and bool(following) and following[0].rows is not None

    def _solved(
        self,
        problem: Problem,
        start: FloatArray,
        lower: FloatArray,
        upper: FloatArray,
        channels: Sequence[str],
        report: Callable[[int, float], None],
        *,
        ridge: float,
        approach: bool,
    ) -> Solution:
        """Solve, verify the constraints on the dense grid, and solve again with the points that broke them."""
        known = self._constraints(channels, 0) + self._broken
        dense = self._constraints(channels, VERIFIED)
        settle = partial(
            self._solver, problem, lower=lower, upper=upper, ridge=ridge, approach=approach, progress=report
        )
        solution = settle(start, constraints=known)
        for _ in range(1 if approach else ROUNDS):
            broken = self._breaking(dense, problem.parameters(solution.x))
            if not broken:
                break
            self._broken += broken
            known = known + broken
            if not approach:
                solution = settle(solution.x, constraints=known)
        return solution

    def _breaking(
        self, dense: Sequence[tuple[Constraint, FloatArray]], parameters: FloatArray
    ) -> list[tuple[Constraint, FloatArray]]:
        """Return the worst point of each broken condition and some of the others that break it."""
        broken = []
        for constraint, points in dense:
            distance = constraint.distance(self._quantity(constraint, points, parameters))
            outside = np.flatnonzero(distance < -TOLERANCE)
            if outside.size:
                order = outside[np.argsort(distance[outside], kind="stable")]
                some = np.unique(np.linspace(0, len(order) - 1, MOST_ADDED).astype(int))
                broken.append((constraint, points[:, order[some]]))
        return broken

    def _quantity(self, constraint: Constraint, points: FloatArray, parameters: FloatArray) -> FloatArray:
        code = fastest_code(self._book)
        values: FloatArray = code.quantities(points, parameters)[code.quantities_names.index(constraint.quantity)]
        return values

    def _stage_r2(self, rows: Rows) -> float:
        computed = fastest_code(self._tire.book).forces(rows.inputs, self._tire.parameters()).T
        there = np.isfinite(rows.measured)
        weights = equal_weights(rows)[0]
        squares = np.sum(np.where(there, computed - rows.measured, 0.0) ** 2, axis=0) * weights
        return 1 - float(np.mean(squares[there.any(axis=0)]))

    def _constraints(self, channels: Sequence[str], density: int) -> list[tuple[Constraint, FloatArray]]:
        nominal = {name: self._tire.nominal(name) for name in self._tire.inputs}
        conditions = VALIDITY.get(self._book.name, {})
        chosen = [constraint for name in channels for constraint in conditions.get(name, ())]
        for constraint in chosen:
            key = constraint.over, density
            if key not in self._grids:
                self._grids[key] = grid(constraint, self._ranges, nominal, density=density)
        return [(constraint, self._grids[constraint.over, density]) for constraint in chosen]

    def result(self, recordings: Sequence[Recording], signs: str, seconds: float) -> FitResult:
        """Tell the whole fit, coefficients in the given signs."""
        if not self._stages:
            raise FitError("no stage of the recipe found rows to fit: " + "; ".join(self._notes))
        ranges = {name: bounds for name, bounds in self._ranges.items() if name in self._data and bounds[0] < bounds[1]}
        about = {
            **self._tire.about,
            "recipe": self._plan.name,
            "data": ", ".join(r.source for r in recordings),
        }
        cards = self._book.coefficients
        values = {
            name: value for name, value in self._tire.values.items() if not cards[name].section.endswith("_RANGE")
        }
        tire = replace(self._tire, values=values, ranges=ranges, about=about)  # the same inputs in ISO
        told = {name: self._told(name, signs) for name in self._book.coefficients if name in self._freed}
        intervals, directions, effective = self._uncertainty(told)
        coefficients = tuple(replace(c, interval=intervals.get(name, nan)) for name, c in told.items())
        undetermined = [c.name for c in coefficients if not c.determined]
        if undetermined:
            self._notes.append(f"not determined by these data, left as they were: {', '.join(undetermined)}")
        return FitResult(
            tire.in_signs("iso"), signs, coefficients, self._channels(recordings, tire, effective),
            tuple(self._stages), self._margins(), tuple(self._notes), seconds, self._plan.name, directions,
        )  # fmt: skip

    def _uncertainty(
        self, told: Mapping[str, FittedCoefficient]
    ) -> tuple[dict[str, float], tuple[Direction, ...], FloatArray]:
        """Return intervals, open directions and effective rows, each from the last stage that freed or fitted it."""
        intervals: dict[str, float] = {}
        directions: tuple[Direction, ...] = ()
        effective = np.full((int(self._data["recording"].max()) + 1, len(self._tire.outputs)), nan)
        for stage, problem, x in self._ends:
            if not any(told[name].stage == stage for name in problem.free):
                continue
            fixed = [name for name in problem.free if told[name].at_bound]
            known = uncertainty(problem, x, fixed)
            last = {name for name in problem.free if told[name].stage == stage}
            intervals.update({name: half for name, half in known.intervals.items() if name in last})
            directions += tuple(d for d in known.directions if last.intersection(d.coefficients))
            rows = effective[: len(known.effective_rows)]
            rows[known.effective_rows > 0] = known.effective_rows[known.effective_rows > 0]
        return intervals, directions, effective

    def _told(self, name: str, signs: str) -> FittedCoefficient:
        freed = self._freed[name]
        card, value = self._book.coefficients[name], self._tire.values[name]
        guess, lower, upper = freed.bounds.guess, freed.bounds.lower, freed.bounds.upper
        # An interior-point solution keeps a little off its bounds.
        near = 1e-3 * max(abs(value), upper - lower if np.isfinite(upper - lower) else 0.0)
        at_bound = freed.determined and (value - lower <= near or upper - value <= near)
        if signs == "iso" and card.flips:
            guess, lower, upper, value = (0.0 - number for number in (guess, upper, lower, value))  # no -0.0
        return FittedCoefficient(name, card.unit, guess, lower, upper, value, at_bound, freed.determined, freed.stage)

    def _channels(self, recordings: Sequence[Recording], tire: Tire, effective: FloatArray) -> tuple[ChannelFit, ...]:
        units = {quantity.name: quantity.unit for quantity in self._book.outputs}
        told = []
        for number, name in enumerate(_distinct([recording.source for recording in recordings])):
            table = self._data[self._data["recording"] == number]
            rows = Rows.of(table, tire, self._fitted)
            computed = fastest_code(tire.book).forces(rows.inputs, tire.parameters())
            floors = noise_floor(table, [name for name in self._fitted if table[name].notna().any()])
            for index, channel in enumerate(tire.outputs):
                n, rmse, r2, uncentred = quality(rows.measured[:, index], computed[index])
                if n:
                    floor, worth = floors[channel][0], float(effective[number, index])
                    told.append(ChannelFit(name, channel, units[channel], n, rmse, r2, uncentred, floor, worth))
        return tuple(told)

    def _margins(self) -> tuple[Margin, ...]:
        """Verify every constraint on a grid denser than the one that it was imposed on."""
        margins = []
        for constraint, points in self._constraints(self._fitted, VERIFIED):
            values = self._quantity(constraint, points, self._tire.parameters())
            distance = constraint.distance(values)
            worst = int(np.argmin(distance))
            at = {name: float(points[i, worst]) for i, name in enumerate(self._tire.inputs) if name in constraint.over}
            margins.append(Margin(constraint.name, float(values[worst]), float(distance[worst]), at))
        return tuple(margins)


def _distinct(names: Sequence[str]) -> list[str]:
    """Return the names, those that were there before numbered: two folders may hold files of one name."""
    return [name if name not in names[:i] else f"{name} ({names[:i].count(name) + 1})" for i, name in enumerate(names)]


def _generic(card: Coefficient) -> float:
    """Return where a coefficient starts: its card's start, else what readers assume, else its default."""
    if card.start is not None or card.assumed is None:
        return card.generic
    assumed = -card.assumed if card.flips else card.assumed  # cards tell that in ISO-W
    return min(max(assumed, card.lower), card.upper)


def _size(lower: float, upper: float, guess: float) -> float:
    """Return the size of a coefficient for the solver: a quarter of its card's range, not less than its guess."""
    span = upper - lower
    return max(abs(guess), 0.25 * span if np.isfinite(span) else 1.0, 1e-3)


def _influence(tire: Tire, rows: Rows, names: Sequence[str]) -> set[str]:
    """Return the coefficients that change some measured force at these rows.

    Looked at from the present values and from two random points beside them: where a factor is at neutral,
    what it multiplies shows nothing, though it may once the factor moves.
    """
    book, code = tire.book, fastest_code(tire.book)
    order = list(book.parameters)
    cards = [book.coefficients[name] for name in names]
    columns, factors = np.array([order.index(name) for name in names]), tire.rescaled
    sizes = np.array([_size(c.lower, c.upper, tire.values[c.name]) * factors.get(c.name, 1.0) for c in cards])
    there = np.isfinite(rows.measured)
    forces = np.sqrt(np.sum(np.where(there, rows.measured, 0.0) ** 2, axis=0) / np.maximum(there.sum(axis=0), 1))
    random = np.random.default_rng(0)
    seen = np.zeros(len(names), dtype=bool)
    for reach in (0.0, 0.1, 0.1):
        parameters = tire.parameters()
        parameters[columns] += reach * sizes * random.uniform(-1.0, 1.0, len(names))
        jacobian = code.jacobian_parameters(rows.inputs, parameters)[:, :, columns]
        change = np.where(there[:, :, None], np.nan_to_num(jacobian), 0.0) * sizes
        seen |= np.max(np.abs(change) / np.where(forces > 0, forces, np.inf)[:, None], axis=(0, 1)) > 1e-6
    return {name for name, it_is in zip(names, seen, strict=True) if it_is}
