"""Temperatures of a tire: against an integration of its own, energy, pauses, and what they act on."""

from __future__ import annotations

import numpy as np
import pandas as pd
import pytest
from scipy.integrate import simpson

from tirefmu.boundary.errors import EffectError
from tirefmu.symbolic.added.file import read_effect
from tirefmu.symbolic.models import model_named
from tirefmu.tires import Tire
from tirefmu.tires.states import simulation as states

NODES = ("T_surface", "T_bulk", "T_carcass", "T_gas")
CAPACITY = {"T_surface": 140.0, "T_bulk": 450.0, "T_carcass": 1200.0, "T_gas": 900.0}
VALUES = {
    "FNOMIN": 1500.0, "UNLOADED_RADIUS": 0.25, "TMU1": -0.003, "TREF": 50.0, "THACT": 1.0, "THCAPS": 140.0,
    "THCAPC": 1200.0, "THCAPG": 900.0, "THSHARE": 0.55, "THSHAREX": 0.8, "THROLLB": 0.004, "THROLL": 0.007,
    "THROAD": 18.0, "THROADZ": 0.7, "THAIR": 0.3, "THAIRV": 0.15, "THSIDE": 3.0, "THCONS": 110.0, "THCONG": 15.0,
    "THCAPB": 450.0, "THCONB": 70.0, "THSTARTB": 302.0, "THSTARTS": 300.0, "THSTARTC": 305.0, "THSTARTG": 310.0,
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
    """Return heat from sliding, from rolling (bulk, carcass), to road and air, from the carcass, and between nodes."""
    surface, bulk, carcass, gas = (row[name] for name in NODES)
    lateral, longitudinal = abs(row["Fy"] * row["V"] * np.sin(row["alpha"])), abs(row["Fx"] * row["V"] * row["kappa"])
    sliding = VALUES["THSHARE"] * (lateral + VALUES["THSHAREX"] * longitudinal)
    rolling = [VALUES[name] * row["Fz"] * row["V"] for name in ("THROLLB", "THROLL")]
    load = np.hypot(row["Fz"], 1.0)  # not 0, whose powers have no derivative
    contact = VALUES["THROAD"] * (load / VALUES["FNOMIN"]) ** VALUES["THROADZ"]
    road = contact * (surface - row["T_road"])
    air = VALUES["THAIR"] * (1.0 + VALUES["THAIRV"] * row["V"]) * (surface - row["T_ambient"])
    side = VALUES["THSIDE"] * (carcass - row["T_ambient"])
    exchanged = [VALUES[name] * (outer - inner) for name, outer, inner in (
        ("THCONS", surface, bulk), ("THCONB", bulk, carcass), ("THCONG", carcass, gas))]  # fmt: skip
    return sliding, rolling, road, air, side, exchanged


def test_it_is_the_integration_of_the_heat_flows(tire, sensed):
    """Runge-Kutta steps of fourth order over the rows, with forces of the tire at the temperature of each stage."""
    t = np.linspace(0.0, 8.0, 161)
    evaluated = tire.evaluate(drive(t))

    def rates(time, x):
        inputs = drive(np.array([time])).iloc[0].to_dict()
        given = {name: inputs[name] for name in ("kappa", "alpha", "Fz", "V")}
        forces = sensed.forces(**given, T=x[0] - 273.15)
        row = {**inputs, "Fx": float(forces.Fx), "Fy": float(forces.Fy), **dict(zip(NODES, x, strict=True))}
        sliding, rolling, road, air, side, exchanged = flows(row)
        heat = np.array([sliding - road - air, rolling[0], rolling[1] - side, 0.0])
        heat[:-1] -= exchanged
        heat[1:] += exchanged
        return heat / np.array([CAPACITY[name] for name in NODES])

    x = np.array([VALUES[f"THSTART{node}"] for node in "SBCG"])
    for now, h in zip(t[:40], np.diff(t)[:40], strict=True):
        a = rates(now, x)
        b = rates(now + h / 2, x + h / 2 * a)
        c = rates(now + h / 2, x + h / 2 * b)
        x = x + h / 6 * (a + 2 * b + 2 * c + rates(now + h, x + h * c))
    # Inputs are linear between the rows of the table, and curves here.
    np.testing.assert_allclose(evaluated[list(NODES)].iloc[40], x, rtol=0, atol=1e-2)


def test_energy_is_conserved(tire):
    """The heat that comes in is stored or goes out: at every row, and integrated with constant inputs and forces."""
    table = drive(np.linspace(0.0, 5.0, 101))
    evaluated = tire.evaluate(table)
    sliding, rolling, road, air, side, _ = flows(evaluated)
    stored = sum(CAPACITY[name] * evaluated[f"{name}_derivative"] for name in NODES)
    np.testing.assert_allclose(
        stored, sliding + sum(rolling) - road - air - side, rtol=0, atol=1e-9 * np.abs(stored).max()
    )
    t = np.linspace(0.0, 20.0, 2001)
    steady = {"kappa": 0.03, "alpha": 0.08, "Fz": 1500.0, "V": 14.0}
    course = tire.with_values(THACT=0.0).evaluate(pd.DataFrame({"t": t, **steady}), hold=True)
    sliding, rolling, road, air, side, _ = flows(course)
    inflow = simpson(sliding + sum(rolling) - road - air - side, x=t)
    gained = sum(CAPACITY[name] * (course[name].iloc[-1] - course[name].iloc[0]) for name in NODES)
    assert gained > 1e4
    assert gained == pytest.approx(inflow, rel=1e-9)


def test_the_gas_sets_the_pressure(tire):
    """A constant mass of gas: the absolute pressure is proportional to its temperature."""
    hot = tire.with_values(THPACT=1.0).evaluate(drive(np.linspace(0.0, 5.0, 51)).assign(p=1.5e5))
    np.testing.assert_allclose((hot["p_acting"] + 101325.0) / hot["T_gas"], (1.5e5 + 101325.0) / 293.15, rtol=1e-12)
    np.testing.assert_array_equal(tire.evaluate(drive(np.zeros(1)).assign(p=1.5e5))["p_acting"], 1.5e5)


@pytest.mark.parametrize("drive", ["0.1*(300 - T_one)**2", "sliding_power/1000", "T_ambient - T_road*T_one*T_one"])
def test_a_temperature_is_linear_and_cools(drive):
    effect = read_effect(
        f"""name = "hot"\nphysics = "x"\n[coefficients]\nXSTART = {{description = "x", neutral = 300.0, upper = 400.0}}
        [[acts]]\non = "friction_y"\nfactor = "T_one/XSTART"
        [states.T_one]\nkind = "temperature"\ndrive = "{drive}"\nstart = "XSTART"\n""", "hot.toml",
    )  # fmt: skip
    with pytest.raises(EffectError, match="state T_one: the drive of a temperature is linear"):
        model_named("mf96").extended([effect])


def test_a_pause_cools_the_tire(tire):
    """Slips at the ends of a gap in time do not heat the tire in it; a long pause ends near its surroundings."""
    t = np.concatenate([np.arange(0.0, 5.0, 0.05), np.arange(605.0, 606.0, 0.05)])
    still = tire.with_values(THROLLB=0.0, THROLL=0.0)
    hot = still.evaluate(pd.DataFrame({"t": t, "alpha": 0.1, "kappa": 0.05, "Fz": 1500.0, "V": 14.0}))
    before, after = hot["T_surface"].iloc[[99, 100]]
    assert before > VALUES["THSTARTS"] + 5.0
    assert after < 293.15 + 0.2 * (before - 293.15)


def test_rows_that_are_solved_together_are_steps_one_after_another(tire, monkeypatch):
    """A step from the temperatures of a row ends at those of the next one; so do rows that converge in parts only."""
    table = drive(np.arange(0.0, 300.0, 1.0))
    together = tire.evaluate(table, hold=True)
    state, step = together.iloc[200], table.iloc[200:202]
    begun = tire.with_values(**{f"THSTART{node[2].upper()}": state[node] for node in NODES}).evaluate(step, hold=True)
    np.testing.assert_allclose(begun[list(NODES)].iloc[1], together[list(NODES)].iloc[201], rtol=0, atol=1e-9)
    monkeypatch.setattr(states, "MAX_ITERATIONS", 4)
    divided = tire.evaluate(table, hold=True)
    np.testing.assert_allclose(divided[list(NODES)], together[list(NODES)], rtol=0, atol=1e-9)


def test_predicted_or_recorded_temperature_acts(tire, sensed):
    table = drive(np.linspace(0.0, 5.0, 51)).assign(T=80.0)
    recorded = tire.with_values(THACT=0.0).evaluate(table)
    np.testing.assert_allclose(recorded[["Fx", "Fy"]], sensed.evaluate(table)[["Fx", "Fy"]], rtol=0, atol=1e-9)
    predicted = tire.evaluate(table)
    np.testing.assert_allclose(predicted["T_acting"], predicted["T_surface"] - 273.15, rtol=0, atol=1e-9)
    assert np.abs(predicted["Fy"] - recorded["Fy"]).max() > 50.0


def test_heat_friction_is_the_same_law_with_one_node():
    """Its coefficients follow from those of a surface that exchanges heat with its surroundings only."""
    one_node = {**VALUES, "TMU1": 0.0, "TMUA": 0.004, "TREF": 20.0, "THCONS": 0.0, "THROADZ": 0.0, "THSHAREX": 1.0,
                "THSTARTS": 293.15}  # fmt: skip
    conductance = one_node["THROAD"] + one_node["THAIR"]
    same = {
        "HMU": one_node["TMUA"] * one_node["THSHARE"] * one_node["FNOMIN"] / conductance,
        "HTAU": one_node["THCAPS"] / conductance, "HCOOL": one_node["THAIR"] * one_node["THAIRV"] / conductance,
    }  # fmt: skip
    table = drive(np.arange(0.0, 30.0, 0.01)).drop(columns=["T_ambient", "T_road"])
    kelvin = Tire("mf96", one_node, effects={"temperature", "temp_friction"}).evaluate(table)
    size = {name: VALUES[name] for name in ("FNOMIN", "UNLOADED_RADIUS")}
    heat = Tire("mf96", size | same, effects={"heat_friction"}).evaluate(table)
    scale = same["HMU"] / one_node["TMUA"]
    np.testing.assert_allclose(scale * heat["tread_heat"], kelvin["T_surface"] - 293.15, rtol=0, atol=0.05)
    np.testing.assert_allclose(heat[["Fx", "Fy"]], kelvin[["Fx", "Fy"]], rtol=0, atol=1.0)
    assert kelvin["T_surface"].iloc[-1] > 313.0
