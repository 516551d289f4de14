"""States of effects in an FMU: start values, equilibrium, derivatives, other inputs."""

from __future__ import annotations

import ctypes
import xml.etree.ElementTree as ET
import zipfile

import numpy as np
import pandas as pd
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


# --- Temperatures in an FMU: outputs in kelvin with start parameters, equal to the evaluation, independent of the step


NODES = ("T_surface", "T_bulk", "T_carcass", "T_gas")


@pytest.fixture
def tire(tires):
    return tires["heated"]


@pytest.mark.parametrize("inputs", ["wheel", "hub"])
def test_temperatures_with_other_inputs_are_those_of_the_evaluation(tire, hosts, inputs):
    """With the slips, speed and load that the FMU has from the motion of the wheel, held for each step."""
    host, shares = hosts("heated", 3, inputs), {"THPACT": 1.0, "THSHAREX": 1.0}
    host.initialize()
    assert host.set(**shares) == OK
    speed, rows, nodes = "V_x" if inputs == "wheel" else "v_x", [], []
    for i in range(40):
        motion = {speed: 15.0 + np.sin(0.3 * i), "omega": 62.0 + 4.0 * np.sin(0.2 * i), "T_road": 300.0 + i}
        motion |= {"V_y": np.sin(0.1 * i), "Fz": 1500.0 + 20.0 * i} if inputs == "wheel" else {"r_z": 0.243 - 1e-4 * i}
        assert host.set(**motion) == OK
        if i == 0:
            assert host.call("ExitInitializationMode") == OK
        named = dict(zip(("kappa", "alpha", "V", "Fz"), host.get("kappa", "alpha", "V_x", "Fz"), strict=True))
        rows.append({"t": 0.02 * i, **named, "T_road": 300.0 + i})
        nodes.append(host.get(*NODES))
        assert host.step(0.02 * i, 0.02) == OK
    evaluated = tire.with_values(**shares).evaluate(pd.DataFrame(rows), hold=True)
    np.testing.assert_allclose(nodes, evaluated[list(NODES)], rtol=1e-9)
    assert nodes[-1][0] > nodes[0][0] + 1.0


def test_the_description_has_kelvin_and_degrees_celsius(fmus, hosts):
    variables = hosts("heated", 3).variables
    assert {variables[name].causality for name in NODES} == {"output"}
    assert {variables[name].causality for name in ("T_ambient", "T_road")} == {"input"}
    assert {variables[name].unit for name in (*NODES, "T_ambient", "T_road")} == {"K"}
    assert {variables[name].initial for name in NODES} == {"exact"}
    with zipfile.ZipFile(fmus["heated", 3]) as archive:
        root = ET.fromstring(archive.read("modelDescription.xml"))
    (offset,) = (e.get("offset") for e in root.iter("DisplayUnit") if e.get("name") == "degC")
    assert float(offset) == -273.15


def test_start_temperatures_can_be_set(hosts):
    starts = dict(zip(NODES, (330.0, 325.0, 320.0, 310.0), strict=True))
    host = hosts("heated", 3).start(alpha=0.1, Fz=1500.0, V=15.0, **starts)
    np.testing.assert_allclose(host.get(*NODES), list(starts.values()), rtol=0, atol=1e-12)
