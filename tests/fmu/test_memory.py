"""States of effects in an FMU: start values, equilibrium, derivatives, other inputs."""

from __future__ import annotations

import ctypes

import numpy as np
import pytest

from tirefmu.boundary.errors import FmuError
from tirefmu.fmu import export

from .conftest import ERROR, OK

POINT = {"kappa": 0.03, "alpha": -0.09, "Fz": 4200.0, "V": 14.0}


@pytest.fixture(params=[("lagged", 3), ("direct", 2)], ids=lambda case: case[0])
def host(request, hosts):
    """Return a host of a tire whose slips lag or act at once, before its initialization ends."""
    host = hosts(*request.param)
    host.initialize()
    assert host.set(**POINT) == OK
    return host


def test_the_description_has_the_states(host, tires):
    for state in tires["direct"].states:
        assert host.variables[f"der({state})"].derivative.name == state
    assert {host.variables[state].initial for state in ("tread_heat", "late_load")} == {"calculated"}
    assert {host.variables[state].initial for state in ("sliding_work", "slip_growth")} == {"exact"}


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


def test_directional_derivatives_are_those_of_differences(host):
    assert host.call("ExitInitializationMode") == OK
    assert host.step(0.0, 0.2) == OK
    assert host.set(alpha=0.06, kappa=-0.02, Fz=3900.0) == OK
    states = [name for name in host.variables if f"der({name})" in host.variables]
    unknowns = [*host.outputs, *(f"der({name})" for name in states), "slip_growth_velocity", "inner_play_event"]
    steps = {"alpha": 1e-6, "Fz": 1e-2, "V": 1e-4, "HTAU": 1e-5, "SHLEN": 1e-7, "BIMU": 1e-6, "CAFREQ": 1e-4}
    for name, step in steps.items():
        status, exact = host.derivative(unknowns, [name], [1.0])
        expected = host.differences(unknowns, name, step)
        assert status == OK
        np.testing.assert_allclose(exact, expected, rtol=2e-5, atol=2e-6 * np.abs(expected).max() + 1e-9)


def test_each_state_along_a_path_has_an_event_indicator(hosts):
    number = ctypes.c_size_t()
    assert hosts("lagged", 3).call("GetNumberOfEventIndicators", ctypes.byref(number)) == OK
    assert number.value == 3


def test_the_python_variant_has_no_states_of_effects(tires, tmp_path):
    with pytest.raises(FmuError, match="has no states of effects"):
        export(tires["direct"], tmp_path / "x.fmu", kind="pythonfmu")


def test_wheel_inputs_have_the_same_memory(tires, wheels):
    """A wheel in steady motion starts in equilibrium and stays there; after a jump its memory is that of the slips."""
    host = wheels("lagged").start(V_x=14.0, V_y=14.0 * np.tan(-0.09), omega=14.0 / 0.3, Fz=4200.0)
    (before,) = host.get("tread_heat")
    assert host.step(0.0, 0.5) == OK
    kappa, alpha, side, work, growth, heat = host.get(
        "kappa", "alpha", "Fy", "sliding_work", "slip_growth", "tread_heat"
    )
    assert growth == 0.0
    assert work > 0.02  # m: 100 J over the nominal load
    # `forces` has the friction of the new tread, which the sliding work has lowered.
    settled = float(tires["lagged"].forces(kappa=kappa, alpha=alpha, Fz=4200.0, V=14.0).Fy)
    assert side == pytest.approx(settled * (1.0 + 0.1 * np.exp(-work / 5.0)) / 1.1, rel=2e-2)
    assert heat == pytest.approx(before, rel=0.01)
    assert host.set(V_y=0.0) == OK
    assert host.step(0.5, 0.5) == OK
    assert host.get("tread_heat")[0] < 0.96 * heat
    assert host.get("slip_growth")[0] < -0.9
