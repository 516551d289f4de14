"""The damped Gauss-Newton loop and its step, against SciPy and the conditions of Kuhn and Tucker."""

from __future__ import annotations

from math import inf

import numpy as np
import pytest
from scipy.optimize import least_squares, lsq_linear

from tirefmu.numerics import Damping, best_step, minimize, restore

LEVENBERG = Damping(first=1e-7, least=1e-7, most=1.0, up=10.0, down=0.0, by_curvature=False, trusted=0.1)
MARQUARDT = Damping(first=1e-3, least=1e-7, most=10.0, up=8.0, down=0.1, by_curvature=True, trusted=0.0)
HIGH = np.full(3, 9.0)
T = np.linspace(0.0, 3.0, 60)
TRUTH = np.array([2.0, 1.3, 0.4])
MEASURED = TRUTH[0] * np.exp(-TRUTH[1] * T) + TRUTH[2] + 0.02 * np.random.default_rng(0).standard_normal(60)


class Decay:
    """a exp(-b t) + c, with coefficients in units of `size`."""

    def __init__(self, size=1.0):
        self.size, self.evaluated = np.ones(3) * size, []

    def residual(self, x):
        a, b, c = x * self.size
        return a * np.exp(-b * T) + c - MEASURED

    def cost(self, x):
        self.evaluated.append(x * self.size)
        residual = self.residual(x)
        return 0.5 * float(residual @ residual)

    def derivatives(self, x):
        a, b, _ = x * self.size
        fading = np.exp(-b * T)
        jacobian = np.stack([fading, -a * T * fading, np.ones_like(T)], axis=1) * self.size
        return self.cost(x), jacobian.T @ self.residual(x), jacobian.T @ jacobian


class Curved:
    """The nonlinear constraint a b <= most."""

    low, high = np.array([-inf]), np.array([1.5])

    def values(self, x):
        return np.array([x[0] * x[1]])

    def slopes(self, x):
        return np.array([[x[1], x[0], 0.0]])

    def satisfied(self, values):
        return bool(np.all(values <= self.high + 1e-6))


def tight(x, cost):
    return 1e-12 * cost


def run(objective, start, damping, *, upper=HIGH, steps=60, **options):
    return minimize(objective, np.array(start), np.full(3, -9.0), upper, tight, damping, steps=steps, **options)


@pytest.mark.parametrize("damping", [LEVENBERG, MARQUARDT])
@pytest.mark.parametrize("most", [9.0, 1.0])
def test_the_minimum_within_bounds_is_that_of_scipy(damping, most):
    upper = np.array([9.0, most, 9.0])
    found = run(Decay(), [1.0, 0.5, 0.0], damping, upper=upper)
    oracle = least_squares(
        Decay().residual, [1.0, 0.5, 0.0], bounds=(np.full(3, -9.0), upper + 1e-13), xtol=1e-15, ftol=1e-15, gtol=1e-15
    )
    assert found.converged
    assert found.cost == pytest.approx(Decay().cost(found.x), rel=1e-12)
    np.testing.assert_allclose(found.x, oracle.x, atol=1e-5)
    assert (found.x <= upper).all()
    assert (found.x[1] == most) == (most == 1.0)


@pytest.mark.parametrize("damping", [LEVENBERG, MARQUARDT])
@pytest.mark.parametrize("apart", [0.0, 1e-300, 3e-16, 7e-14, 1e-6])
def test_a_value_ends_exactly_on_its_bound_zero(damping, apart):
    """Also if it begins within rounding errors of it, where a step is as small as these."""
    found = run(Decay(), [1.0, 0.5, -apart], damping, upper=np.array([9.0, 9.0, 0.0]))
    assert found.converged
    assert found.x[2] == 0.0


@pytest.mark.parametrize("damping", [LEVENBERG, MARQUARDT])
def test_an_active_constraint_holds_the_minimum(damping):
    found = run(Decay(), [1.0, 0.5, 0.0], damping, constraints=Curved())
    _, gradient, _ = Decay().derivatives(found.x)
    slope = Curved().slopes(found.x)[0]
    assert found.converged
    assert Curved().values(found.x)[0] == pytest.approx(1.5, abs=2e-6)
    multiplier = -gradient @ slope / (slope @ slope)
    assert multiplier > 0.0
    np.testing.assert_allclose(gradient + multiplier * slope, 0.0, atol=1e-4)


def test_damping_by_curvature_does_not_depend_on_units():
    size = np.array([1e-3, 50.0, 7.0])
    one, other = Decay(), Decay(size)
    run(one, [1.0, 0.5, 0.0], MARQUARDT)
    minimize(other, np.array([1.0, 0.5, 0.0]) / size, np.full(3, -9.0) / size, np.full(3, 9.0) / size, tight, MARQUARDT,
             steps=60)  # fmt: skip
    common = min(len(one.evaluated), len(other.evaluated))
    assert common > 6
    np.testing.assert_allclose(one.evaluated[:common], other.evaluated[:common], atol=1e-7)


def test_the_predicted_reduction_is_the_gain_of_a_linear_problem():
    """With b known the residual is linear: the first prediction is exact."""

    class Linear(Decay):
        def derivatives(self, x):
            cost, gradient, matrix = super().derivatives(x)
            return cost, gradient * [1.0, 0.0, 1.0], matrix * np.outer([1, 0, 1], [1, 0, 1]) + np.diag([0.0, 1.0, 0.0])

    start = np.array([1.0, 1.3, 0.0])
    judged, taken = (run(Linear(), start, LEVENBERG, steps=steps) for steps in (0, 1))
    assert not judged.converged
    np.testing.assert_array_equal(judged.x, start)
    assert judged.predicted == pytest.approx(judged.cost - taken.cost, rel=1e-5)


def test_a_failed_minimization_has_a_reason():
    class Broken(Decay):
        def derivatives(self, x):
            cost, gradient, matrix = super().derivatives(x)
            return cost, gradient * np.nan, matrix

    class Uphill(Decay):
        def derivatives(self, x):
            cost, gradient, matrix = super().derivatives(x)
            return cost, -gradient, matrix

    start = [1.0, 0.5, 0.0]
    assert run(Broken(), start, LEVENBERG).reason == "cost, constraints or derivatives are not finite"
    assert run(Uphill(), start, LEVENBERG).reason == "no step is accepted"
    assert run(Decay(), [3.0, 1.0, 0.0], LEVENBERG, constraints=Curved()).reason.startswith("a constraint is violated")
    stopped = run(Decay(), start, LEVENBERG, stop=lambda: True)
    assert (stopped.converged, stopped.steps, stopped.reason) == (False, 0, "")
    np.testing.assert_array_equal(stopped.x, start)


def test_a_point_is_moved_onto_the_constraints():
    """Not farther than necessary in the metric of the cost, and not if no step can satisfy them."""
    bounds, start = (np.full(3, -9.0), HIGH), np.array([3.0, 1.0, 0.0])
    moved = restore(Decay(), start, *bounds, 1e-2, Curved())
    assert Curved().satisfied(Curved().values(moved))
    assert Decay().cost(moved) < 1.1 * run(Decay(), [1.0, 0.5, 0.0], LEVENBERG, constraints=Curved()).cost
    assert restore(Decay(), start, start, start, 1e-2, Curved()) is None


@pytest.mark.parametrize("seed", range(5))
def test_the_best_step_is_the_bounded_least_squares(seed):
    rng = np.random.default_rng(seed)
    jacobian, residual = rng.normal(size=(30, 8)), rng.normal(size=30)
    least, most = -rng.uniform(0.0, 0.1, 8), rng.uniform(0.0, 0.1, 8)
    oracle = lsq_linear(jacobian, -residual, (least - 1e-12, most + 1e-12), tol=1e-14)
    step, reduction = best_step(jacobian.T @ residual, jacobian.T @ jacobian, np.eye(8), least, most)
    np.testing.assert_allclose(step, oracle.x, atol=1e-8)
    assert reduction == pytest.approx(0.5 * residual @ residual - oracle.cost)


def test_the_best_step_satisfies_constraints_and_meets_kuhn_and_tucker():
    rng = np.random.default_rng(7)
    root, gradient, rows = rng.normal(size=(12, 6)), rng.normal(size=6), rng.normal(size=(40, 6))
    matrix, most = root.T @ root, np.abs(rng.normal(size=40)) * 0.1
    step, reduction = best_step(gradient, matrix, rows, np.full(40, -inf), most)
    slack = most - rows @ step
    assert slack.min() > -1e-9
    active = slack < 1e-9
    assert 0 < active.sum() <= 6
    multipliers = np.linalg.lstsq(rows[active].T, -(gradient + matrix @ step), rcond=None)
    assert multipliers[0].min() > 0.0
    np.testing.assert_allclose(rows[active].T @ multipliers[0], -(gradient + matrix @ step), atol=1e-9)
    assert reduction > 0.0
