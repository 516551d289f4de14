"""The published tires. The small tire's printed tables are copied here, with its printed formula: kappa in percent."""

from __future__ import annotations

from dataclasses import replace
from math import radians

import numpy as np
import pandas as pd
import pytest

from tirefmu.tires import published

#: The UNICAMP paper's tables 2 and 3.
PURE_FX = {
    "PCX1": 0.070, "PDX1": -5.941, "PDX2": -1.027, "PEX1": 0.011, "PEX2": -0.063, "PEX3": 0.023, "PEX4": -12.513,
    "PKX1": 0.050, "PKX2": 0.085, "PKX3": -0.634, "PHX1": 0.883, "PHX2": -0.806, "PVX1": -0.032, "PVX2": -0.013,
    "PPX1": 1.654, "PPX2": 0.162, "PPX3": -0.090, "PPX4": -0.231,
}  # fmt: skip
PURE_FY = {
    "PCY1": 0.068, "PDY1": 1.189, "PDY2": 0.121, "PEY1": -0.019, "PEY2": -0.204, "PEY3": -3.483, "PKY1": 19.462,
    "PKY2": -68.684, "PKY4": -219.057, "PHY1": -0.014, "PHY2": -0.002, "PVY1": 0.023, "PVY2": -0.095,
    "PPY1": 0.368, "PPY2": -1.588, "PPY3": 13.491, "PPY4": -3.076,
}  # fmt: skip
COMBINED = {
    "RBX1": 261.6407, "RBX2": -3.7956, "RCX1": 0.8669, "REX1": -0.1240, "REX2": -1.0637, "RHX1": -0.0157,
    "RBY1": 3.1056e4, "RBY2": -3.1780e6, "RBY3": 0.0050, "RCY1": -0.9844, "REY1": 0.1370, "REY2": -0.0164,
    "RHY1": 1.0579, "RHY2": -0.9666, "RVY1": 984.5821, "RVY2": 30.4729, "RVY4": 1.6779e7, "RVY5": 49.8457,
    "RVY6": 55.0112,
}  # fmt: skip
PRINTED = PURE_FX | PURE_FY | COMBINED
#: Values that the paper does not print.
NOMINAL_LOAD, DPI = 60.0, 0.38

LOADS = (60.0, 110.0, 160.0)
ANGLES = np.radians(np.arange(-20.0, 21.0, 5.0))
#: From -50 to 100 percent. The paper has eleven and does not print which.
SLIPS = np.linspace(-0.5, 1.0, 16)
#: The paper's sum of squares of Fy in combined slip, N^2, and its points: three loads, nine angles, eleven slips.
MISSED, MEASURED = 9.9421e3, 297


def magic(B, C, E, x):
    return C * np.arctan(B * x - E * (B * x - np.arctan(B * x)))


def paper_forces(percent, alpha, load):
    """Evaluate Pacejka's (2012) formula with the printed numbers; kappa in percent, alpha* = alpha."""
    p = PRINTED
    dfz = load / NOMINAL_LOAD - 1.0
    # Longitudinal
    stiffness = (
        load * (p["PKX1"] + p["PKX2"] * dfz) * np.exp(p["PKX3"] * dfz) * (1 + p["PPX1"] * DPI + p["PPX2"] * DPI**2)
    )
    peak = load * (p["PDX1"] + p["PDX2"] * dfz) * (1 + p["PPX3"] * DPI + p["PPX4"] * DPI**2)
    x = percent + p["PHX1"] + p["PHX2"] * dfz
    curvature = (p["PEX1"] + p["PEX2"] * dfz + p["PEX3"] * dfz**2) * (1 - p["PEX4"] * np.sign(x))
    pure_x = peak * np.sin(magic(stiffness / (p["PCX1"] * peak), p["PCX1"], curvature, x))
    pure_x = pure_x + load * (p["PVX1"] + p["PVX2"] * dfz)
    weight = p["RBX1"] / np.hypot(1.0, p["RBX2"] * percent), p["RCX1"], p["REX1"] + p["REX2"] * dfz
    Fx = pure_x * np.cos(magic(*weight, alpha + p["RHX1"])) / np.cos(magic(*weight, p["RHX1"]))
    # Lateral
    top = p["PKY2"] * (1 + p["PPY2"] * DPI)
    stiffness = (
        p["PKY1"] * NOMINAL_LOAD * np.sin(p["PKY4"] * np.arctan(load / NOMINAL_LOAD / top)) * (1 + p["PPY1"] * DPI)
    )
    peak = load * (p["PDY1"] + p["PDY2"] * dfz) * (1 + p["PPY3"] * DPI + p["PPY4"] * DPI**2)
    x = alpha + p["PHY1"] + p["PHY2"] * dfz
    curvature = (p["PEY1"] + p["PEY2"] * dfz) * (1 - p["PEY3"] * np.sign(x))
    pure_y = peak * np.sin(magic(stiffness / (p["PCY1"] * peak), p["PCY1"], curvature, x))
    pure_y = pure_y + load * (p["PVY1"] + p["PVY2"] * dfz)
    weight = p["RBY1"] / np.hypot(1.0, p["RBY2"] * (alpha - p["RBY3"])), p["RCY1"], p["REY1"] + p["REY2"] * dfz
    shift = p["RHY1"] + p["RHY2"] * dfz
    Fy = pure_y * np.cos(magic(*weight, percent + shift)) / np.cos(magic(*weight, shift))
    induced = peak * (p["RVY1"] + p["RVY2"] * dfz) / np.hypot(1.0, p["RVY4"] * alpha)
    induced = induced * np.sin(p["RVY5"] * np.arctan(p["RVY6"] * percent))
    return Fx, Fy, induced


@pytest.fixture(scope="module")
def small():
    return published("unicamp_small_tire")


def bench(loads=LOADS, angles=ANGLES, slips=SLIPS):
    grid = np.meshgrid(loads, angles, slips, indexing="ij")
    return pd.DataFrame(dict(zip(("Fz", "alpha", "kappa"), (part.ravel() for part in grid), strict=True)))


def test_the_small_tire_has_the_forces_of_the_printed_formula(small):
    table = bench()
    printed = {"RBY1": 100.0 * PRINTED["RBY1"], "RBY2": PRINTED["RBY2"]}
    exact = replace(small, values={**small.values, **printed})
    computed = exact.evaluate(table, signs="adapted-sae", slip_angle="angle")
    Fx, Fy, _ = paper_forces(100.0 * table["kappa"], table["alpha"], table["Fz"])
    # The book's eps of 1e-6 N is in the stiffness factors only.
    np.testing.assert_allclose(computed["Fx"], Fx, rtol=1e-6, atol=1e-6)
    np.testing.assert_allclose(computed["Fy"], Fy, rtol=1e-6, atol=1e-6)
    assert {name for name in PURE_FX | PURE_FY if abs(PRINTED[name]) != abs(small.values[name])} == {
        "PKX1", "PKX2", "PHX1", "PHX2", "PKY1", "PKY2", "PKY4",
    }  # fmt: skip


def test_the_small_tire_has_no_spike(small):
    odd_angles, odd_slips = [0.0, PRINTED["RBY3"], -PRINTED["RHX1"]], [0.0]
    dfz = np.array(LOADS) / NOMINAL_LOAD - 1.0
    for first, second in (("RHY1", "RHY2"), ("PHX1", "PHX2")):
        odd_slips.extend(-(PRINTED[first] + PRINTED[second] * dfz) / 100.0)
    angles = np.unique(np.concatenate([np.linspace(-0.35, 0.35, 71), odd_angles]))
    slips = np.unique(np.concatenate([np.linspace(-0.5, 1.0, 76), odd_slips]))
    for slip_angle in ("tan", "angle"):
        forces = small.evaluate(bench(LOADS, angles, slips), slip_angle=slip_angle)
        assert np.isfinite(forces[["Fx", "Fy", "Mz", "Mx", "My"]].to_numpy()).all()
        assert (np.hypot(forces["Fx"], forces["Fy"]) < forces["Fz"]).all()
        assert forces["G_yk"].max() < 2.0


def test_the_small_tire_has_no_peak_of_the_longitudinal_force(small):
    slips = np.linspace(-0.5, 1.0, 301)
    for load in LOADS:
        assert np.all(np.diff(small.forces(kappa=slips, Fz=load)["Fx"]) > 0.0)


def test_the_small_tire_states_what_is_not_printed(small):
    assert {"printed", "inferred", "replaced", "left_out"} <= small.about.keys()
    assert small.ranges["Fz"] == (60.0, 160.0)
    assert small.ranges["alpha"] == pytest.approx((-radians(20.0), radians(20.0)))
    assert small.nominal("p") / small.values["NOMPRES"] - 1.0 == pytest.approx(DPI, abs=1e-12)
    assert not any(small.forces(alpha=0.1, kappa=0.1)[name] for name in ("Mz", "Mx", "My"))
