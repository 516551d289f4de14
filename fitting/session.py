"""A fit on its way: stage after stage solved, then told."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import partial

import numpy as np
import numpy.typing as npt
import pandas as pd

from tirefmu.measurements import Recording
from tirefmu.symbolic.errors import FitError
from tirefmu.symbolic.model import Model
from tirefmu.tires.tire import Tire

from .constraints import TOLERANCE, VALIDITY, Constraint, grid, operating_range
from .ipopt import Solution, solve
from .problem import Problem, Rows, equal_weights, fastest_code, noise_weights
from .recipe import Freed, Recipe, Stage
from .result import ChannelFit, FitResult, FittedCoefficient, Margin, StageFit, quality

FloatArray = npt.NDArray[np.float64]
#: Called with (stage, iteration, cost).
Progress = Callable[[str, int, float], None]

#: How many times denser the grid is on which constraints are verified, how often what breaks them is added, and
#: the sections of the .tir file that say what the coefficients refer to: they are given, not fitted.
VERIFIED, ROUNDS = 4, 8
GIVEN_SECTIONS = ("DIMENSION", "VERTICAL", "SCALING_COEFFICIENTS")


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
        given: bool,
    ) -> None:
        self._given = given  # the tire's values are somebody's, not to be replaced by generic ones
        self._book, self._tire, self._data, self._plan = book, tire, data, plan
        self._progress: Progress = progress or (lambda stage, iteration, cost: None)
        self._notes = notes
        self._ranges = operating_range(data, tire.inputs)
        self._stages: list[StageFit] = []
        self._freed: dict[str, _Release] = {}
        self._fitted = [q.name for q in book.outputs if q.name in data and data[q.name].notna().any()]

    def run(self, stage: Stage) -> None:
        """Solve one stage and keep its values."""
        channels = [name for name in self._fitted if not stage.channels or name in stage.channels]
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

    def _candidates(self, stage: Stage) -> list[str]:
        live = self._book.live(self._tire.has)
        if stage.free:
            return [name for name in stage.free if name in live]
        if stage.effects is not None:
            live = self._book.live(self._tire.has.intersection(stage.effects))
        cards = self._book.coefficients
        return [name for name, card in cards.items() if name in live and card.section not in GIVEN_SECTIONS]

    def _bounds(self, name: str, stage: Stage) -> Freed:
        card = self._book.coefficients[name]
        guess = self._tire.values[name]
        asked = stage.free.get(name, Freed(guess, card.lower, card.upper))
        return Freed(guess, asked.lower, asked.upper)

    def _guess(self, stage: Stage) -> None:
        """Put the stage's own guesses into the tire, or generic ones for what is freed for the first time."""
        cards = self._book.coefficients
        if stage.free:
            guesses = {n: min(max(f.guess, f.lower), f.upper) for n, f in stage.free.items()}
        elif self._given:
            guesses = {}
        else:
            guesses = {n: cards[n].generic for n in self._candidates(stage) if n not in self._freed}
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
            problem.weights = noise_weights(problem, start)
        lower = np.array([f.lower for f in free.values()]) / scale
        upper = np.array([f.upper for f in free.values()]) / scale
        report = partial(self._progress, stage.name)
        solution = self._solved(problem, np.clip(start, lower, upper), lower, upper, channels, report)
        values = dict(zip(free, (solution.x * scale).tolist(), strict=True))
        self._tire = replace(self._tire, values={**self._tire.values, **values})
        self._stages.append(
            StageFit(
                stage.name, len(rows), len(free), solution.iterations, solution.converged, solution.reason,
                solution.cost, self._stage_r2(rows),
            )
        )  # fmt: skip

    def _solved(
        self,
        problem: Problem,
        start: FloatArray,
        lower: FloatArray,
        upper: FloatArray,
        channels: Sequence[str],
        report: Callable[[int, float], None],
    ) -> Solution:
        """Solve, verify the constraints on the dense grid, and solve again with the points that broke them."""
        imposed = self._constraints(channels, 1)
        dense = self._constraints(channels, VERIFIED)
        solution = solve(problem, start, lower, upper, imposed, progress=report)
        for _ in range(ROUNDS):
            broken = []
            for constraint, points in dense:
                values = self._quantity(constraint, points, problem.parameters(solution.x))
                outside = constraint.distance(values) < -TOLERANCE
                if outside.any():
                    broken.append((constraint, points[:, outside]))
            if not broken:
                break
            imposed = imposed + broken
            solution = solve(problem, solution.x, lower, upper, imposed, progress=report)
        return solution

    def _quantity(self, constraint: Constraint, points: FloatArray, parameters: FloatArray) -> FloatArray:
        code = fastest_code(self._book.name)
        values: FloatArray = code.quantities(points, parameters)[code.quantities_names.index(constraint.quantity)]
        return values

    def _stage_r2(self, rows: Rows) -> float:
        computed = fastest_code(self._tire.model).forces(rows.inputs, self._tire.parameters()).T
        there = np.isfinite(rows.measured)
        weights = equal_weights(rows)[0]
        squares = np.sum(np.where(there, computed - rows.measured, 0.0) ** 2, axis=0) * weights
        return 1 - float(np.mean(squares[there.any(axis=0)]))

    def _constraints(self, channels: Sequence[str], density: int) -> list[tuple[Constraint, FloatArray]]:
        nominal = {name: self._tire.nominal(name) for name in self._tire.inputs}
        conditions = VALIDITY.get(self._book.name, {})
        return [
            (c, grid(c, self._ranges, nominal, density=density)) for name in channels for c in conditions.get(name, ())
        ]

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
        tire = replace(self._tire, ranges=ranges, about=about)  # the same inputs in ISO
        coefficients = tuple(self._told(name, signs) for name in self._book.coefficients if name in self._freed)
        undetermined = [c.name for c in coefficients if not c.determined]
        if undetermined:
            self._notes.append(f"not determined by these data, left as they were: {', '.join(undetermined)}")
        return FitResult(
            tire.in_signs("iso"), signs, coefficients, self._channels(recordings, tire), tuple(self._stages),
            self._margins(), tuple(self._notes), seconds, self._plan.name,
        )  # fmt: skip

    def _told(self, name: str, signs: str) -> FittedCoefficient:
        freed = self._freed[name]
        card, value = self._book.coefficients[name], self._tire.values[name]
        guess, lower, upper = freed.bounds.guess, freed.bounds.lower, freed.bounds.upper
        # An interior-point solution keeps a little off its bounds.
        near = 1e-3 * max(abs(value), 0.01 * (upper - lower) if np.isfinite(upper - lower) else 0.0)
        at_bound = freed.determined and (value - lower <= near or upper - value <= near)
        if signs == "iso" and card.flips:
            guess, lower, upper, value = (0.0 - number for number in (guess, upper, lower, value))  # no -0.0
        return FittedCoefficient(name, card.unit, guess, lower, upper, value, at_bound, freed.determined, freed.stage)

    def _channels(self, recordings: Sequence[Recording], tire: Tire) -> tuple[ChannelFit, ...]:
        units = {quantity.name: quantity.unit for quantity in self._book.outputs}
        told = []
        for number, name in enumerate(_distinct([recording.source for recording in recordings])):
            table = self._data[self._data["recording"] == number]
            rows = Rows.of(table, tire, self._fitted)
            computed = fastest_code(tire.model).forces(rows.inputs, tire.parameters())
            for index, channel in enumerate(tire.outputs):
                n, rmse, r2, uncentred = quality(rows.measured[:, index], computed[index])
                if n:
                    told.append(ChannelFit(name, channel, units[channel], n, rmse, r2, uncentred))
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


def _size(lower: float, upper: float, guess: float) -> float:
    """Return the size of a coefficient for the solver: a quarter of its card's range, not less than its guess."""
    span = upper - lower
    return max(abs(guess), 0.25 * span if np.isfinite(span) else 1.0, 1e-3)


def _influence(tire: Tire, rows: Rows, names: Sequence[str]) -> set[str]:
    """Return the coefficients that change some measured force at these rows.

    Looked at from the present values and from two random points beside them: where a factor is at neutral,
    what it multiplies shows nothing, though it may once the factor moves.
    """
    book, code = tire.book, fastest_code(tire.model)
    order = [card.name for card in book.parameters]
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
