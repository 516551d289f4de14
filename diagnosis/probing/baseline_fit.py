"""Fit of the baseline model to a recording: several initial values, then weights from the estimated noise."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from ...numerics.arrays import FloatArray
from ...numerics.periodic_lines import periodic_lines
from ...numerics.ties import graded
from ...symbolic.declarations import Coefficient
from ...symbolic.model import Model
from ...tires.tire import Tire
from ..least_squares import LeastSquares, Solution
from ..signals.disturbances import disturbances_of
from ..signals.outliers import short_range
from ..signals.signals import Signals
from ..signals.simulation import Simulator
from ..signals.skew import between_rows
from .candidates import declared_candidate, varies

#: The slip that generates each force.
OWN_SLIP = {"Fx": "kappa", "Fy": "alpha"}


def readable(names: tuple[str, ...], signals: Signals, model: Model) -> tuple[str, ...]:
    """Return the coefficients of a model that influence a measured channel."""
    declarations, measured = model.coefficients, set(signals.channels)
    return tuple(name for name in names if name in declarations and measured & set(declarations[name].channels))


def _in_baseline(declaration: Coefficient, tire: Tire, signals: Signals) -> bool:
    """Return whether a coefficient of the baseline is fitted.

    It is if its force is measured, or if a moment is measured and its slip varies. Example: Mz alone depends on the
    longitudinal slip stiffness, as kappa enters the equivalent slip angle of the trail.
    """
    measured = set(declaration.channels) & set(signals.channels)
    return bool(measured & OWN_SLIP.keys()) or (
        bool(measured)
        and (declaration.channels[0] not in OWN_SLIP or varies(signals, tire, OWN_SLIP[declaration.channels[0]]))
    )


def baseline_coefficients(tire: Tire, signals: Signals) -> tuple[str, ...]:
    """Return the coefficients that the fit of a baseline model adjusts.

    Returns: in the order of the model.
    """
    model = tire.symbolic_model
    declarations = model.coefficients
    declared = [name for name in model.baseline.coefficients if name in declarations]
    free = {name for name in declared if _in_baseline(declarations[name], tire, signals)}
    for effect in tire.has:
        candidate = declared_candidate(effect, model)
        if candidate:
            free |= set(candidate.forms[0].free)
        elif effect in model.effects and effect not in model.relaxing_effects:
            owned = (name for name in model.owned(effect) if declarations[name].fitted)
            free |= {name for name in owned if declarations[name].neutral is not None}
    free &= model.live(tire.has)
    return tuple(name for name in readable(tuple(declarations), signals, model) if name in free)


def fit_baseline(tire: Tire, signals: Signals, *, fitted: bool) -> tuple[LeastSquares, Solution]:
    """Fit the baseline model.

    `tire`: the baseline model. `fitted`: whether its coefficients are those of a fitted tire, which are initial values,
    not defaults; otherwise only nominal values are used. Returns: the problem, with weights from the estimated noise,
    and its solution.
    """
    free = baseline_coefficients(tire, signals)
    simulator = Simulator(tire, signals)
    training = signals.present & ~signals.holdout
    noise = np.array([0.02 * np.std(row[used]) + 1e-9 for row, used in zip(signals.measured, training, strict=True)])
    inverse_noise = np.where(training, 1.0 / noise[:, None], 0.0)
    center = tire.symbolic_model.prior_center | ({name: tire.values[name] for name in free} if fitted else {})
    problem = LeastSquares(
        simulator, inverse_noise, disturbances_of(signals, noise, tire.values["UNLOADED_RADIUS"]), center
    )
    few = problem.subsampled(slice(None, None, max(1, len(signals.rows) // 1500)))
    starts = [tire.parameters()] if fitted else _starts(simulator, free)
    solutions = [problem.at(few.solve(start, free, iterations=25).parameters, free) for start in starts]
    best = problem.solve(min(solutions, key=lambda solution: graded(solution.cost)).parameters, free, iterations=4)
    for _ in range(2):
        problem = reweighted(problem, best)
        trial = problem.at(best.parameters, free).disturbance
        problem = problem.without_disturbances(problem.disturbances.implausible(trial))
        best = problem.solve(best.parameters, free, iterations=8)
    waving = _with_periodic_lines(problem, best)
    return (problem, best) if waving is problem else (waving, waving.solve(best.parameters, free, iterations=4))


def worse_by_smoothing(problem: LeastSquares, solution: Solution, recorded: Signals) -> bool:
    """Return whether the same tire has a smaller misfit with the inputs as recorded.

    Smoothing removes noise of the inputs, but distorts channels that were sampled too coarsely.

    `problem`: of the smoothed signals. `recorded`: of the same recording without smoothing.
    """
    if not any(problem.simulator.signals.origin.noise.values()):
        return False
    other = replace(problem, simulator=problem.simulator.with_signals(recorded))
    sizes = [
        float(np.sum(either.weighted(either.at(solution.parameters, solution.free).residual) ** 2))
        for either in (problem, other)
    ]
    return sizes[1] < sizes[0]


def _with_periodic_lines(problem: LeastSquares, solution: Solution) -> LeastSquares:
    """Return the problem with the periodic disturbances of the residual; the same problem if there are none."""
    signals = problem.simulator.signals
    if not signals.timed:
        return problem
    axes = {"t": signals.t[signals.rows]}
    if "distance" in signals.names and "V" in signals.origin.recorded:
        axes["distance"] = signals.named()["distance"]
    simulated = signals.measured - solution.residual
    lines = periodic_lines(axes, problem.weighted(solution.residual), problem.inverse_noise > 0.0, simulated)
    noise = np.array([1.0 / np.median(row[row > 0.0]) if (row > 0.0).any() else 1.0 for row in problem.inverse_noise])
    if not lines:
        return problem
    return replace(problem, disturbances=problem.disturbances.with_lines(lines, axes, noise, signals.channels))


def _starts(simulator: Simulator, free: tuple[str, ...]) -> list[FloatArray]:
    """Return initial values: each shape of the model's baseline, with friction and stiffness as measured."""
    tire, signals = simulator.tire, simulator.signals
    inputs = signals.named()
    measured = dict(zip(signals.channels, signals.measured, strict=True))
    model, starts = tire.symbolic_model, []
    for shape in model.baseline.starts:
        values = {name: value for name, value in {**model.prior_center, **shape}.items() if name in free}
        for channel, slip in OWN_SLIP.items():
            axis = channel[1]
            if channel not in measured:
                continue
            peak = float(np.quantile(np.abs(measured[channel]) / inputs["Fz"], 0.98))
            small = np.abs(inputs[slip]) < 0.03
            over = inputs[slip][small] * inputs["Fz"][small]
            slope = float(over @ measured[channel][small] / max(over @ over, 1e-12))
            stiffness = min(max(slope, 5.0), 60.0) * 1.1 * tire.values["FNOMIN"]
            for role, target in ((f"friction_{axis}", peak), (f"stiffness_{axis}", stiffness)):
                leading = model.leading(role)
                if leading in free:
                    values[leading] = target / _per_unit(simulator, role, values)
        starts.append(replace(tire, values={**tire.values, **values}).parameters())
    return starts


def _per_unit(simulator: Simulator, role: str, values: Mapping[str, float]) -> float:
    """Return the quantity of a role at nominal inputs per unit of its leading coefficient; 1 if not positive."""
    tire = simulator.tire
    unit_tire = replace(tire, values={**tire.values, **values, tire.symbolic_model.leading(role): 1.0})
    quantity = simulator.at_nominal(role, unit_tire.parameters())
    return quantity if np.isfinite(quantity) and quantity > 0.0 else 1.0


def reweighted(problem: LeastSquares, solution: Solution) -> LeastSquares:
    """Return the problem with weights from the noise of a solution's residual, outliers excluded.

    Returns: the noise of a channel has a constant and a proportional part, estimated from the short-range scatter, and
    what the rows do not determine between them (`between_rows`).
    """
    signals = problem.simulator.signals
    between = between_rows(problem.simulator, solution.parameters)
    simulated = signals.measured - solution.residual
    present = signals.present.copy()
    inverse_noise = np.zeros_like(problem.inverse_noise)
    level = np.zeros(len(signals.channels))
    for i, residual in enumerate(solution.residual):
        scatter, present[i] = short_range(residual, signals.present[i])
        constant, proportional = _two_parts(scatter[present[i]], simulated[i][present[i]])
        deviation = np.sqrt(constant**2 + (proportional * simulated[i]) ** 2 + between[i] ** 2)
        level[i] = float(np.sqrt(np.mean(deviation**2)))
        inverse_noise[i] = np.where(present[i] & ~signals.holdout, 1.0 / deviation, 0.0)
    simulator = problem.simulator.with_signals(replace(signals, present=present))
    return replace(
        problem,
        simulator=simulator,
        inverse_noise=inverse_noise,
        disturbances=disturbances_of(signals, level, problem.simulator.tire.values["UNLOADED_RADIUS"]),
    )


def _two_parts(scatter: FloatArray, force: FloatArray) -> tuple[float, float]:
    """Return the constant and the proportional standard deviation of noise."""
    order = np.argsort(np.abs(force))
    parts = np.array_split(order, 10)
    size = np.array([np.mean(force[part] ** 2) for part in parts])
    power = np.array([(1.4826 * np.median(np.abs(scatter[part]))) ** 2 for part in parts])
    slope, level = np.polyfit(size, power, 1, w=1.0 / (power + 1e-12 + 0.1 * power.mean()))
    level = max(level, 0.1 * float(power.mean()), 1e-12)
    return float(np.sqrt(level)), float(np.sqrt(max(slope, 0.0)))
