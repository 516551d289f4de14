"""Temperatures in an FMU: outputs in kelvin with start parameters, equal to the evaluation, independent of the step."""

from __future__ import annotations

import xml.etree.ElementTree as ET
import zipfile
from types import SimpleNamespace

import numpy as np
import pandas as pd
import pytest
from fmpy.validation import validate_fmu

from tirefmu.fmu import check, export
from tirefmu.fmu.simulation.simulate import loaded
from tirefmu.tires import Tire

OK = 0
VALUES = {
    "FNOMIN": 1500.0, "UNLOADED_RADIUS": 0.25, "SIGX": 0.1, "SIGY": 0.3, "TMU1": -0.002, "TMU2": -2e-5, "TREF": 60.0,
    "THACT": 1.0, "THSTARTS": 295.0, "THSTARTC": 297.0, "THSTARTG": 299.0,
}  # fmt: skip
NODES = ("T_surface", "T_bulk", "T_carcass", "T_gas")


@pytest.fixture(scope="module")
def tire():
    return Tire("mf61", VALUES, effects={"temperature", "temp_friction", "relax_lat", "relax_lon"})


@pytest.fixture(scope="module")
def fmu(compiler, tire, tmp_path_factory):
    return export(tire, tmp_path_factory.mktemp("temperature") / "tire.fmu")


def lap(step, until=6.0):
    """Return a lap in which slips, load, speed and surroundings change, with inputs that are held for 0.1 s."""
    t = np.arange(0.0, until, step)
    held = np.floor(t / 0.1 + 1e-9) * 0.1
    return pd.DataFrame(
        {
            "t": t, "kappa": 0.08 * np.sin(1.7 * held), "alpha": 0.12 * np.sin(held),
            "V": 15.0 + 5.0 * np.sin(0.7 * held), "Fz": 1500.0 + 600.0 * np.sin(2.3 * held),
            "T_ambient": 290.0 + held, "T_road": 305.0 - held,
        }
    )  # fmt: skip


def test_temperatures_are_those_of_the_evaluation(fmu, tire):
    table = lap(0.02)
    evaluated = tire.evaluate(table, hold=True)
    result = check(fmu, table.assign(**evaluated[list(tire.outputs)]))
    assert result.ok
    assert result.evaluation_difference < 1e-9
    assert evaluated["T_surface"].iloc[-1] > VALUES["THSTARTS"] + 3.0  # it was heated


def test_temperatures_beside_other_states_are_those_of_the_evaluation(compiler, tire, tmp_path):
    """A state that forces drive, lags of inputs, and a hysteresis along them."""
    values = {**VALUES, "BIMU": 0.1, "BIWORK": 5.0, "SHMUY": 0.05}
    more = Tire("mf61", values, effects={*tire.has, "break_in", "slip_history"})
    table = lap(0.05)
    result = check(
        export(more, tmp_path / "tire.fmu"), table.assign(**more.evaluate(table, hold=True)[list(more.outputs)])
    )
    assert result.evaluation_difference < 1e-9


def test_an_output_is_the_temperature_of_the_evaluation(fmu, tire, make_host):
    table = lap(0.02, until=1.0)
    evaluated = tire.evaluate(table, hold=True)
    host = make_host(fmu)
    host.initialize()
    for i, row in enumerate(table.drop(columns="t").to_dict("records")):
        assert host.set(**row) == OK
        if i == 0:
            assert host.call("ExitInitializationMode") == OK
        np.testing.assert_allclose(host.get(*NODES), evaluated[list(NODES)].iloc[i], rtol=0, atol=1e-9)
        assert host.step(0.02 * i, 0.02) == OK


@pytest.mark.parametrize("inputs", ["slip", "wheel", "hub"])
def test_heat_that_comes_in_is_stored_or_goes_out(compiler, tire, tmp_path, make_host, inputs):
    """At every step, for every kind of inputs, from what the FMU shows; with the pressure of a constant mass of gas."""
    warm = tire.with_values(THPACT=1.0, THSHAREX=1.0)
    host = make_host(export(warm, tmp_path / "tire.fmu", inputs=inputs))
    host.initialize()
    given = {
        "slip": {"alpha": 0.1, "kappa": 0.03, "V": 15.0, "Fz": 1500.0}, "hub": {"r_z": 0.243, "v_x": 15.0, "v_y": -1.2},
        "wheel": {"V_x": 15.0, "V_y": -1.2, "omega": 65.0, "Fz": 1500.0},
    }[inputs]  # fmt: skip
    assert host.set(**given, p=1.5e5) == OK
    assert host.call("ExitInitializationMode") == OK
    speed = "V" if inputs == "slip" else "V_x"
    for i in range(20):
        assert host.step(0.02 * i, 0.02) == OK
        slip, tangent, V, Fz, Fx, Fy = host.get("kappa_lagged", "tan_alpha_lagged", speed, "Fz", "Fx", "Fy")
        T, rates = host.get(*NODES), host.get(*(f"der({name})" for name in NODES))
        stored = [warm.values[f"THCAP{node}"] * rate for node, rate in zip("SBCG", rates, strict=True)]
        values = SimpleNamespace(**warm.values)
        heat = (
            values.THSHARE * (abs(Fy * V * np.sin(np.arctan(tangent))) + abs(Fx * V * slip))
            + (values.THROLLB + values.THROLL) * Fz * V
        )
        contact = values.THROAD * (np.hypot(Fz, 1.0) / values.FNOMIN) ** values.THROADZ
        lost = (contact + values.THAIR * (1.0 + values.THAIRV * V)) * (T[0] - 293.15) + values.THSIDE * (T[2] - 293.15)
        assert sum(stored) == pytest.approx(heat - lost, rel=1e-9)
        assert host.get("p_acting")[0] + 101325.0 == pytest.approx((1.5e5 + 101325.0) * T[3] / 293.15, rel=1e-12)
    assert T[0] > VALUES["THSTARTS"] + 0.2


@pytest.mark.parametrize("inputs", ["wheel", "hub"])
def test_temperatures_with_other_inputs_are_those_of_the_evaluation(compiler, tire, tmp_path, make_host, inputs):
    """With the slips, speed and load that the FMU has from the motion of the wheel, held for each step."""
    host = make_host(export(tire, tmp_path / "tire.fmu", inputs=inputs))
    host.initialize()
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
    evaluated = tire.evaluate(pd.DataFrame(rows), hold=True)
    np.testing.assert_allclose(nodes, evaluated[list(NODES)], rtol=1e-9)
    assert nodes[-1][0] > nodes[0][0] + 1.0


def test_the_step_does_not_change_temperatures(tire):
    """Steps of 1 and 20 ms agree within 0.05 K, and so do their forces."""
    end = {step: tire.evaluate(lap(step), hold=True).set_index("t") for step in (0.001, 0.02)}
    shared = np.round(np.arange(0.0, 5.9, 0.1), 9)
    rows = {step: frame[np.isin(np.round(frame.index, 9), shared)] for step, frame in end.items()}
    difference = rows[0.001][list(NODES)].to_numpy() - rows[0.02][list(NODES)].to_numpy()
    assert len(difference) == len(shared)
    assert np.abs(difference).max() < 0.05


def test_the_description_has_kelvin_and_degrees_celsius(fmu):
    assert validate_fmu(str(fmu)) == []
    with loaded(fmu) as slave:
        variables = {variable.name: variable for variable in slave.description.modelVariables}
    assert {variables[name].causality for name in NODES} == {"output"}
    assert {variables[name].causality for name in ("T_ambient", "T_road")} == {"input"}
    assert {variables[name].unit for name in (*NODES, "T_ambient", "T_road")} == {"K"}
    assert {variables[name].initial for name in NODES} == {"exact"}
    with zipfile.ZipFile(fmu) as archive:
        root = ET.fromstring(archive.read("modelDescription.xml"))
    (offset,) = (e.get("offset") for e in root.iter("DisplayUnit") if e.get("name") == "degC")
    assert float(offset) == -273.15


def test_start_temperatures_can_be_set_and_are_restored(fmu, make_host):
    host = make_host(fmu)
    host.initialize()
    assert host.set(alpha=0.1, Fz=1500.0, V=15.0, T_surface=330.0, T_bulk=325.0, T_carcass=320.0, T_gas=310.0) == OK
    assert host.call("ExitInitializationMode") == OK
    np.testing.assert_allclose(host.get(*NODES), [330.0, 325.0, 320.0, 310.0], rtol=0, atol=1e-12)
    assert host.step(0.0, 0.2) == OK
    saved = host.save()
    before = host.everything()
    assert host.step(0.2, 0.5) == OK
    assert not np.array_equal(host.everything(), before)
    assert host.restore(saved) == OK
    np.testing.assert_array_equal(host.everything(), before)
