"""Temperatures in an FMU: outputs in kelvin with start parameters, equal to the evaluation, independent of the step."""

from __future__ import annotations

import xml.etree.ElementTree as ET
import zipfile
from types import SimpleNamespace

import numpy as np
import pandas as pd
import pytest

from .conftest import HEATED, OK

NODES = ("T_surface", "T_bulk", "T_carcass", "T_gas")


@pytest.fixture
def tire(tires):
    return tires["heated"]


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


def test_an_output_is_the_temperature_of_the_evaluation(tire, hosts):
    table = lap(0.02, until=1.0)
    evaluated = tire.evaluate(table, hold=True)
    host = hosts("heated", 3)
    host.initialize()
    for i, row in enumerate(table.drop(columns="t").to_dict("records")):
        assert host.set(**row) == OK
        if i == 0:
            assert host.call("ExitInitializationMode") == OK
        np.testing.assert_allclose(host.get(*NODES), evaluated[list(NODES)].iloc[i], rtol=0, atol=1e-9)
        assert host.step(0.02 * i, 0.02) == OK


@pytest.mark.parametrize("inputs", ["slip", "wheel", "hub"])
def test_heat_that_comes_in_is_stored_or_goes_out(tire, hosts, inputs):
    """At every step, for every kind of inputs, from what the FMU shows; with the pressure of a constant mass of gas."""
    shares = {"THPACT": 1.0, "THSHAREX": 1.0}
    given = {
        "slip": {"alpha": 0.1, "kappa": 0.03, "V": 15.0, "Fz": 1500.0}, "hub": {"r_z": 0.243, "v_x": 15.0, "v_y": -1.2},
        "wheel": {"V_x": 15.0, "V_y": -1.2, "omega": 65.0, "Fz": 1500.0},
    }[inputs]  # fmt: skip
    values = SimpleNamespace(**(tire.values | shares))
    host = hosts("heated", 3, inputs).start(**given, **shares, p=1.5e5)
    speed = "V" if inputs == "slip" else "V_x"
    for i in range(20):
        assert host.step(0.02 * i, 0.02) == OK
        slip, tangent, V, Fz, Fx, Fy = host.get("kappa_lagged", "tan_alpha_lagged", speed, "Fz", "Fx", "Fy")
        T, rates = host.get(*NODES), host.get(*(f"der({name})" for name in NODES))
        stored = [tire.values[f"THCAP{node}"] * rate for node, rate in zip("SBCG", rates, strict=True)]
        heat = (
            values.THSHARE * (abs(Fy * V * np.sin(np.arctan(tangent))) + abs(Fx * V * slip))
            + (values.THROLLB + values.THROLL) * Fz * V
        )
        contact = values.THROAD * (np.hypot(Fz, 1.0) / values.FNOMIN) ** values.THROADZ
        lost = (contact + values.THAIR * (1.0 + values.THAIRV * V)) * (T[0] - 293.15) + values.THSIDE * (T[2] - 293.15)
        assert sum(stored) == pytest.approx(heat - lost, rel=1e-9)
        assert host.get("p_acting")[0] + 101325.0 == pytest.approx((1.5e5 + 101325.0) * T[3] / 293.15, rel=1e-12)
    assert T[0] > HEATED["THSTARTS"] + 0.2


@pytest.mark.parametrize("inputs", ["wheel", "hub"])
def test_temperatures_with_other_inputs_are_those_of_the_evaluation(tire, hosts, inputs):
    """With the slips, speed and load that the FMU has from the motion of the wheel, held for each step."""
    host = hosts("heated", 3, inputs)
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
