"""The formulas of the worksheet, transcribed from its description in plain scalar mathematics.

The golden numbers are those of one tire with all scaling factors at 1. This transcription agrees with them and
covers other tires and other scaling factors.
"""

from __future__ import annotations

import json
from math import atan, cos, exp, sin, sqrt

import numpy as np
import pandas as pd
import pytest

from tirefmu.symbolic.models import model_named
from tirefmu.tires import Tire, published


def Sign(x):
    return x / sqrt(x * x + 1e-6)


def magic(trig, B, C, D, E, x):
    return D * trig(C * atan(B * x - E * (B * x - atan(B * x))))


def slope(B, C, D, E, x):
    """The derivative by x with E constant, derived by hand."""
    bent = B * x - E * (B * x - atan(B * x))
    return D * cos(C * atan(bent)) * C / (1 + bent**2) * (B - E * (B - B / (1 + (B * x) ** 2)))


def worksheet(p, kappa, alpha, gamma, Fz):
    """Return every quantity of the worksheet at one point; p has the .tir names."""
    q = {}
    FZ01 = p["LFZ0"] * p["FNOMIN"]
    dfz = Fz / FZ01 - 1
    g = gamma * p["LGAMMAY"]
    R0 = p["UNLOADED_RADIUS"]

    SHx = (p["PHX1"] + p["PHX2"] * dfz) * p["LHX"]
    SVx = Fz * (p["PVX1"] + p["PVX2"] * dfz) * p["LVX"] * p["LMUX"]
    kx = kappa + SHx
    Cx = p["PCX1"] * p["LCX"]
    mux = (p["PDX1"] + p["PDX2"] * dfz) * (1 - p["PDX3"] * g**2) * p["LMUX"]
    Dx = mux * Fz
    Kxk = Fz * (p["PKX1"] + p["PKX2"] * dfz) * exp(-p["PKX3"] * dfz) * p["LKXK"]
    Ex = (p["PEX1"] + p["PEX2"] * dfz + p["PEX3"] * dfz**2) * (1 - p["PEX4"] * Sign(kx)) * p["LEX"]
    Bx = Kxk / (Cx * Dx)
    Fx0 = magic(sin, Bx, Cx, Dx, Ex, kx) + SVx
    q |= {"kappa_x": kx, "B_x": Bx, "C_x": Cx, "D_x": Dx, "E_x": Ex, "S_Vx": SVx, "S_Hx": SHx, "mu_x": mux}
    q |= {"K_xkappa": Kxk, "F_x0": Fx0, "F_x0_slope": slope(Bx, Cx, Dx, Ex, kx)}

    SHy = (p["PHY1"] + p["PHY2"] * dfz + p["PHY3"] * g) * p["LHY"]
    SVy = Fz * (p["PVY1"] + p["PVY2"] * dfz + (p["PVY3"] + p["PVY4"] * dfz) * g) * p["LVY"] * p["LMUY"]
    ay = alpha + SHy
    Cy = p["PCY1"] * p["LCY"]
    muy = (p["PDY1"] + p["PDY2"] * dfz) * (1 - p["PDY3"] * g**2) * p["LMUY"]
    Dy = muy * Fz
    Kya = FZ01 * p["PKY1"] * sin(2 * atan(Fz / (FZ01 * p["PKY2"]))) * (1 - p["PKY3"] * Sign(g)) * p["LFZ0"] * p["LKA"]
    Ey = (p["PEY1"] + p["PEY2"] * dfz) * (1 - (p["PEY3"] + p["PEY4"] * g) * Sign(ay)) * p["LEY"]
    By = Kya / (Cy * Dy)
    Fy0 = magic(sin, By, Cy, Dy, Ey, ay) + SVy
    q |= {"alpha_y": ay, "B_y": By, "C_y": Cy, "D_y": Dy, "E_y": Ey, "S_Vy": SVy, "S_Hy": SHy, "mu_y": muy}
    q |= {"K_yalpha": Kya, "F_y0": Fy0, "F_y0_slope": slope(By, Cy, Dy, Ey, ay)}

    SHt = p["QHZ1"] + p["QHZ2"] * dfz + (p["QHZ3"] + p["QHZ4"] * dfz) * g
    SHf = SHy + SVy / Kya
    at, ar = alpha + SHt, alpha + SHf
    Bt = (p["QBZ1"] + p["QBZ2"] * dfz + p["QBZ3"] * dfz**2) * (1 + p["QBZ4"] * g + p["QBZ5"] * Sign(g))
    Bt *= p["LKY"] / p["LMUY"]
    Ct = p["QCZ1"]
    Dt = Fz * (p["QDZ1"] + p["QDZ2"] * dfz) * (1 + p["QDZ3"] * g + p["QDZ4"] * g**2) * R0 / p["FNOMIN"] * p["LT"]
    Et = p["QEZ1"] + p["QEZ2"] * dfz + p["QEZ3"] * dfz**2
    Et *= 1 + (p["QEZ4"] + p["QEZ5"] * g) * atan(Bt * Ct * at)
    Br = p["QBZ9"] * p["LKY"] / p["LMUY"] + p["QBZ10"] * By * Cy
    Dr = Fz * (p["QDZ6"] + p["QDZ7"] * dfz + (p["QDZ8"] + p["QDZ9"] * dfz) * g) * R0 * p["LMUY"] * p["LMR"]
    Mz0 = -magic(cos, Bt, Ct, Dt, Et, at) * cos(alpha) * Fy0 + Dr * cos(atan(Br * ar)) * cos(alpha)
    q |= {"B_r": Br, "B_t": Bt, "C_t": Ct, "D_r": Dr, "D_t": Dt, "E_t": Et, "alpha_r": ar, "alpha_t": at, "M_z0": Mz0}

    Bxa = p["RBX1"] / sqrt(1 + (p["RBX2"] * kappa) ** 2) * p["LXA"]
    Gxa = cos(p["RCX1"] * atan(Bxa * (alpha + p["RHX1"]))) / cos(p["RCX1"] * atan(Bxa * p["RHX1"]))
    Byk = p["RBY1"] / sqrt(1 + (p["RBY2"] * (alpha - p["RBY3"])) ** 2) * p["LYK"]
    Gyk = cos(p["RCY1"] * atan(Byk * (kappa + p["RHY1"]))) / cos(p["RCY1"] * atan(Byk * p["RHY1"]))
    DVyk = muy * Fz * (p["RVY1"] + p["RVY2"] * dfz + p["RVY3"] * gamma) / sqrt(1 + (p["RVY4"] * alpha) ** 2)
    SVyk = DVyk * sin(p["RVY5"] * atan(p["RVY6"] * kappa)) * p["LVYK"]
    Fx, Fy = Gxa * Fx0, Gyk * Fy0 + SVyk
    q |= {"B_xalpha": Bxa, "G_xa": Gxa, "B_ykappa": Byk, "G_yk": Gyk, "S_Vyk": SVyk, "Fx": Fx, "Fy": Fy}

    # The worksheet has no combined Mz; this is the book's, (4.E71)-(4.E78), with smoothed equivalent slips.
    def equivalent(slip):
        return slip * sqrt(1 + (Kxk / Kya * kappa) ** 2 / (slip**2 + 1e-6))

    trail = magic(cos, Bt, Ct, Dt, Et, equivalent(at)) * cos(alpha)
    Mzr = Dr * cos(atan(Br * equivalent(ar))) * cos(alpha)
    s = R0 * (p["SSZ1"] + p["SSZ2"] * Fy / p["FNOMIN"] + (p["SSZ3"] + p["SSZ4"] * dfz) * g) * p["LS"]
    q |= {"trail": trail, "M_zr": Mzr, "s": s, "Mz": -trail * (Fy - SVyk) + Mzr + s * Fx}
    return q


def table_of(tire: Tire, inputs: pd.DataFrame) -> pd.DataFrame:
    return pd.DataFrame([worksheet(tire.values, *row) for row in inputs.itertuples(index=False)])


def largest_error(ours: pd.DataFrame, theirs: pd.DataFrame) -> float:
    """Return the largest |error| / (1 + |reference|); NaN where any number is NaN."""
    reference = theirs.to_numpy()
    return float(np.max(np.abs(ours[theirs.columns].to_numpy() - reference) / (1 + np.abs(reference))))


def test_the_transcription_agrees_with_the_golden_numbers(golden):
    rows = pd.read_csv(golden / "mf96_trento.csv.xz")
    inputs = rows[["kappa", "alpha", "gamma", "Fz"]]
    written = table_of(published("trento_hoosier"), inputs)
    names = {"FX0": "F_x0", "FY0": "F_y0", "MZ0": "M_z0", "FX": "Fx", "FY": "Fy", "Kya": "K_yalpha", "Et": "E_t"}
    theirs = rows[list(names)].rename(columns=names)
    assert largest_error(written, theirs) < 1e-9


def random_inputs(rng, nominal_load, n=40):
    return pd.DataFrame(
        {
            "kappa": rng.uniform(-1, 2, n),
            "alpha": rng.uniform(-0.8, 0.8, n),
            "gamma": rng.uniform(-0.2, 0.2, n),
            "Fz": rng.uniform(0.1, 3.0, n) * nominal_load,
        }
    )


@pytest.mark.parametrize("seed", range(10))
@pytest.mark.parametrize("signs", ["adapted-sae", "iso"])
def test_the_trento_tire_with_every_scaling_factor_moved(seed, signs):
    rng = np.random.default_rng(seed)
    trento = published("trento_hoosier").in_signs(signs)
    scales = {
        name: rng.uniform(0.5, 1.5) for name in trento.values if name in model_named("mf96").sections[2].coefficients
    }
    arms = {f"SSZ{i}": rng.uniform(-0.3, 0.3) for i in (1, 2, 3, 4)}
    tire = Tire("mf96", {**trento.values, **scales, **arms}, signs=signs)
    assert len(set(scales.values())) == 21
    inputs = random_inputs(rng, 220.0)
    assert largest_error(tire.evaluate(inputs, signs=signs), table_of(tire, inputs)) < 1e-9


@pytest.mark.parametrize("code", ["numpy", "c", "casadi"])
@pytest.mark.parametrize("seed", range(5))
def test_another_tire(seed, code):
    """Every coefficient anywhere within a tenth of its bounds around the generic start, signs included."""
    rng = np.random.default_rng(100 + seed)
    values = {}
    for name, declaration in model_named("mf96").coefficients.items():
        bound = declaration.upper if rng.random() < 0.5 else declaration.lower
        values[name] = declaration.generic + rng.uniform(0.02, 0.1) * (bound - declaration.generic)
    values |= {"FNOMIN": rng.uniform(500, 6000), "UNLOADED_RADIUS": rng.uniform(0.2, 0.5)}
    tire = Tire("mf96", values, signs="adapted-sae")
    inputs = random_inputs(rng, values["FNOMIN"])
    ours = tire.evaluate(inputs, signs="adapted-sae", code=code)
    assert largest_error(ours, table_of(tire, inputs)) < 1e-9


def test_parameters_of_the_golden_file_are_all_of_the_book(golden):
    parameters = json.loads((golden / "mf96_trento_params.json").read_text(encoding="utf-8"))
    names = {"FZ0": "FNOMIN", "R0": "UNLOADED_RADIUS"}
    given = {names.get(key, key.upper()) for key in parameters}
    assert model_named("mf96").coefficients.keys() - given == {"LS", "SSZ1", "SSZ2", "SSZ3", "SSZ4"}
