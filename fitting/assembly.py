"""The result of a fit, from its last state."""

from __future__ import annotations

from collections.abc import Sequence, Set
from dataclasses import replace
from math import inf, nan

import numpy as np

from ..boundary.errors import FitError
from ..measurements.checks.recordings.coverage import coverage_texts
from ..measurements.recording import distinct
from ..tires.property_file.names import assumed_lines, in_written_order, not_measured_lines, unmeasured_coefficients
from ..tires.summary import idle_effects, idle_notes
from ..tires.tire import Tire
from .checks.coverage import coverage
from .checks.residuals import Residuals
from .fit_result import FitResult
from .problem.ellipse import ellipse_values
from .results.goodness_of_fit import channel_fits
from .results.records import FittedCoefficient
from .results.stages import FitRecord
from .setup import Setup
from .solvers.interruption import Interruption
from .stage import FitState
from .uncertainty.sandwich import Uncertainty, uncertainty_of_stages


def result_of(
    setup: Setup, state: FitState, recordings: Sequence[str], seconds: float, interruption: Interruption
) -> FitResult:
    """Return the result of a fit to recordings with these names, with coefficients in adapted SAE.

    Raises `KeyboardInterrupt` if the fit was stopped before it had values, `FitError` if no stage had rows.
    """
    if not state.stages and interruption.requested:
        raise KeyboardInterrupt
    if not state.stages:
        raise FitError("no stage of the recipe found rows to fit: " + "; ".join(state.notes))
    plan, data = setup.plan, setup.data
    state = _with_unmeasured(setup, state)
    fitted = _coefficients(setup, state)
    uncertainty = _uncertainty(setup, state, fitted)
    coefficients = tuple(replace(c, interval=uncertainty.intervals.get(c.name, nan)) for c in fitted)
    tire, notes = _described(setup, state, recordings), list(state.notes)
    if plan.family:
        coefficients, tire, marks = plan.family.marked(coefficients, tire)
        notes += marks
    if undetermined := [c.name for c in coefficients if not c.determined]:
        notes.append(f"no influence on these data, unchanged: {', '.join(undetermined)}")
    notes += idle_notes(name for name in idle_effects(tire) if name in (plan.options.effects or ()))
    residuals = Residuals.of(state.table, distinct(recordings), state.tire)
    unidentified = {c.name for c in coefficients if c.interval == inf and not c.from_family}
    tire = replace(tire, other_entries=_origin(setup, state, unidentified, residuals))
    # Each stage with the constraints of the whole fit.
    stages = tuple(replace(stage, constraints=(*stage.constraints, *state.violated)) for stage in state.stages)
    where = interruption.after(state.completed, len(plan.recipe.stages))
    return FitResult(
        tire.in_signs("iso"), state.tire.signs, coefficients, channel_fits(data, residuals, uncertainty.effective_rows),
        FitRecord(stages, plan.recipe.name, plan.options.method, seconds, where),
        setup.constraints.margins(setup.channels, state.tire.parameters()),
        tuple(notes), data.findings, data.excluded_rows, uncertainty=uncertainty, residuals=residuals,
    )  # fmt: skip


def _with_unmeasured(setup: Setup, state: FitState) -> FitState:
    """Set coefficients of combined slip that neither data nor a given tire determine: the friction ellipse."""
    plan = setup.plan
    if plan.start is not None or plan.family:
        return state
    unknown = (setup.assumed & plan.symbolic_model.live(state.tire.has)) - state.determined
    values = ellipse_values(state.tire, unknown)
    if not values:
        return state
    shown = ", ".join(f"{name} {value:.3g}" for name, value in values.items())
    return state.with_values(values).with_note(
        f"combined slip that was not measured keeps to the friction ellipse: {shown}"
    )


def _coefficients(setup: Setup, state: FitState) -> tuple[FittedCoefficient, ...]:
    """Return the coefficients that stages have freed, without intervals."""
    fitted = []
    for name, declaration in setup.plan.symbolic_model.coefficients.items():
        if name not in state.free:
            continue
        freed, value = state.free[name], state.tire.values[name]
        lower, upper = freed.lower, freed.upper
        # An interior-point solution is slightly inside its bounds.
        near = 1e-3 * max(abs(value), upper - lower if np.isfinite(upper - lower) else 0.0)
        at_bound = freed.determined and (value - lower <= near or upper - value <= near)
        fitted.append(
            FittedCoefficient(
                name, declaration.unit, freed.guess, lower, upper, value, at_bound, freed.determined, freed.stage
            )
        )
    return tuple(fitted)


def _uncertainty(setup: Setup, state: FitState, fitted: Sequence[FittedCoefficient]) -> Uncertainty:
    return uncertainty_of_stages(
        [(stage.name, stage.problem, stage.x) for stage in state.stages if len(stage.numbers)],
        {c.name: c.stage for c in fitted},
        {c.name for c in fitted if c.at_bound},
        (int(state.table["recording"].max()) + 1, len(state.tire.outputs)),
        setup.plan.options.sensor_errors,
    )


def _described(setup: Setup, state: FitState, recordings: Sequence[str]) -> Tire:
    """Return the tire with the measured ranges, the recipe and the data."""
    tire, declared = state.tire, setup.plan.symbolic_model.coefficients
    ranges = {name: ends for name, ends in setup.ranges.items() if name in state.table and ends[0] < ends[1]}
    about = {**tire.about, "recipe": setup.plan.recipe.name, "data": ", ".join(recordings)}
    values = {name: value for name, value in tire.values.items() if not declared[name].section.endswith("_RANGE")}
    return replace(tire, values=values, ranges=ranges, about=about)  # inputs in ISO


def _origin(
    setup: Setup, state: FitState, unidentified: Set[str], residuals: Residuals
) -> tuple[tuple[str, str, str], ...]:
    """Return the entries of the tire file on assumed values and on characteristics that the data do not determine."""
    model, start = setup.plan.symbolic_model, setup.plan.start
    inherited = frozenset[str]() if start is None else unmeasured_coefficients(start)
    unmeasured = (setup.assumed | inherited) - state.determined | unidentified
    unmeasured &= model.live(state.tire.has)
    names = [name for name, declaration in model.coefficients.items() if name in unmeasured and declaration.fitted]
    lines = [
        *assumed_lines(setup.assumed - state.determined, model),
        *not_measured_lines(coverage_texts(coverage(residuals)), names),
    ]
    return in_written_order(lines, model)
