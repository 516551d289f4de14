"""States of effects in an FMU: Co-Simulation, Model Exchange, saved states, derivatives."""

from __future__ import annotations

import ctypes

import numpy as np
import pandas as pd
import pytest
from fmpy import simulate_fmu
from fmpy.validation import validate_fmu

from tirefmu.boundary.errors import FmuError
from tirefmu.fmu import check, export
from tirefmu.fmu.simulation.simulate import loaded
from tirefmu.tires import Tire

OK, ERROR = 0, 3
EFFECTS = ("heat_friction", "slip_history", "hysteresis_force", "break_in", "load_lag", "carcass_2nd_order")
VALUES = {
    "FNOMIN": 4000.0, "UNLOADED_RADIUS": 0.3, "SIGX": 0.2, "SIGY": 0.4, "HMU": 0.2, "HTAU": 6.0,
    "SHMUX": 0.05, "SHMUY": 0.05, "SHKX": 0.08, "SHKY": 0.08, "HFPLAY": 0.02,
    "BIMU": 0.1, "BIWORK": 5.0, "LLMU": 0.5, "LLK": 0.5, "LLDIR": 0.5, "CASIG": 0.3, "CAFREQ": 60.0, "CASAT": 4.0,
}  # fmt: skip
POINT = {"kappa": 0.03, "alpha": -0.09, "Fz": 4200.0, "V": 14.0}
#: Slips that lag and slips that act at once.
TIRES = {"lagged": {"relax_lat", "relax_lon"}, "direct": set()}


@pytest.fixture(scope="session")
def remembering():
    return {name: Tire("mf61", VALUES, effects={*EFFECTS, *more}) for name, more in TIRES.items()}


@pytest.fixture(scope="session")
def memory_fmus(compiler, remembering, tmp_path_factory):
    """Return the FMUs of the tires: FMI 3 with lagged slips, FMI 2 without."""
    folder = tmp_path_factory.mktemp("memory")
    return {
        name: export(remembering[name], folder / f"{name}.fmu", fmi=fmi, quantities=True)
        for name, fmi in (("lagged", 3), ("direct", 2))
    }


def recording(n, seed, step=None):
    rng = np.random.default_rng(seed)
    h = np.full(n, step) if step else rng.uniform(1e-3, 0.5, n)
    return pd.DataFrame(
        {
            "t": np.cumsum(h) - h[0], "kappa": rng.uniform(-0.1, 0.1, n), "alpha": rng.uniform(-0.2, 0.2, n),
            "Fz": rng.uniform(1500.0, 6000.0, n), "V": rng.uniform(5.0, 25.0, n),
        }
    )  # fmt: skip


@pytest.mark.parametrize("name", TIRES)
def test_it_is_the_evaluation_with_inputs_held(memory_fmus, remembering, name):
    table, tire = recording(60, 5), remembering[name]
    result = check(memory_fmus[name], table.assign(**tire.evaluate(table, steady=True)[list(tire.outputs)]))
    assert result.ok
    assert result.evaluation_difference < 1e-9
    assert result.channels[1].rmse > 30.0  # memory has an influence


@pytest.mark.parametrize("name", TIRES)
def test_the_description_is_valid_and_has_the_states(memory_fmus, remembering, name):
    assert validate_fmu(str(memory_fmus[name])) == []
    with loaded(memory_fmus[name]) as slave:
        variables = {variable.name: variable for variable in slave.description.modelVariables}
    for state in remembering[name].states:
        assert variables[f"der({state})"].derivative.name == state
    assert {variables[each].initial for each in ("tread_heat", "late_load")} == {"calculated"}
    assert {variables[each].initial for each in ("sliding_work", "slip_growth")} == {"exact"}


@pytest.fixture(params=TIRES)
def host(request, memory_fmus, make_host):
    host = make_host(memory_fmus[request.param])
    host.initialize()
    assert host.set(**POINT) == OK
    return host


def test_start_values_can_be_set(host):
    assert host.set(sliding_work=500.0, slip_growth=0.5) == OK
    assert host.set(tread_heat=5.0) == ERROR  # in equilibrium with the first inputs
    assert host.call("ExitInitializationMode") == OK
    assert host.get("sliding_work", "slip_growth").tolist() == [500.0, 0.5]
    heat, rate = host.get("tread_heat", "der(tread_heat)")
    assert heat > 0.0
    assert abs(rate) < 1e-9 * heat


def test_a_long_step_with_strong_feedback_ends_in_equilibrium(host):
    """An iteration over the whole step finds no values: the step is halved."""
    assert host.set(HMU=2.0, HTAU=1.0, alpha=0.0, Fz=6000.0, V=30.0) == OK
    assert host.call("ExitInitializationMode") == OK
    assert host.set(alpha=-0.2) == OK
    assert host.step(0.0, 60.0) == OK
    heat, rate = host.get("tread_heat", "der(tread_heat)")
    assert heat > 0.25
    assert abs(rate) < 1e-6 * heat


def test_a_saved_state_contains_the_memory(host):
    """Every value is the same after a step and the return to the saved state."""
    assert host.call("ExitInitializationMode") == OK
    assert host.step(0.0, 0.2) == OK
    assert host.set(alpha=0.05) == OK
    saved, letter = ctypes.c_void_p(), "S" if host.version == 3 else "s"
    assert host.call(f"GetFMU{letter}tate", ctypes.byref(saved)) == OK
    before = host.everything()
    assert host.step(0.2, 0.3) == OK
    after = host.everything()
    assert np.abs(after - before).max() > 1.0
    assert host.call(f"SetFMU{letter}tate", saved) == OK
    np.testing.assert_array_equal(host.everything(), before)
    assert host.step(0.2, 0.3) == OK
    np.testing.assert_array_equal(host.everything(), after)


def test_directional_derivatives_are_those_of_differences(host):
    assert host.call("ExitInitializationMode") == OK
    assert host.step(0.0, 0.2) == OK
    assert host.set(alpha=0.06, kappa=-0.02, Fz=3900.0) == OK
    states = [name for name in host.variables if f"der({name})" in host.variables]
    unknowns = [*host.outputs, *(f"der({name})" for name in states), "slip_growth_velocity", "inner_play_event"]
    steps = {"alpha": 1e-6, "Fz": 1e-2, "V": 1e-4, "HTAU": 1e-5, "SHLEN": 1e-7, "BIMU": 1e-6, "CAFREQ": 1e-4}
    for known, step in steps.items():
        status, found = host.derivative(unknowns, [known], [1.0])
        assert status == OK
        middle = host.get(known)[0]
        values = []
        for value in (middle + step, middle - step):
            assert host.set(**{known: value}) == OK
            values.append(host.get(*unknowns))
        assert host.set(**{known: middle}) == OK
        expected = (values[0] - values[1]) / (2.0 * step)
        np.testing.assert_allclose(found, expected, rtol=2e-5, atol=2e-6 * np.abs(expected).max() + 1e-9)


@pytest.mark.parametrize("name", TIRES)
def test_solver_and_exact_updates_agree(memory_fmus, remembering, name):
    """Model Exchange with CVode, an event where the slip turns, against Co-Simulation with held inputs."""
    levels = recording(5, 8, step=0.4)
    time = np.repeat(levels["t"].to_numpy(), 2)[1:]
    signal = np.zeros(len(time), dtype=[("time", float), *((key, float) for key in POINT)])
    signal["time"] = time
    for key in POINT:
        signal[key] = np.repeat(levels[key].to_numpy(), 2)[:-1]
    shown = [*remembering[name].states, "Fy"]
    found = {
        kind: simulate_fmu(
            str(memory_fmus[name]), fmi_type=kind, stop_time=1.6, output_interval=0.1, input=signal, output=shown,
            **({"relative_tolerance": 1e-10, "solver": "CVode"} if kind == "ModelExchange" else {}),
        )
        for kind in ("ModelExchange", "CoSimulation")
    }  # fmt: skip
    cs, me = found["CoSimulation"], found["ModelExchange"]
    inside = np.setdiff1d(np.round(cs["time"], 9), np.round(time, 9))
    rows = {kind: np.searchsorted(np.round(run["time"], 9), inside) for kind, run in found.items()}
    assert len(inside) >= 10
    for each in shown:
        a, b = me[each][rows["ModelExchange"]], cs[each][rows["CoSimulation"]]
        assert np.max(np.abs(a - b)) <= 1e-6 * (1.0 + np.max(np.abs(cs[each]))), each


def test_each_state_along_a_path_has_an_event_indicator(memory_fmus):
    with loaded(memory_fmus["lagged"]) as slave:
        number = ctypes.c_size_t()
        slave.fmu.fmi3GetNumberOfEventIndicators(slave.fmu.component, ctypes.byref(number))
        assert number.value == 3


def test_the_python_variant_has_no_states_of_effects(remembering, tmp_path):
    with pytest.raises(FmuError, match="has no states of effects"):
        export(remembering["direct"], tmp_path / "x.fmu", kind="pythonfmu")


def test_wheel_inputs_have_the_same_memory(remembering, tmp_path, make_host):
    """A wheel in steady motion starts in equilibrium and stays there; after a jump its memory is that of the slips."""
    tire = remembering["lagged"]
    host = make_host(export(tire, tmp_path / "wheel.fmu", inputs="wheel"))
    host.initialize()
    motion = {"V_x": 14.0, "V_y": 14.0 * np.tan(-0.09), "omega": 14.0 / 0.3, "Fz": 4200.0}
    assert host.set(**motion) == OK
    assert host.call("ExitInitializationMode") == OK
    (before,) = host.get("tread_heat")
    assert host.step(0.0, 0.5) == OK
    kappa, alpha, side, work, growth, heat = host.get(
        "kappa", "alpha", "Fy", "sliding_work", "slip_growth", "tread_heat"
    )
    assert growth == 0.0
    assert work > 0.02  # m: 100 J over the nominal load
    # `forces` has the friction of the new tread, which the sliding work has lowered.
    settled = float(tire.forces(kappa=kappa, alpha=alpha, Fz=4200.0, V=14.0).Fy)
    assert side == pytest.approx(settled * (1.0 + 0.1 * np.exp(-work / 5.0)) / 1.1, rel=2e-2)
    assert heat == pytest.approx(before, rel=0.01)
    assert host.set(V_y=0.0) == OK
    assert host.step(0.5, 0.5) == OK
    assert host.get("tread_heat")[0] < 0.96 * heat
    assert host.get("slip_growth")[0] < -0.9
