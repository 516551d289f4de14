"""Derivatives of an FMU: the generated Jacobians where slips are inputs, differences of its outputs elsewhere."""

from __future__ import annotations

import ctypes

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from tirefmu.tires.code import code_for

from ..relatives import slow_but
from .conftest import DISCARD, ERROR, OK, TIRES
from .test_instance import FULL_POINT

#: Sweeps, the straight line, off the ground, in reverse, at standstill, with turn slip.
POINTS = (
    {"kappa": 0.05, "alpha": -0.08, "gamma": 0.03, "Fz": 4100.0, "p": 2.1e5, "V": 21.0},
    {"kappa": 0.0, "alpha": 0.0, "gamma": 0.0, "Fz": 3000.0},
    {"kappa": -0.3, "alpha": 0.2, "gamma": -0.05, "Fz": -10.0},
    {"kappa": 0.1, "alpha": 0.05, "gamma": 0.01, "Fz": 2500.0, "V": -4.0},
    {"kappa": 0.1, "alpha": 0.05, "gamma": 0.01, "Fz": 2500.0, "V": 0.0},
    {"kappa": -0.02, "alpha": 0.03, "gamma": 0.02, "Fz": 5000.0, "phit": 0.05},
)


def adjoint(host, unknowns, knowns, seed):
    a, b = host.references(unknowns), host.references(knowns)
    seeds, slopes = (ctypes.c_double * len(seed))(*seed), (ctypes.c_double * len(knowns))()
    status = host.call("GetAdjointDerivative", a, len(a), b, len(b), seeds, len(seeds), slopes, len(slopes))
    assert status == OK
    return np.array(slopes)


def matrix(host, unknowns, knowns):
    columns = [host.derivative(unknowns, [name], [1.0]) for name in knowns]
    assert all(status == OK for status, _ in columns)
    return np.array([slopes for _, slopes in columns]).T


@pytest.mark.parametrize(("name", "fmi"), [*((name, 3) for name in TIRES), ("first", 2), ("mf61", 2)])
def test_they_are_the_generated_jacobians(hosts, tires, name, fmi):
    host, tire = hosts(name, fmi), tires[name].in_signs("iso")
    host.initialize()  # until its end slips do not lag
    printed = code_for(tire.symbolic_model, "numpy")
    columns = {c: j for j, c in enumerate(tire.symbolic_model.coefficients) if c in host.variables}
    coefficients, positions = list(columns), list(columns.values())
    shown = [tire.inputs.index(quantity) for quantity in host.inputs]
    for point in POINTS:
        assert host.set(**{key: value for key, value in point.items() if key in host.inputs}) == OK
        inputs = np.array([[host.get(q)[0] if q in host.inputs else 0.0] for q in tire.inputs])
        by_inputs = printed.jacobian_inputs(inputs, tire.parameters())[0][:, shown]
        by_coefficients = printed.jacobian_parameters(inputs, tire.parameters())[0][:, positions]
        np.testing.assert_allclose(matrix(host, host.outputs, host.inputs), by_inputs, rtol=1e-9, atol=1e-8)
        for i, output in enumerate(host.outputs):
            if fmi == 3:
                both = np.concatenate([by_inputs[i], by_coefficients[i]])
                backward = adjoint(host, [output], [*host.inputs, *coefficients], [1.0])
                np.testing.assert_allclose(backward, both, rtol=1e-9, atol=1e-8)
            seed = np.linspace(-1.0, 2.0, len(coefficients))
            by_seed = host.derivative([output], coefficients, seed)[1]
            assert by_seed[0] == pytest.approx(by_coefficients[i] @ seed, rel=1e-9, abs=1e-7)


#: Steps of the differences, small compared with the curvature.
STEPS = {"omega": 1e-3, "V_x": 1e-4, "V_y": 1e-4, "Fz": 1.0, "p": 10.0, "V": 1e-3}
#: Where a slope jumps with the sign of a quantity that is exactly 0, or an inner limit of the book is active.
EDGES = {"gamma": 0.02}


#: Motions before and after a step, by the kind of inputs. With hub inputs the wheel is inclined, steered and bounces.
TURNED = Rotation.from_euler("ZXY", [0.3, 0.05, 0.4]).as_matrix()
HUB = {f"R_{i + 1}{j + 1}": TURNED[i, j] for i in range(3) for j in range(3)}
HUB |= {"v_x": 12.0, "v_y": 3.0, "v_z": 0.1, "w_x": 0.1, "w_y": 0.05, "w_z": 0.2, "omega": 32.0, "road_z": 0.02}
HUB |= {"road_nx": 0.02, "road_ny": 0.03, "road_vx": 0.3, "road_vy": -0.1, "road_vz": 0.05, "road_mu": 0.9}
WHEEL = {"V_x": 12.0, "V_y": -0.4, "omega": 41.0, "psi_dot": 0.2}
MOVED = {
    "slip": (POINTS[0], {name: 0.9 * value for name, value in POINTS[0].items()}),
    "wheel": (WHEEL, {name: 0.9 * value for name, value in WHEEL.items()}),
    "hub": (HUB, {"v_x": 11.0, "omega": 28.0}),
}


@pytest.mark.parametrize(
    ("name", "inputs"),
    slow_but(
        [("first", "slip"), ("rolling", "hub")],
        [(name, inputs) for name in ("first", "rolling") for inputs in ("slip", "wheel", "hub")]
        + [("mf61", "slip"), ("mf62", "hub")],  # with wheel inputs their slips lag as those of the others
    ),
)
def test_they_are_differences_of_the_outputs(hosts, name, inputs):
    """Of all outputs, in SAE axes where they exist."""
    host = hosts(name, 3, inputs, "iso" if inputs == "hub" else "sae", True).start()
    before, after = MOVED[inputs]
    assert host.set(**{k: v for k, v in (before | EDGES).items() if k in host.inputs}) == OK
    host.step(0.0, 0.02)
    assert host.set(**{k: v for k, v in after.items() if k in host.inputs}) == OK
    rates = [variable for variable in host.variables if variable.startswith("der(")]
    unknowns = [*host.outputs, *host.extras, *rates, *(["alpha_lagged"] if rates else [])]
    knowns = [*host.inputs, "PDY1", "PKX1", "UNLOADED_RADIUS"]
    exact = matrix(host, unknowns, knowns)
    for j, variable in enumerate(knowns):
        step = STEPS.get(variable, 1e-5)
        differences = host.differences(unknowns, variable, step)
        noise = 1e-9 * (1.0 + np.abs(host.get(*unknowns))) / step
        assert np.all(np.abs(exact[:, j] - differences) < 1e-5 * np.abs(differences) + noise), variable
    by_rows = np.array([adjoint(host, [unknown], knowns, [1.0]) for unknown in unknowns])
    np.testing.assert_allclose(by_rows, exact, rtol=1e-9, atol=1e-9)
    seed = np.linspace(-1.0, 2.0, len(unknowns))
    together = adjoint(host, unknowns, knowns, seed)
    assert np.all(np.abs(together - seed @ exact) <= 1e-9 * (1.0 + np.abs(exact).sum(axis=0)))
    if rates:
        np.testing.assert_allclose(
            matrix(host, rates[:1], ["kappa_lagged"]), -adjoint(host, rates[:1], ["kappa_lagged"], [-1.0])[None]
        )


def test_options_have_no_derivative(hosts, fmi):
    running = hosts("mf61", fmi).start()
    assert running.set(**FULL_POINT) == OK
    status, slopes = running.derivative(running.outputs, ["CONVENTION", "SLIP_ANGLE", "LIMITS"], [1.0, 1.0, 1.0])
    assert (status, np.any(slopes)) == (OK, False)


# --------------------------------- Derivatives of inputs (FMI 2, canInterpolateInputs): inputs that change over a step


@pytest.fixture
def rolling(hosts):
    return hosts("rolling", 2)


def set_slopes(host, order=1, **slopes):
    n = len(slopes)
    orders, values = (ctypes.c_int * n)(*[order] * n), (ctypes.c_double * n)(*slopes.values())
    return host.call("SetRealInputDerivatives", host.references(slopes), n, orders, values)


def course(host, steps, slope=None):
    """Return Fy at the end of 0.2 s in which alpha grows to 0.1."""
    assert host.call("Reset") == OK
    assert host.set(V=12.0, Fz=4000.0) == OK
    host.start()
    size = 0.2 / steps
    for k in range(steps):
        assert host.set(alpha=0.5 * size * (k + 0.5 if slope is None else k)) == OK
        assert slope is None or set_slopes(host, alpha=slope) == OK
        assert host.step(k * size, size) == OK
    assert not slope or host.get("alpha")[0] == pytest.approx(0.1, rel=1e-12)
    assert host.set(alpha=0.1) == OK
    return host.get("Fy")[0]


def test_a_coarse_step_is_that_of_fine_ones(rolling):
    exact = course(rolling, 4000)
    assert course(rolling, 5, 0.5) == pytest.approx(exact, rel=1e-4)
    assert course(rolling, 5, 0.0) != pytest.approx(exact, rel=1e-3)  # held at the start of each step
    rolling.call("Reset")
    course(rolling, 1, 0.5)


def test_they_are_for_one_step(rolling):
    rolling.start()
    assert set_slopes(rolling, alpha=1.0) == OK
    assert rolling.step(0.0, 0.01) == OK
    assert rolling.get("alpha")[0] == pytest.approx(0.01)
    assert rolling.step(0.01, 0.01) == OK
    assert rolling.get("alpha")[0] == pytest.approx(0.01)


def test_a_refused_call_changes_nothing(rolling):
    rolling.start()
    before = rolling.everything()
    assert set_slopes(rolling, order=2, alpha=1.0) == ERROR
    assert set_slopes(rolling, Fy=1.0) == ERROR
    assert set_slopes(rolling, alpha=np.inf) == DISCARD
    assert set_slopes(rolling, alpha=1e308) == OK
    assert rolling.step(0.0, 100.0) == DISCARD
    assert set_slopes(rolling, alpha=0.0) == OK
    np.testing.assert_array_equal(rolling.everything(), before)
