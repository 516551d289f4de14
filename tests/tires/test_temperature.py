"""Temperatures of a tire: against an integration of its own, energy, pauses, and what they act on."""

from __future__ import annotations

import numpy as np
import pandas as pd
import pytest
from scipy.integrate import simpson

from tirefmu.tires import Tire

NODES = ("T_surface", "T_carcass", "T_gas")
CAPACITY = {"T_surface": 140.0, "T_carcass": 1200.0, "T_gas": 900.0}
VALUES = {
    "FNOMIN": 1500.0, "UNLOADED_RADIUS": 0.25, "TMU1": -0.003, "TREF": 50.0, "THACT": 1.0, "THCAPS": 140.0,
    "THCAPC": 1200.0, "THCAPG": 900.0, "THSHARE": 0.55, "THSHAREX": 0.8, "THROLL": 0.011, "THROAD": 18.0,
    "THROADZ": 0.7, "THAIR": 0.3, "THAIRV": 0.15, "THSIDE": 3.0, "THCONS": 110.0, "THCONG": 15.0,
    "THSTARTS": 300.0, "THSTARTC": 305.0, "THSTARTG": 310.0,
}  # fmt: skip


@pytest.fixture(scope="module")
def tire():
    return Tire("mf96", VALUES, effects={"temperature", "temp_friction"})


@pytest.fixture(scope="module")
def sensed():
    """Return the same tire without a heat balance, whose forces have the recorded temperature."""
    plain = {name: value for name, value in VALUES.items() if not name.startswith("TH")}
    return Tire("mf96", plain, effects={"temp_friction"})


def drive(t):
    return pd.DataFrame(
        {
            "t": t, "kappa": 0.06 * np.sin(0.9 * t), "alpha": 0.1 * np.sin(t), "Fz": 1500.0 + 400.0 * np.sin(0.3 * t),
            "V": 14.0 + 4.0 * np.cos(0.2 * t), "T_ambient": 293.0 + 0.1 * t, "T_road": 303.0 - 0.1 * t,
        }
    )  # fmt: skip


def flows(row):
    """Return heat from sliding, from rolling, to the road, to the air, and between nodes, W, in plain NumPy."""
    surface, carcass, gas = (row[name] for name in NODES)
    lateral, longitudinal = abs(row["Fy"] * row["V"] * np.sin(row["alpha"])), abs(row["Fx"] * row["V"] * row["kappa"])
    sliding = VALUES["THSHARE"] * (lateral + VALUES["THSHAREX"] * longitudinal)
    rolling = VALUES["THROLL"] * row["Fz"] * row["V"]
    load = np.hypot(row["Fz"], 1.0)  # not 0, whose powers have no derivative
    contact = VALUES["THROAD"] * (load / VALUES["FNOMIN"]) ** VALUES["THROADZ"]
    road = contact * (surface - row["T_road"])
    air = VALUES["THAIR"] * (1.0 + VALUES["THAIRV"] * row["V"]) * (surface - row["T_ambient"])
    side = VALUES["THSIDE"] * (carcass - row["T_ambient"])
    inward, deeper = VALUES["THCONS"] * (surface - carcass), VALUES["THCONG"] * (carcass - gas)
    return sliding, rolling, road, air, side, inward, deeper


def test_it_is_the_integration_of_the_heat_flows(tire, sensed):
    """Runge-Kutta steps of fourth order over the rows, with forces of the tire at the temperature of each stage."""
    t = np.linspace(0.0, 8.0, 161)
    evaluated = tire.evaluate(drive(t))

    def rates(time, x):
        inputs = drive(np.array([time])).iloc[0].to_dict()
        given = {name: inputs[name] for name in ("kappa", "alpha", "Fz", "V")}
        forces = sensed.forces(**given, T=x[0] - 273.15)
        row = {**inputs, "Fx": float(forces.Fx), "Fy": float(forces.Fy), **dict(zip(NODES, x, strict=True))}
        sliding, rolling, road, air, side, inward, deeper = flows(row)
        heat = np.array([sliding - road - air - inward, rolling + inward - deeper - side, deeper])
        return heat / np.array([CAPACITY[name] for name in NODES])

    x = np.array([VALUES["THSTARTS"], VALUES["THSTARTC"], VALUES["THSTARTG"]])
    for now, h in zip(t[:40], np.diff(t)[:40], strict=True):
        a = rates(now, x)
        b = rates(now + h / 2, x + h / 2 * a)
        c = rates(now + h / 2, x + h / 2 * b)
        x = x + h / 6 * (a + 2 * b + 2 * c + rates(now + h, x + h * c))
    # Inputs are linear between the rows of the table, and curves here.
    np.testing.assert_allclose(evaluated[list(NODES)].iloc[40], x, rtol=0, atol=1e-2)


def test_energy_is_conserved(tire):
    """The heat that comes in is stored or goes out: at every row, and integrated with constant inputs."""
    table = drive(np.linspace(0.0, 5.0, 101))
    evaluated = tire.evaluate(table)
    sliding, rolling, road, air, side, *_ = flows(evaluated)
    stored = sum(CAPACITY[name] * evaluated[f"{name}_derivative"] for name in NODES)
    np.testing.assert_allclose(stored, sliding + rolling - road - air - side, rtol=0, atol=1e-9 * np.abs(stored).max())
    t = np.linspace(0.0, 20.0, 2001)
    steady = {"kappa": 0.03, "alpha": 0.08, "Fz": 1500.0, "V": 14.0}
    course = tire.evaluate(pd.DataFrame({"t": t, **steady}), hold=True)
    sliding, rolling, road, air, side, *_ = flows(course)
    inflow = simpson(sliding + rolling - road - air - side, x=t)
    gained = sum(CAPACITY[name] * (course[name].iloc[-1] - course[name].iloc[0]) for name in NODES)
    assert gained > 1e4
    assert gained == pytest.approx(inflow, rel=1e-9)


def test_a_pause_cools_the_tire(tire):
    """Slips at the ends of a gap in time do not heat the tire in it; a long pause ends near its surroundings."""
    t = np.concatenate([np.arange(0.0, 5.0, 0.05), np.arange(605.0, 606.0, 0.05)])
    still = tire.with_values(THROLL=0.0)
    hot = still.evaluate(pd.DataFrame({"t": t, "alpha": 0.1, "kappa": 0.05, "Fz": 1500.0, "V": 14.0}))
    before, after = hot["T_surface"].iloc[[99, 100]]
    assert before > VALUES["THSTARTS"] + 5.0
    assert after < 293.15 + 0.2 * (before - 293.15)


def test_predicted_or_recorded_temperature_acts(tire, sensed):
    table = drive(np.linspace(0.0, 5.0, 51)).assign(T=80.0)
    recorded = tire.with_values(THACT=0.0).evaluate(table)
    np.testing.assert_allclose(recorded[["Fx", "Fy"]], sensed.evaluate(table)[["Fx", "Fy"]], rtol=0, atol=1e-9)
    predicted = tire.evaluate(table)
    np.testing.assert_allclose(predicted["T_acting"], predicted["T_surface"] - 273.15, rtol=0, atol=1e-9)
    assert np.abs(predicted["Fy"] - recorded["Fy"]).max() > 50.0
