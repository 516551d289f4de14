"""FMUs in CasADi's importer: values, Jacobians and its integrator, for every kind of inputs and both versions.

CasADi sets states and parameters of Model Exchange like other values, and refuses unknowns without dependencies.
"""

from __future__ import annotations

from itertools import product

import casadi
import numpy as np
import pytest
from fmpy import simulate_fmu

from tirefmu.fmu.description.interface import INPUTS

from .conftest import distance
from .solver import Solver

#: Added to the start values: an inclined wheel with slip, where the formulas are smooth.
MOVED = {
    "alpha": 0.04,
    "kappa": 0.03,
    "gamma": 0.03,
    "R_32": 0.03,
    "R_23": -0.03,
    "V_y": 0.4,
    "v_y": -0.4,
    "T_drive": 60.0,
    "T_brake": 5.0,
}


@pytest.fixture(params=product(INPUTS, (2, 3)), ids=lambda key: f"{key[0]}-fmi{key[1]}")
def imported(request, fmus):
    """Return the path of an FMU, CasADi's model of it, its function, and a point beside the start values."""
    inputs, fmi = request.param
    path = fmus["first", fmi] if inputs == "slip" else fmus["first", fmi, inputs]
    model = casadi.DaeBuilder("tire", str(path))
    states, given = (np.array([float(model.start(name)[0]) for name in names]) for names in (model.x(), model.u()))
    given += np.array([MOVED.get(name, 0.0) for name in model.u()])
    return path, model, model.create("f", ["x", "u"], ["ode", "y"]), states, given


def test_values_and_jacobians_are_those_of_the_fmu(imported, tmp_path):
    path, model, function, states, given = imported
    host = Solver(path, tmp_path).start()
    host.update()
    assert host.call("enterContinuousTimeMode") == 0
    for name, value in [*zip(model.u(), given, strict=True), *zip(model.x(), states, strict=True)]:
        assert host.set(name, value) == 0
    outputs = function(states, given)[1]
    assert distance(outputs.full().ravel(), host.get(*model.y())) < 1e-12

    x, u = casadi.MX.sym("x", len(states)), casadi.MX.sym("u", len(given))
    jacobian = casadi.Function("J", [x, u], [casadi.jacobian(function(x, u)[1], u)])
    slopes = jacobian(states, given).full()
    for i, name in enumerate(model.u()):
        step = 1e-5 * max(1.0, abs(given[i]))
        sides = []
        for value in (given[i] + step, given[i] - step, given[i]):
            assert host.set(name, value) == 0
            sides.append(host.get(*model.y()))
        differences = (sides[0] - sides[1]) / (2.0 * step)
        np.testing.assert_allclose(
            slopes[:, i], differences, atol=1e-5 * (1.0 + np.max(np.abs(differences))), rtol=1e-5
        )


def test_its_integrator_agrees_with_fmpy(imported):
    path, model, function, states, given = imported
    if not len(states):
        pytest.skip("no states")
    x, u = casadi.MX.sym("x", len(states)), casadi.MX.sym("u", len(given))
    tolerances = {"reltol": 1e-9, "abstol": 1e-9}
    integrator = casadi.integrator("F", "cvodes", {"x": x, "p": u, "ode": function(x, u)[0]}, 0.0, [0.1], tolerances)
    # The slips start at 0 in CasADi, which does not initialize the FMU: fmpy's run starts there, too.
    row = np.array([(0.0, *given)], dtype=[("time", float), *((name, float) for name in model.u())])
    held = np.concatenate([row, row])
    held["time"][1] = 0.1
    done = simulate_fmu(
        str(path), fmi_type="ModelExchange", stop_time=0.1, relative_tolerance=1e-9, input=held, output=list(model.x())
    )
    reached = np.array([done[name][-1] for name in model.x()])
    begun = np.array([done[name][0] for name in model.x()])
    assert distance(integrator(x0=begun, p=given)["xf"].full().ravel(), reached) < 1e-6


def test_a_parameter_is_an_input_at_its_own_value(imported):
    _, model, function, states, given = imported
    tuned = model.create("g", ["x", "u", "p"], ["y"])
    parameters = np.array([float(model.start(name)[0]) for name in model.p()])
    np.testing.assert_array_equal(tuned(states, given, parameters).full(), function(states, given)[1].full())
