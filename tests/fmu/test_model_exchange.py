"""Model Exchange: the same tire with an external solver, against Co-Simulation and its exact states."""

from __future__ import annotations

import numpy as np
import pytest
from fmpy import simulate_fmu

from .conftest import ERROR, OK
from .solver import Solver


@pytest.fixture
def solver(fmus, lagging, fmi, tmp_path):
    solver = Solver(fmus[lagging, fmi], tmp_path)
    yield solver.start()
    solver.fmu.freeInstance()


def test_modes_follow_the_standard(solver):
    assert solver.call("enterEventMode") == ERROR  # the state already has this value
    assert solver.set_states(0.0, 0.0) == ERROR
    solver.update()
    assert solver.call("enterContinuousTimeMode") == OK
    assert solver.call("enterContinuousTimeMode") == ERROR
    assert solver.set_states(0.01, 0.02) == OK
    assert solver.set("PDY1", 1.0) == ERROR
    assert solver.set("kappa", 0.05) == OK
    assert solver.call("enterEventMode") == OK
    assert solver.set("PDY1", solver.get("PDY1")[0]) == OK
    assert solver.call("terminate") == OK
    assert solver.call("enterEventMode") == ERROR


def test_a_slip_that_acts_at_once_is_where_it_acts_after_an_event(fmus, fmi, tmp_path):
    solver = Solver(fmus["rolling", fmi], tmp_path).start()
    assert solver.set("SIGX", 0.0) == OK
    assert solver.set("kappa", 0.07) == OK
    solver.update()
    assert solver.get("kappa_lagged")[0] == 0.07
    assert solver.get("tan_alpha_lagged")[0] == 0.0
    solver.fmu.freeInstance()


def test_a_state_of_one_kind_is_none_of_the_other(hosts, fmus, fmi, tmp_path):
    host, solver = hosts("rolling", fmi).start(), Solver(fmus["rolling", fmi], tmp_path).start()
    state = host.save()
    assert solver.call("setFMUState" if fmi == 3 else "setFMUstate", state) == ERROR
    host.free(state)
    solver.fmu.freeInstance()


def test_a_tire_without_states(fmus, fmi, tires):
    result = simulate_fmu(
        str(fmus["first", fmi]),
        fmi_type="ModelExchange",
        stop_time=0.3,
        output_interval=0.01,
        start_values={"kappa": 0.03, "alpha": 0.05, "Fz": 700.0},
        output=["Fy"],
    )
    expected = float(tires["first"].forces(kappa=0.03, alpha=0.05, Fz=700.0)["Fy"])
    np.testing.assert_allclose(result["Fy"], expected, rtol=1e-12)
