"""Model Exchange: the same tire with an external solver, against Co-Simulation and its exact states."""

from __future__ import annotations

import numpy as np
import pandas as pd
import pytest
from fmpy import simulate_fmu

from .solver import Solver

OK, DISCARD, ERROR = 0, 2, 3
STATES = ("kappa_lagged", "tan_alpha_lagged")


@pytest.fixture
def driving():
    """Return inputs that jump: every jump is a second row at the same time, as required by fmpy's events."""
    time = np.repeat(np.arange(0.0, 0.31, 0.05), 2)[1:-1]
    levels = np.repeat(np.random.default_rng(4).uniform(-1.0, 1.0, (6, 3)), 2, axis=0)
    signal = np.zeros(len(time), dtype=[(name, float) for name in ("time", "kappa", "alpha", "Fz", "V")])
    signal["time"], signal["V"] = time, 20.0
    signal["kappa"], signal["alpha"], signal["Fz"] = 0.1 * levels[:, 0], 0.15 * levels[:, 1], 4000 + 1500 * levels[:, 2]
    return signal


def test_solver_and_exact_states_agree(fmus, tires, lagging, fmi, driving):
    outputs = [*tires[lagging].outputs, *STATES]
    found = {
        kind: simulate_fmu(
            str(fmus[lagging, fmi]),
            fmi_type=kind,
            stop_time=0.3,
            output_interval=0.01,
            input=driving,
            output=outputs,
            **({"relative_tolerance": 1e-9, "solver": "CVode"} if kind == "ModelExchange" else {}),
        )
        for kind in ("ModelExchange", "CoSimulation")
    }
    cs, me = found["CoSimulation"], found["ModelExchange"]
    # Between jumps, where both report results of the same inputs.
    inside = np.setdiff1d(np.round(cs["time"], 9), np.round(driving["time"], 9))
    rows = {kind: np.searchsorted(np.round(run["time"], 9), inside) for kind, run in found.items()}
    assert len(inside) > 20
    for name in outputs:
        a, b = me[name][rows["ModelExchange"]], cs[name][rows["CoSimulation"]]
        assert np.max(np.abs(a - b)) <= 1e-5 * (1.0 + np.max(np.abs(b)))
    assert np.ptp(cs["Fy"]) > 1000.0


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


def test_states_are_what_the_solver_sets(solver):
    solver.call("enterContinuousTimeMode")
    assert solver.set_states(0.03, -0.04) == OK
    assert solver.states().tolist() == [0.03, -0.04]
    assert solver.get(*STATES).tolist() == [0.03, -0.04]
    forces = solver.get("Fx", "Fy")
    for bad in (np.nan, np.inf):
        assert solver.set_states(0.0, bad) == DISCARD
    assert solver.set_states(0.0) == ERROR
    assert np.array_equal(solver.get("Fx", "Fy"), forces)


def test_rates_are_those_of_the_equation(solver, tires, lagging):
    solver.call("enterContinuousTimeMode")
    point = {"kappa": 0.05, "alpha": 0.1, "Fz": 4500.0, "V": -13.0}
    for name, value in point.items():
        assert solver.set(name, value) == OK
    assert solver.set_states(0.02, -0.01) == OK
    sigma = tires[lagging].evaluate(pd.DataFrame([point])).iloc[0]
    expected = [13.0 / sigma["sigma_kappa"] * (0.05 - 0.02), 13.0 / sigma["sigma_alpha"] * (np.tan(0.1) + 0.01)]
    np.testing.assert_allclose(solver.get(*(f"der({name})" for name in STATES)), expected, rtol=1e-12)


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
    state = host.fmu.getFMUState() if fmi == 3 else host.fmu.getFMUstate()
    assert solver.call("setFMUState" if fmi == 3 else "setFMUstate", state) == ERROR
    (host.fmu.freeFMUState if fmi == 3 else host.fmu.freeFMUstate)(state)
    solver.fmu.freeInstance()


def test_an_fmu_with_fixed_steps_has_no_model_exchange(hosts):
    host = hosts("rolling", 3).start()
    assert host.call("EnterContinuousTimeMode") == ERROR
    assert host.log[-1] == "continuous-time mode is allowed in Model Exchange only"
    assert host.call("EnterEventMode") == ERROR
    assert host.call("SetTime", 1.0) == ERROR


def test_a_tire_without_states(fmus, fmi, tires, driving):
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
