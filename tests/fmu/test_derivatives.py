"""Derivatives of an FMU: the generated Jacobians where slips are inputs, differences of its outputs elsewhere."""

from __future__ import annotations

import contextlib
import ctypes

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from tirefmu.fmu import export
from tirefmu.fmu.simulation.simulate import loaded
from tirefmu.tires.code import code_for

from .conftest import ERROR, GOLDEN, TIRES, Host
from .test_instance import FULL_POINT, OUTPUTS, POINT

OK = 0
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
    seeds, found = (ctypes.c_double * len(seed))(*seed), (ctypes.c_double * len(knowns))()
    status = host.call("GetAdjointDerivative", a, len(a), b, len(b), seeds, len(seeds), found, len(found))
    assert status == OK
    return np.array(found)


def matrix(host, unknowns, knowns):
    columns = [host.derivative(unknowns, [known], [1.0]) for known in knowns]
    assert all(status == OK for status, _ in columns)
    return np.array([found for _, found in columns]).T


@pytest.mark.parametrize("name", TIRES)
def test_they_are_the_generated_jacobians(hosts, tires, name):
    host, tire = hosts(name, 3), tires[name].in_signs("iso")
    host.initialize()  # until its end slips do not lag
    printed, coefficients = (
        code_for(tire.symbolic_model, "numpy"),
        [c for c in tire.symbolic_model.coefficients if c in host.variables],
    )
    positions = [list(tire.symbolic_model.coefficients).index(c) for c in coefficients]
    shown = [position for position, known in enumerate(tire.inputs) if known in host.inputs]
    known_inputs = [tire.inputs[position] for position in shown]
    for point in POINTS:
        assert host.set(**{key: value for key, value in point.items() if key in host.inputs}) == OK
        inputs = np.array([[host.get(q)[0] if q in host.inputs else 0.0] for q in tire.inputs])
        by_inputs = printed.jacobian_inputs(inputs, tire.parameters())[0][:, shown]
        by_coefficients = printed.jacobian_parameters(inputs, tire.parameters())[0][:, positions]
        np.testing.assert_allclose(matrix(host, host.outputs, known_inputs), by_inputs, rtol=1e-9, atol=1e-8)
        for i, output in enumerate(host.outputs):
            both = np.concatenate([by_inputs[i], by_coefficients[i]])
            found = adjoint(host, [output], [*known_inputs, *coefficients], [1.0])
            np.testing.assert_allclose(found, both, rtol=1e-9, atol=1e-8)
            host_by_seed = host.derivative([output], coefficients, np.ones(len(coefficients)))[1]
            assert host_by_seed[0] == pytest.approx(by_coefficients[i].sum(), rel=1e-9, abs=1e-7)


@pytest.fixture(scope="module")
def turned(tires, compiler, tmp_path_factory):
    """Return FMUs with all outputs, in SAE axes where they exist."""
    folder = tmp_path_factory.mktemp("turned")

    class Fmus(dict):
        def __missing__(self, key):
            name, inputs = key
            path, axes = folder / f"{name}_{inputs}.fmu", "iso" if inputs == "hub" else "sae"
            self[key] = export(tires[name], path, inputs=inputs, axes=axes, quantities=True)
            return self[key]

    return Fmus()


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
    [(name, inputs) for name in ("first", "rolling", "mf62") for inputs in ("slip", "wheel", "hub")]
    + [("mf61", "slip")],  # with wheel inputs its slips lag as those of the others
)
def test_they_are_differences_of_the_outputs(turned, name, inputs):
    with contextlib.ExitStack() as stack:
        host = Host(stack.enter_context(loaded(turned[name, inputs]))).start()
        before, after = MOVED[inputs]
        assert host.set(**{k: v for k, v in (before | EDGES).items() if k in host.inputs}) == OK
        host.step(0.0, 0.02)
        assert host.set(**{k: v for k, v in after.items() if k in host.inputs}) == OK
        rates = [known for known in host.variables if known.startswith("der(")]
        unknowns = [*host.outputs, *host.extras, *rates, *(["alpha_lagged"] if rates else [])]
        knowns = [*host.inputs, "PDY1", "PKX1", "UNLOADED_RADIUS"]
        exact = matrix(host, unknowns, knowns)
        for j, known in enumerate(knowns):
            middle, step = host.get(known)[0], STEPS.get(known, 1e-5)
            sides = []
            for side in (step, -step):
                assert host.set(**{known: middle + side}) == OK
                sides.append(host.get(*unknowns))
            host.set(**{known: middle})
            differences = (sides[0] - sides[1]) / (2 * step)
            noise = 1e-9 * (1.0 + np.abs(host.get(*unknowns))) / step
            assert np.all(np.abs(exact[:, j] - differences) < 1e-5 * np.abs(differences) + noise), known
        by_rows = np.array([adjoint(host, [unknown], knowns, [1.0]) for unknown in unknowns])
        np.testing.assert_allclose(by_rows, exact, rtol=1e-9, atol=1e-9)
        if rates:
            np.testing.assert_allclose(
                matrix(host, rates[:1], ["kappa_lagged"]), -adjoint(host, rates[:1], ["kappa_lagged"], [-1.0])[None]
            )


def test_every_tire_of_the_golden_coefficients_is_here():
    assert set(GOLDEN) <= set(TIRES)


def finite_difference(host, output, name, step):
    middle = host.get(name)[0]
    values = []
    for side in (1.0, -1.0):
        assert host.set(**{name: middle + side * step}) == OK
        values.append(host.get(output)[0])
    host.set(**{name: middle})
    return (values[0] - values[1]) / (2.0 * step)


@pytest.mark.parametrize("name", ["first", "mf61"])
def test_directional_derivatives_are_finite_differences(hosts, fmi, name):
    running = hosts(name, fmi).start()
    running.set(**POINT if name == "first" else FULL_POINT | {"phit": 0.05})
    steps = {"kappa": 1e-6, "alpha": 1e-6, "gamma": 1e-6, "Fz": 1e-2, "PDY1": 1e-6, "PDX1": 1e-6, "QDZ1": 1e-6}
    if name == "mf61":
        steps |= {"p": 1.0, "V": 1e-4, "phit": 1e-6, "QSX3": 1e-6, "QDRP1": 1e-6}
    for known, step in steps.items():
        for output in running.outputs:
            status, (found,) = running.derivative([output], [known], [1.0])
            assert status == OK
            assert found == pytest.approx(finite_difference(running, output, known, step), rel=1e-5, abs=1e-4)


def test_options_have_no_derivative(hosts, fmi):
    running = hosts("mf61", fmi).start()
    assert running.set(**FULL_POINT) == OK
    status, found = running.derivative(running.outputs, ["CONVENTION", "SLIP_ANGLE", "LIMITS"], [1.0, 1.0, 1.0])
    assert status == OK
    assert not np.any(found)


def test_directional_derivatives_are_linear_in_the_seed(running):
    running.set(**POINT)
    knowns, seed = ["Fz", "PDY1", "alpha", "RBX1"], [3.0, -0.5, 0.25, 2.0]
    status, together = running.derivative(OUTPUTS, knowns, seed)
    assert status == OK
    alone = [running.derivative(OUTPUTS, [k], [s])[1] for k, s in zip(knowns, seed, strict=True)]
    np.testing.assert_allclose(together, np.sum(alone, axis=0), rtol=1e-12)
    assert np.all(together != 0.0)


@pytest.mark.parametrize(("unknowns", "knowns"), [(["kappa"], ["kappa"]), (["Fx"], ["Fy"]), (["Fx"], [4_000_000_000])])
def test_derivatives_are_of_outputs_with_respect_to_settable_variables(running, unknowns, knowns):
    assert running.derivative(unknowns, knowns, [1.0])[0] == ERROR
    assert running.log
