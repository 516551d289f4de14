"""The state of a running fit: it solves the stages of a recipe one after another and returns the result."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence, Set
from dataclasses import dataclass, replace
from functools import partial
from math import inf, nan

import numpy as np
import pandas as pd

from ..boundary.errors import FitError
from ..measurements.checks.recordings.coverage import coverage_texts
from ..measurements.recording import distinct
from ..tires.code import fastest_code
from ..tires.property_file.names import assumed_lines, in_written_order, not_measured_lines, unmeasured_coefficients
from ..tires.summary import idle_effects, idle_notes
from ..tires.tire import Tire
from .constraints.physical import operating_range
from .constraints.verification import VerifiedConstraints
from .data.simulated_states import with_states
from .evidence.coverage import coverage
from .evidence.residuals import Residuals
from .fit_result import FitResult
from .problem.effective_weights import effective_weights
from .problem.ellipse import ellipse_values
from .problem.influence import generic, influence, typical_size
from .problem.recipe import Freed, Stage
from .problem.rows import Rows
from .problem.weighted_residuals import Problem, coefficients_by_output
from .problem.weights import emphasis, equal_weights, limits_of, noise_weights
from .results.goodness_of_fit import channel_fits
from .results.records import FitRecord, FittedCoefficient, StageFit
from .results.solved_stage import Ended, FitSolution, SolvedStage
from .setup import Setup
from .solvers.convergence import noise_of
from .solvers.interruption import Interruption
from .solvers.restarts import best_end, best_root
from .stage_solution import StageSolver
from .stiffness_targets import StiffnessTargets
from .uncertainty.sandwich import uncertainty_of_stages

#: Strength of the regularization of scaled coefficients, by the weights of the stage: with noise weights the cost is
#: about 1/2, with equal weights about the share of noise.
RIDGE = {"equal": 1e-8, "noise": 1e-5}
#: How often a stage is solved again with states that its own result has driven. States change forces by some percent
#: and forces drive states, so that each round reduces the change by a factor of ten or more.
STATE_ROUNDS = 2


@dataclass(frozen=True)
class Release:
    """A freed coefficient: its first guess and last bounds, the last stage that determined it, whether one did."""

    bounds: Freed
    stage: str
    determined: bool


class FitRun:
    """State of a running fit: the current tire and the results of its stages."""

    def __init__(self, setup: Setup, interruption: Interruption) -> None:
        plan, data, tire = setup.plan, setup.data, setup.tire
        self._options, self._loss, self._solver = plan.options, plan.loss, plan.solver
        self._targets = StiffnessTargets(plan.options.stiffness_weight)
        self._fixed = plan.options.fixed.keys()
        self._given = plan.start is not None  # generic values do not replace those of a start tire
        self._assumed = setup.assumed  # coefficients with assumed values, unless the fit determines them
        self._inherited = frozenset[str]() if plan.start is None else unmeasured_coefficients(plan.start)
        self._family = plan.family
        self._read = setup.read  # initial values read from the data; all others are generic
        self._model, self._tire, self._plan = plan.symbolic_model, tire, plan.recipe
        self._fit_data, self._data = data, data.fitted
        self._interruption = interruption
        self._notes = list(setup.notes)
        self._emphasis = emphasis(self._data, tire.outputs)
        self._ranges = operating_range(self._data, tire)
        self._constraints = VerifiedConstraints(tire, plan.constraints, self._ranges)
        self._stages: list[StageFit] = []
        self._ends: list[tuple[Ended, Problem]] = []
        self._freed: dict[str, Release] = {}
        turning = [self._data[name].any() for _, name in plan.symbolic_model.on_demand if name in self._data]
        self._straight = not any(turning)  # no row has turn slip: its coefficients have no influence
        measured = self._data.notna().any()
        self._fitted = [quantity.name for quantity in plan.symbolic_model.outputs if measured.get(quantity.name, False)]
        self._every: tuple[pd.DataFrame, Rows] | None = None  # the data, and the rows of all of them
        if not tire.states:  # simulated states are inputs, which change
            rows = Rows.of(self._data, tire, self._fitted)
            self._data = rows.in_table(self._data, tire)
            self._every = self._data, rows
            if len(data.table) == len(rows):
                self._fit_data = replace(data, table=self._data)  # its columns share no memory with these
        self._done = 0  # completed stages of the recipe

    def run(self) -> None:
        """Solve the stages until a stop is requested; report the tire of each completed stage."""
        self._interruption.plan(self._work)
        for stage in self._plan.stages:
            if self._stop():
                break
            self._run(stage)
            if self._stop():
                break
            self._done += 1
            self._interruption.completed(self._tire)

    def _work(self) -> list[tuple[str, float]]:
        """Return the names and the work of the stages to come: rows times coefficients."""
        sizes = [(stage, len(self._table(stage)[0]), len(self._candidates(stage))) for stage in self._plan.stages]
        return [(stage.name, float(min(rows, stage.rows or rows) * free)) for stage, rows, free in sizes if rows]

    def _stop(self) -> bool:
        return self._interruption.requested

    def _table(self, stage: Stage) -> tuple[pd.DataFrame, list[str]]:
        """Return all rows of a stage, and its channels."""
        channels = self._channels_of(stage)
        chosen = stage.select(self._data)
        if not channels:
            return chosen[:0], channels
        present = chosen[channels].notna().any(axis=1)
        return chosen if present.all() else chosen[present], channels

    def _rows_of(self, table: pd.DataFrame, channels: Sequence[str]) -> Rows:
        """Return the rows of a table; those of all data have the inputs of one object."""
        if table is not self._data:
            return Rows.of(table, self._tire, channels)
        if self._every is None or self._every[0] is not table:
            self._every = table, Rows.of(table, self._tire, self._fitted)
        return self._every[1].only([name in channels for name in self._tire.outputs])

    def _run(self, stage: Stage) -> None:
        """Solve one stage and store its values in the tire."""
        self._simulate_states(())
        table, channels = self._table(stage)
        if not channels and not stage.free:
            return  # the recipe covers channels that were not measured
        if table.empty:
            requested = ", ".join(stage.channels) or "the data"
            self._notes.append(f"stage {stage.name!r} skipped: no row of {requested} meets its conditions")
            return
        rows = self._rows_of(table, channels)
        self._set_initial_values(stage)
        bounds = {name: self._bounds(name, stage) for name in self._candidates(stage)}
        part = rows.sample(stage.rows)
        free = self._determined(bounds, part, stage)
        if not free:
            self._notes.append(f"stage {stage.name!r} skipped: its rows determine none of its coefficients")
            return
        solved, ended = len(self._stages), len(self._ends)
        self._solve(stage, part, free, channels)
        for _ in range(STATE_ROUNDS if self._tire.states else 0):
            del self._stages[solved:], self._ends[ended:]
            self._simulate_states(free)
            rows = self._rows_of(self._table(stage)[0], channels)
            self._solve(stage, rows.sample(stage.rows), {name: self._bounds(name, stage) for name in free}, channels)

    def _simulate_states(self, free: Collection[str]) -> None:
        """Put the course of the states of effects, simulated with the present values, into the data.

        Starts that are fitted to segments are estimated together with the free coefficients.
        """
        if self._tire.states:
            self._data = with_states(self._fit_data, self._tire, free)

    def _channels_of(self, stage: Stage) -> list[str]:
        return [name for name in self._fitted if not stage.channels or name in stage.channels]

    def _candidates(self, stage: Stage) -> list[str]:
        """Return the coefficients that a stage may free: those that influence its channels, by section and effect."""
        reaching = coefficients_by_output(self._model, straight=self._straight)
        reaches = frozenset[str]().union(*(reaching[name] for name in self._channels_of(stage)))
        live = (self._model.live(self._tire.has) & reaches) - self._fixed
        if stage.free:
            return [name for name in stage.free if name in live]
        if stage.effects is not None:
            live &= self._model.live(self._tire.has.intersection(stage.effects))
        declarations = self._model.coefficients
        named = [
            name
            for name, declaration in declarations.items()
            if (declaration.section in stage.sections or not stage.sections)
        ]
        return [name for name in named if name in live and (stage.sections or declarations[name].fitted)]

    def _bounds(self, name: str, stage: Stage) -> Freed:
        declaration = self._model.coefficients[name]
        guess = self._tire.values[name]
        given = stage.free.get(name, Freed(guess, declaration.lower, declaration.upper))
        return Freed(guess, given.lower, given.upper)

    def _set_initial_values(self, stage: Stage) -> None:
        """Set the guesses of the stage, or generic values of coefficients that no stage has determined yet."""
        declarations = self._model.coefficients
        if stage.free:
            guesses = {n: min(max(f.guess, f.lower), f.upper) for n, f in stage.free.items() if n not in self._fixed}
        elif self._given:
            guesses = {}
        else:
            determined = {name for name, release in self._freed.items() if release.determined}
            new = [name for name in self._candidates(stage) if name not in determined]
            guesses = {name: self._read.get(name, generic(declarations[name])) for name in new}
        self._tire = replace(self._tire, values={**self._tire.values, **guesses})

    def _determined(self, bounds: dict[str, Freed], rows: Rows, stage: Stage) -> dict[str, Freed]:
        """Return the coefficients that the rows determine; reset the others from generic values to their defaults."""
        seen = influence(self._tire, rows.sample(1000), list(bounds))
        if self._family and stage.weights == "noise":
            seen |= bounds.keys() & set(self._family.names)
        for name, freed in bounds.items():
            before = self._freed.get(name)
            if before is None or name in seen or not before.determined:
                first = freed.guess if before is None else before.bounds.guess
                self._freed[name] = Release(replace(freed, guess=first), stage.name, name in seen)
        unseen = {n: self._model.coefficients[n].default for n in bounds if not self._freed[n].determined}
        if not stage.free and not self._given:
            self._tire = replace(self._tire, values={**self._tire.values, **unseen})
        return {name: freed for name, freed in bounds.items() if name in seen}

    def _solve(self, stage: Stage, rows: Rows, free: dict[str, Freed], channels: Sequence[str]) -> None:
        problem = self._problem_of(stage, self._tire, rows, free)
        scale = problem.scale
        start = np.array([f.guess for f in free.values()]) / scale
        lower = np.array([f.lower for f in free.values()]) / scale
        upper = np.array([f.upper for f in free.values()]) / scale
        solver = StageSolver(
            problem, lower, upper, self._constraints, channels, self._stage_type(stage), RIDGE[stage.weights],
            self._solver, partial(self._interruption.report, stage.name), self._stop,
        )  # fmt: skip
        first = solver.solve(np.clip(start, lower, upper), continues=self._continues(stage))
        solution = best_end(problem, first, solver.solve, lower, upper, stage.again, always=self._given)
        if self._options.method == "ipopt" and self._stage_type(stage) == "final":
            solution = best_root(problem, solution, solver.near, partial(solver.solve, continues=True), lower, upper)
        solution = solution.accepted()
        bounds = ([f.lower for f in free.values()], [f.upper for f in free.values()])  # scaling back may round beyond
        values = dict(zip(free, np.clip(solution.x * scale, *bounds).tolist(), strict=True))
        self._tire = replace(self._tire, values={**self._tire.values, **values})
        if stage.rows is None or len(rows) < stage.rows:
            # A random sample has no correlation in time.
            self._ends.append((Ended(self._plan.stages.index(stage), free, solution.x), problem))
        self._stages.append(
            StageFit(
                stage.name, len(rows), len(free), solution.iterations, solution.converged, solution.reason,
                solution.cost, self._stage_r2(rows), solution.detail,
            )
        )  # fmt: skip

    def _problem_of(self, stage: Stage, tire: Tire, rows: Rows, free: Mapping[str, Freed]) -> Problem:
        """Return the problem of a stage, with weights from the residuals at its initial values."""
        declarations = self._model.coefficients
        scale = np.array(
            [typical_size(declarations[name].lower, declarations[name].upper, f.guess) for name, f in free.items()]
        )
        problem = Problem(tire, rows, tuple(free), equal_weights(rows), scale, self._loss)
        start = np.array([f.guess for f in free.values()]) / scale
        if stage.weights == "noise":
            problem.weights = noise_weights(problem, start, self._emphasis)
            if self._options.rows == "independent":
                problem.weights = effective_weights(problem, start)
            if stage.rows is None:
                self._targets.add(problem, start, self._data)
            if self._family:
                rows_in_effect = noise_of(problem, start)[1]
                problem.prior = self._family.prior(problem.free, scale, 1.0 / max(rows_in_effect, 1.0))
        problem.limits = limits_of(problem, start)
        return problem

    def _stage_type(self, stage: Stage) -> str:
        """Return the stage type: intermediate, penultimate (before a stage with all rows), or final.

        A stage is final if it uses all rows, or if no later stage frees all of its coefficients.
        """
        following = self._plan.stages[self._plan.stages.index(stage) + 1 :]
        candidates = set(self._candidates(stage))
        if stage.rows is None or not any(candidates.issubset(self._candidates(later)) for later in following):
            return "final"
        return "penultimate" if following[0].rows is None else "intermediate"

    def _continues(self, stage: Stage) -> bool:
        """Return whether the stage before has the same channels and coefficients, and fewer rows."""
        before = self._plan.stages[: self._plan.stages.index(stage)][-1:]
        return stage.rows is None and any(
            other.rows is not None
            and self._channels_of(other) == self._channels_of(stage)
            and self._candidates(other) == self._candidates(stage)
            for other in before
        )

    def _stage_r2(self, rows: Rows) -> float:
        squares, present = np.zeros(rows.measured.shape[1]), np.isfinite(rows.measured).any(axis=0)
        for block in rows.blocks():
            computed = fastest_code(self._tire.symbolic_model).forces(block.inputs, self._tire.parameters()).T
            weighted = np.where(np.isfinite(block.measured), computed - block.measured, 0.0) ** 2
            squares += block.weight @ weighted
        return 1 - float(np.mean((squares * equal_weights(rows)[0])[present]))

    def result(self, recordings: Sequence[str], seconds: float) -> FitResult:
        """Return the result of a fit to recordings with these names, with coefficients in adapted SAE."""
        if not self._stages and self._stop():
            raise KeyboardInterrupt  # no values to return yet
        if not self._stages:
            raise FitError("no stage of the recipe found rows to fit: " + "; ".join(self._notes))
        determined = {name for name, release in self._freed.items() if release.determined}
        self._set_unmeasured(determined)
        ranges = {name: bounds for name, bounds in self._ranges.items() if name in self._data and bounds[0] < bounds[1]}
        about = {**self._tire.about, "recipe": self._plan.name, "data": ", ".join(recordings)}
        declarations = self._model.coefficients
        values = {
            name: value
            for name, value in self._tire.values.items()
            if not declarations[name].section.endswith("_RANGE")
        }
        tire = replace(self._tire, values=values, ranges=ranges, about=about)  # inputs in ISO
        fitted = {name: self._fitted_coefficient(name) for name in self._model.coefficients if name in self._freed}
        ends = [(self._plan.stages[end.stage].name, problem, end.x) for end, problem in self._ends]
        uncertainty = uncertainty_of_stages(
            ends,
            {name: coefficient.stage for name, coefficient in fitted.items()},
            {name for name, coefficient in fitted.items() if coefficient.at_bound},
            (int(self._data["recording"].max()) + 1, len(self._tire.outputs)),
            self._options.sensor_errors,
        )
        coefficients = tuple(replace(c, interval=uncertainty.intervals.get(name, nan)) for name, c in fitted.items())
        if self._family:
            coefficients, tire, notes = self._family.marked(coefficients, tire)
            self._notes += notes
        undetermined = [c.name for c in coefficients if not c.determined]
        if undetermined:
            self._notes.append(f"not determined by these data, unchanged: {', '.join(undetermined)}")
        self._notes += idle_notes(n for n in idle_effects(tire) if n in (self._options.effects or ()))
        sources = distinct(recordings)
        residuals, solved = Residuals.of(self._data, sources, self._tire), [self._solved(*end) for end in self._ends]
        channels = channel_fits(self._fit_data, residuals, uncertainty.effective_rows)
        unidentified = {c.name for c in coefficients if c.interval == inf and not c.from_family}
        tire = replace(tire, other_entries=self._origin(determined, unidentified, residuals))
        return FitResult(
            tire.in_signs("iso"), self._tire.signs, coefficients, channels,
            FitRecord(tuple(self._stages), self._plan.name, self._options.method, seconds, self._interrupted()),
            self._constraints.margins(self._fitted, self._tire.parameters()),
            tuple(self._notes), self._fit_data.findings, uncertainty.directions, self._fit_data.excluded_rows,
            covariance=uncertainty.covariance,
            solution=FitSolution(residuals, uncertainty.complete, tuple(solved), uncertainty.discrepancies),
        )  # fmt: skip

    def _set_unmeasured(self, determined: Set[str]) -> None:
        """Set coefficients of combined slip that neither data nor a given tire determine: the friction ellipse."""
        unknown = (self._assumed & self._model.live(self._tire.has)) - determined
        values = {} if self._given or self._family else ellipse_values(self._tire, unknown)
        if values:
            shown = ", ".join(f"{name} {value:.3g}" for name, value in values.items())
            self._notes.append(f"combined slip that was not measured keeps to the friction ellipse: {shown}")
            self._tire = replace(self._tire, values={**self._tire.values, **values})

    def _origin(
        self, determined: Set[str], unidentified: Set[str], residuals: Residuals
    ) -> tuple[tuple[str, str, str], ...]:
        """Return the entries of the tire file with what nobody gave, and what the data do not show."""
        unmeasured = (self._assumed | self._inherited) - determined | unidentified
        unmeasured &= self._model.live(self._tire.has)
        names = [n for n, declaration in self._model.coefficients.items() if n in unmeasured and declaration.fitted]
        lines = [
            *assumed_lines(self._assumed - determined, self._model),
            *not_measured_lines(coverage_texts(coverage(residuals)), names),
        ]
        return in_written_order(lines, self._model)

    def _solved(self, end: Ended, problem: Problem) -> SolvedStage:
        """Return the record of a stage from which it can be solved again."""
        stage = self._plan.stages[end.stage]
        table, channels = self._table(stage)
        constraints = self._constraints.of(channels) + self._constraints.violated
        last = {name for name, release in self._freed.items() if release.determined and release.stage == stage.name}
        return SolvedStage.of(stage.name, end, problem, constraints, RIDGE[stage.weights], table.index, last)

    def _interrupted(self) -> str:
        """Return where the fit was stopped and how many stages are complete; empty if it is complete."""
        remaining = len(self._plan.stages) - self._done
        if not self._stop() or not remaining:
            return ""
        return f"{self._interruption.where}, {self._done} of {len(self._plan.stages)} stages done"

    def _fitted_coefficient(self, name: str) -> FittedCoefficient:
        freed = self._freed[name]
        declaration, value = self._model.coefficients[name], self._tire.values[name]
        guess, lower, upper = freed.bounds.guess, freed.bounds.lower, freed.bounds.upper
        # An interior-point solution is slightly inside its bounds.
        near = 1e-3 * max(abs(value), upper - lower if np.isfinite(upper - lower) else 0.0)
        at_bound = freed.determined and (value - lower <= near or upper - value <= near)
        return FittedCoefficient(
            name, declaration.unit, guess, lower, upper, value, at_bound, freed.determined, freed.stage
        )
