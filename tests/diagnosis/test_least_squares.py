"""Least squares of the diagnosis: cost, derivatives, bounds, recovery of a known tire, disturbances."""

import itertools
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from tirefmu.diagnosis import LeastSquares, Projected
from tirefmu.diagnosis.explanations import balanced
from tirefmu.diagnosis.probing import fit_baseline
from tirefmu.diagnosis.signals import load_error_responses, reported_disturbances, signals_of, simulation
from tirefmu.symbolic.added import library
from tirefmu.symbolic.models import model_named
from tirefmu.tires import Tire
from tirefmu.tires.code import code_for

from ..relatives import slow_but
from .conftest import NOISE, VALUES, measured, sweeps

FREE = ("PDX1", "PKX1", "PDY1", "PDY2", "PKY1", "PHY1", "QDZ1")


def test_a_tire_is_recovered_from_other_initial_values(problem, tire):
    start = tire.parameters()
    indices = [problem.simulator.index[name] for name in FREE]
    truth = start[indices].copy()
    start[indices] *= 0.8
    solution = problem.solve(start, FREE)
    _, _, matrix = Projected(problem, start, FREE).derivatives(solution.parameters[indices])
    deviation = np.sqrt(np.diag(np.linalg.inv(matrix)))
    assert np.max(np.abs(solution.parameters[indices] - truth) / deviation) < 4.0
    assert solution.cost < 0.5 * problem.inverse_noise.size
    np.testing.assert_array_equal(np.delete(solution.parameters, indices), np.delete(start, indices))


def test_a_fit_that_is_stopped_is_at_its_latest_step(problem, tire):
    start = tire.parameters()
    start[[problem.simulator.index[name] for name in FREE]] *= 0.8
    asked = itertools.count()
    stopped = replace(problem, stop=lambda: next(asked) > 0).solve(start, FREE)
    assert problem.solve(start, FREE).cost < stopped.cost < problem.at(start, FREE).cost


def test_the_gradient_equals_finite_differences_of_the_cost(problem, tire):
    """With optimal disturbances and informative priors; the cost is half the sum of all squares."""
    # The data have little weight: otherwise the gradient hardly changes with the sign of the priors' part.
    center = {**problem.center, "PDY1": 1.2, "PKY1": 60.0}
    held = replace(problem, center=center, inverse_noise=1e-2 * problem.inverse_noise)
    parameters, index = tire.parameters(), [held.simulator.index[name] for name in FREE]
    cost, gradient, _ = Projected(held, parameters, FREE).derivatives(parameters[index])
    solution = held.at(parameters, FREE)
    center, deviation = held.prior(FREE)
    errors = held.disturbances
    parts = [held.weighted(solution.residual), (parameters[index] - center) / deviation]
    parts += [(solution.disturbance - errors.center) / errors.deviation]
    assert cost == solution.cost == pytest.approx(0.5 * sum(float(np.sum(part**2)) for part in parts))
    for i, name in enumerate(FREE):
        costs = []
        for sign in (1.0, -1.0):
            moved = parameters.copy()
            step = 1e-5 * abs(moved[held.simulator.index[name]])
            moved[held.simulator.index[name]] += sign * step
            costs.append(held.at(moved, FREE).cost)
        assert (costs[0] - costs[1]) / (2.0 * step) == pytest.approx(gradient[i], rel=1e-4)


class BoundFriction(LeastSquares):
    """A problem in which the bound of PDY1 excludes the true value."""

    def bounds(self, free):
        lower, upper = super().bounds(free)
        return lower, np.where(np.array(free) == "PDY1", 1.5, upper)


def test_a_coefficient_beyond_its_bound_ends_at_the_bound(problem, tire):
    bound = BoundFriction(problem.simulator, problem.inverse_noise, problem.disturbances, problem.center)
    index = problem.simulator.index["PDY1"]
    assert tire.parameters()[index] > 1.5
    solution = bound.solve(tire.parameters(), FREE)
    assert solution.parameters[index] == 1.5
    assert bound.at_bounds(solution.parameters, FREE) == ("PDY1",)
    assert bound.at_bounds(tire.parameters(), ("PKY1", "PHY1")) == ()
    values = solution.parameters[[problem.simulator.index[name] for name in FREE]]
    _, gradient, _ = Projected(bound, solution.parameters, FREE).derivatives(values)
    assert gradient[FREE.index("PDY1")] < 0.0  # a larger value would decrease the cost


def test_a_coefficient_that_is_neutral_at_its_bound_is_absent_not_limited():
    carcass = library()["carcass_2nd_order"]
    tire = Tire("mf61", {"FNOMIN": 4000.0, "UNLOADED_RADIUS": 0.3}, added=(carcass,))
    model = tire.symbolic_model
    simulator = SimpleNamespace(
        symbolic_model=model, tire=tire, index={name: i for i, name in enumerate(model.parameters)}
    )
    problem, parameters = LeastSquares(simulator, None, None, {}), tire.parameters()
    names = ("CASIG", "CAFREQ", "CADAMP")
    assert tire.symbolic_model.coefficients["CASIG"].lower == tire.values["CASIG"] == 0.0
    assert problem.at_bounds(parameters, names) == ()
    for name, value in (("CASIG", 10.0), ("CADAMP", 0.0)):  # without damping is not without effect
        parameters[simulator.index[name]] = value
    assert problem.at_bounds(parameters, names) == ("CASIG", "CADAMP")


def test_excluded_rows_have_no_influence(problem, tire):
    parameters, silent = tire.parameters(), problem.inverse_noise == 0.0
    signals = problem.simulator.signals
    assert silent.any()
    spoiled = replace(signals, measured=np.where(silent, 1e4, signals.measured))
    other = replace(problem, simulator=problem.simulator.with_signals(spoiled))
    one, two = (each.at(parameters, FREE).disturbance for each in (problem, other))
    np.testing.assert_allclose(one, two, atol=1e-9)


def test_priors_are_within_the_bounds_and_narrower():
    size = {"FNOMIN": 4000.0, "UNLOADED_RADIUS": 0.3}
    models = (model_named("mf96"), Tire("mf61", size, added=tuple(library().values())).symbolic_model)
    declarations = {**models[0].coefficients, **models[1].coefficients}
    for model in models:
        assert {"PCY1", "PDY2", "RBY1"} < model.prior_spread.keys()
        for name, spread in model.prior_spread.items():
            assert 0.0 < spread < declarations[name].upper - declarations[name].lower, name
        for name, center in model.prior_center.items():
            assert declarations[name].lower <= center <= declarations[name].upper, name


# ------------------------------------------------------------------ disturbances of the recording


def test_offsets_drifts_and_cross_talk_are_estimated(problem, tire):
    signals = problem.simulator.signals
    along = np.linspace(0.0, np.pi, signals.measured.shape[1])
    index = {name: i for i, name in enumerate(signals.channels)}
    measured = signals.measured.copy()
    measured[index["Fx"]] += 12.0
    measured[index["Mz"]] += 0.6 * np.cos(2.0 * along)
    measured[index["Fy"]] += 0.004 * signals.measured[index["Fx"]]
    other = replace(problem, simulator=problem.simulator.with_signals(replace(signals, measured=measured)))
    found = other.at(tire.parameters(), FREE).disturbance
    reported = reported_disturbances(problem.disturbances, found, other.simulator.signals)
    assert reported["offset"]["Fx"] == pytest.approx(12.0, abs=1.0)
    assert reported["offset"]["Fy"] == pytest.approx(0.0, abs=1.0)
    assert reported["drift"]["Mz"] == pytest.approx(0.6 / np.sqrt(2.0), rel=0.2)
    assert reported["drift"]["Fx"] < 1.0
    assert reported["cross_talk"]["Fx_in_Fy"] == pytest.approx(0.004, rel=0.15)
    assert abs(reported["cross_talk"]["Fy_in_Fx"]) < 0.0005


def test_the_final_fit_weights_each_channel_by_its_residual_over_noise(problem, at_true_values):
    """Inexact formulas are wrong in many rows together; the weights that the problem had do not matter."""
    solution, noise = at_true_values.solution, problem.inverse_noise
    used = noise > 0.0
    sizes = np.sqrt(np.mean((noise * solution.residual) ** 2, axis=1, where=used))
    inexact = replace(solution, residual=solution.residual * np.array([1.0, 1.0, 3.0])[:, None] / sizes[:, None])
    for weights in (1.0, np.array([1.0, 4.0, 0.5])[:, None]):
        weighted = balanced(replace(problem, inverse_noise=weights * noise), inexact, noise).inverse_noise
        ratio = (weighted[used] / noise[used]).reshape(3, -1)
        np.testing.assert_allclose(ratio / ratio[0, 0], np.array([1.0, 1.0, 1.0 / 9.0])[:, None] * np.ones_like(ratio))


def test_a_coefficient_may_be_differentiated_twice(problem, at_true_values):
    parameters = at_true_values.solution.parameters
    jacobian = problem.simulator.jacobian(parameters, ("PDY1", "PDX1", "PDY1"))
    np.testing.assert_array_equal(jacobian[:, :, 0], jacobian[:, :, 2])
    assert np.abs(jacobian[:, :, 0]).max() > 0.0


def test_known_disturbances_remain_what_they_are(problem, at_true_values):
    """Nothing of the tire becomes one of them: a fit is that of the recording without them."""
    names, free = problem.disturbances.names, at_true_values.solution.free
    values = {"offset_Fy": 25.0, "cross_talk_Fy_in_Mz": -0.002}
    known = problem.knowing(values)
    removed = sum(value * problem.disturbances.columns[:, :, names.index(name)] for name, value in values.items())
    signals = problem.simulator.signals
    clean = replace(
        problem, simulator=problem.simulator.with_signals(replace(signals, measured=signals.measured - removed))
    )
    start = 1.02 * at_true_values.solution.parameters
    fit = known.solve(start, free)
    named = dict(zip(names, fit.disturbance, strict=True))
    assert {name: named[name] for name in values} == pytest.approx(values, rel=1e-4)
    without = clean.without_disturbances(values).solve(start, free)
    np.testing.assert_allclose(fit.parameters, without.parameters, rtol=1e-4)
    np.testing.assert_allclose(fit.residual, without.residual, atol=1e-3 * np.abs(removed).max())
    free_fit = problem.solve(start, free)
    assert dict(zip(names, free_fit.disturbance, strict=True))["offset_Fy"] != pytest.approx(25.0, rel=0.1)


def test_large_cross_talk_is_not_a_disturbance(problem):
    """Large is more than three standard deviations of its prior."""
    disturbances = problem.disturbances
    values = np.full(len(disturbances.names), 1e3)
    for pair, share in (("Fx_in_Fy", 0.9), ("Fy_in_Mz", -0.9), ("Fy_in_Fx", -1.1)):
        index = disturbances.names.index(f"cross_talk_{pair}")
        values[index] = 3.0 * share * disturbances.deviation[index]
    assert disturbances.implausible(values) == ("cross_talk_Fy_in_Fx",)
    plausible = disturbances.without(disturbances.implausible(values))
    assert set(disturbances.names) - set(plausible.names) == {"cross_talk_Fy_in_Fx"}
    for i, name in enumerate(plausible.names):
        k = disturbances.names.index(name)
        np.testing.assert_array_equal(plausible.columns[:, :, i], disturbances.columns[:, :, k])
        assert plausible.deviation[i] == disturbances.deviation[k]


@pytest.mark.parametrize(
    "effect",
    slow_but({"load_stiffness"}, ("load_stiffness", "load_friction", "camber_stiffness", "pressure_stiffness")),
)
def test_a_fit_of_the_baseline_model_begins_at_the_given_tire(effect, monkeypatch):
    """Also if the tire lacks an effect whose absence rescales a coefficient, or that an effect of the tire acts on."""
    monkeypatch.setattr(simulation, "fastest_code", lambda model: code_for(model, "numpy"))
    model = model_named("mf61")
    effects = model.effects.keys() - model.relaxing_effects - {effect, "turn_slip"}
    lacking = Tire("mf61", {**VALUES, "PKY5": 0.5}, effects=tuple(effects), signs="adapted-sae")
    table = measured(lacking, sweeps(n=1200).assign(p=2e5 + 2e4 * np.sin(0.5 * np.arange(1200) / 50.0)))
    signals = signals_of(table.drop(columns=["Fx", "Mz"]), lacking, "adapted-sae", smooth=False)
    _, solution = fit_baseline(lacking, signals, fitted=True)
    assert np.sqrt(np.mean(solution.residual**2)) < 1.1 * NOISE["Fy"]


def test_an_error_of_the_load_changes_forces_as_the_load_does_and_turns_with_the_slip(problem, tire):
    simulator, parameters = problem.simulator, tire.parameters()
    signals = simulator.signals
    load = (np.array(signals.names) == "Fz")[:, None]
    moved = [
        simulator.with_signals(replace(signals, inputs=signals.inputs * (1.0 + sign * 1e-3 * load))).forces(parameters)
        for sign in (1.0, -1.0)
    ]
    growth = simulator.growth("Fz", parameters)
    np.testing.assert_allclose(growth, (moved[0] - moved[1]) / 2e-3, atol=0.01 * np.abs(growth).max())
    named = signals.named()
    rate = np.gradient(np.hypot(np.tan(named["alpha"]), named["kappa"]), signals.t[signals.rows])
    fast = np.abs(rate) > 0.5 * np.abs(rate).max()
    at_once, late = np.moveaxis(load_error_responses(simulator, parameters), -1, 0)
    np.testing.assert_allclose(at_once[:, fast], (np.sign(rate) * growth)[:, fast], rtol=0.05, atol=1e-9)
    assert np.linalg.norm(late) < 0.9 * np.linalg.norm(at_once)  # a slow controller does not follow all turns
