"""FMUs with states of every kind: Co-Simulation against the evaluation of a table, saved states, Model Exchange."""

from __future__ import annotations

import numpy as np
import pandas as pd
import pytest
from fmpy import simulate_fmu

from tirefmu.fmu import check

from ..relatives import slow_but
from .conftest import ERROR, LAGGING, OK, STATEFUL, distance
from .solver import Solver

CASES = [*((name, fmi) for name in LAGGING for fmi in (2, 3)),
         *((name, fmi) for name, (_, _, versions) in STATEFUL.items() for fmi in versions)]  # fmt: skip
#: A tire with each kind of state: of slip, of effects.
FAST = [("rolling", 3), ("mf62", 2), ("warm", 3)]
every_case = pytest.mark.parametrize(("name", "fmi"), slow_but(FAST, CASES))


def recording(tire, n, seed):
    """Return rows of all kinds of motion, some at equal times; of a tire with states of effects within its range."""
    rng, wild = np.random.default_rng(seed), not tire.states
    speed = np.where(rng.random(n) < 0.2, rng.choice([0.0, -5.0, -0.01, 60.0], n), rng.uniform(1.0, 30.0, n))
    load = np.where(rng.random(n) < 0.1, rng.choice([0.0, -300.0, 1e-9], n), rng.uniform(50.0, 9000.0, n))
    table = {
        "t": np.cumsum(np.where(rng.random(n) < 0.1, 0.0, rng.uniform(1e-4, 0.05 if wild else 0.5, n))),
        "kappa": rng.uniform(-1.0, 1.5, n) if wild else rng.uniform(-0.1, 0.1, n),
        "alpha": rng.uniform(-1.5, 1.5, n) if wild else rng.uniform(-0.2, 0.2, n), "gamma": rng.uniform(-0.2, 0.2, n),
        "Fz": load if wild else tire.values["FNOMIN"] * rng.uniform(0.4, 1.5, n), "p": rng.uniform(1.5e5, 3e5, n),
        "V": speed if wild else rng.uniform(5.0, 25.0, n), "phit": rng.choice([0.0, 0.05, -0.2], n),
        "T": rng.uniform(20.0, 110.0, n), "T_ambient": rng.uniform(280.0, 300.0, n), "T_road": 310.0,
    }  # fmt: skip
    return pd.DataFrame(table)[[name for name in table if name == "t" or name in tire.inputs]]


@every_case
def test_it_is_the_evaluation_with_inputs_held(fmus, tires, name, fmi):
    """Over two segments, each of which begins in steady state; rows by themselves have other forces."""
    tire = tires[name]
    run = recording(tire, 40 if tire.states else 200, 11)
    table = pd.concat([run, run.assign(t=run["t"] + 500.0, kappa=-0.6 * run["kappa"])], ignore_index=True)
    alone = tire.evaluate(table.drop(columns="t"))[list(tire.outputs)]
    result = check(fmus[name, fmi], table.assign(Fy=alone["Fy"]))
    assert result.ok
    assert (result.segments, result.evaluation_difference < 1e-9) == (2, True)
    if name in LAGGING:
        assert distance(result.simulated.iloc[[0, len(run)]], alone.iloc[[0, len(run)]]).max() < 1e-9
    assert result.channels[0].rmse > (20.0 if name == "warm" else 100.0)  # the states have an influence


@every_case
def test_a_saved_state_contains_all_states(hosts, tires, name, fmi):
    """Every value is the same after a step and the return to the saved state."""
    host, tire = hosts(name, fmi), tires[name]
    host.start(kappa=0.03, alpha=-0.09, Fz=1.05 * tire.values["FNOMIN"], V=14.0)
    assert host.step(0.0, 0.2) == host.set(alpha=0.05) == OK
    saved, before = host.save(), host.everything()
    assert host.step(0.2, 0.3) == OK
    after = host.everything()
    assert np.abs(after - before).max() > 1.0
    assert host.restore(saved) == OK
    np.testing.assert_array_equal(host.everything(), before)
    assert host.step(0.2, 0.3) == OK
    np.testing.assert_array_equal(host.everything(), after)
    host.free(saved)


@pytest.mark.parametrize(
    ("name", "fmi"),
    slow_but([("rolling", 3)], [case for case in CASES if "heated" not in case[0] and case[0] != "warm"]),
)
def test_a_solver_agrees_with_the_exact_updates(fmus, tires, name, fmi):
    """Model Exchange with CVode, an event where a slip turns, against Co-Simulation, with inputs that jump."""
    tire, step, rng = tires[name], 0.01 if name in LAGGING else 0.1, np.random.default_rng(8)
    spans = {"kappa": (-0.1, 0.1), "alpha": (-0.2, 0.2), "Fz": (1500.0, 6000.0), "V": (5.0, 25.0)}
    levels = {key: rng.uniform(*span, 5) for key, span in spans.items()}
    # Every jump is a second row at the same time, as required by fmpy's events.
    time = np.repeat(4.0 * step * np.arange(5), 2)[1:]
    signal = np.zeros(len(time), dtype=[("time", float), *((key, float) for key in levels)])
    signal["time"] = time
    for key, values in levels.items():
        signal[key] = np.repeat(values, 2)[:-1]
    lags = ["kappa_lagged", "tan_alpha_lagged"] if tire.lags else []
    shown = [*tire.outputs, *lags, *tire.states]
    runs = {
        kind: simulate_fmu(
            str(fmus[name, fmi]), fmi_type=kind, stop_time=time[-1], output_interval=step, input=signal, output=shown,
            **({"relative_tolerance": 1e-10, "solver": "CVode"} if kind == "ModelExchange" else {}),
        )
        for kind in ("ModelExchange", "CoSimulation")
    }  # fmt: skip
    times = {kind: np.round(run["time"], 9) for kind, run in runs.items()}
    inside = np.setdiff1d(times["CoSimulation"], np.round(time, 9))  # where both report results of the same inputs
    assert len(inside) >= 10
    for column in shown:
        a, b = (run[column][np.searchsorted(times[kind], inside)] for kind, run in runs.items())
        assert np.max(np.abs(a - b)) <= 1e-6 * (1.0 + np.max(np.abs(b))), column
    assert np.ptp(runs["CoSimulation"]["Fy"]) > 1000.0


# ------------------- Model Exchange: the same tire with an external solver, against Co-Simulation and its exact states


@pytest.fixture
def solver(fmus, lagging, fmi, tmp_path):
    solver = Solver(fmus[lagging, fmi], tmp_path)
    yield solver.start()
    solver.fmu.freeInstance()


def test_modes_follow_the_standard(solver):
    assert solver.call("enterEventMode") == OK  # FMI 2 allows it
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
