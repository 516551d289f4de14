"""The code of the book against a plain transcription of the equations, for conditions without golden rows.

Random tires without neutral coefficients, random rows from standstill to far outside the range, every option.
"""

from __future__ import annotations

from itertools import product

import numpy as np
import pandas as pd
import pytest

from tirefmu.symbolic.models import MODELS
from tirefmu.tires import Tire

MODES = [
    pytest.param({"convention": convention, "slip_angle": slip_angle, "limits": limits}, id=name)
    for convention, slip_angle, limits in product(("tno", "book"), ("tan", "angle"), (False, True))
    for name in [f"{convention}-{slip_angle}-{'limits' if limits else 'free'}"]
]
#: Where the equations have no value with turn slip: 0/0 at no load, where tirefmu returns 0; at no load and no
#: speed also the shift by spin and the results that depend on it.
NO_VALUE_AT_NO_LOAD = {"Mz", "M_zr", "D_r", "M_z0"}
NO_VALUE_AT_REST = {"Fy", "Mx", "F_y0", "S_Hy", "alpha_y", "alpha_r", "E_y", "B_r", "R_l", "rho", "c_z"}
INPUTS = ("kappa", "alpha", "gamma", "Fz", "p", "V", "phit")
TOLERANCE = 1e-9


@pytest.fixture(params=["mf52", "mf61", "mf62"])
def model(request) -> str:
    return request.param


@pytest.fixture(params=range(3))
def seed(request) -> int:
    return request.param


@pytest.fixture
def values(model, seed, random_tire) -> dict[str, float]:
    return random_tire(model, seed)


def made(model: str, values: dict[str, float]) -> Tire:
    return Tire(model, {name: values[name] for name in MODELS[model].coefficients if name in values})


def rounding(model, values, reference) -> dict[str, np.ndarray]:
    """Return the accuracy of rho, R_l and c_z in double precision in (-q + sqrt(q^2 + 4 Q_FZ2 c)) / (2 Q_FZ2).

    In MFeval's form another order of operations changes q by a few ulp, which is multiplied by 1 / (2 Q_FZ2).
    """
    if model == "mf62" or values["Q_FZ2"] == 0:
        return {}
    linear = values["VERTICAL_STIFFNESS"] * values["UNLOADED_RADIUS"] / values["FNOMIN"]
    length = 8 * np.finfo(float).eps * linear / (2 * abs(values["Q_FZ2"])) * values["UNLOADED_RADIUS"]
    with np.errstate(divide="ignore"):
        return {"rho": length, "R_l": length, "c_z": length / reference["rho"]}


def compare(
    sheet, model, values, rows, code="numpy", **mode
) -> tuple[dict[str, str], dict[str, np.ndarray], dict[str, np.ndarray]]:
    """Return the differences, the rows without a value in the transcription, and the transcription's values."""
    answer = made(model, values).evaluate(pd.DataFrame(rows), code=code, **mode)
    assert not answer.isna().any(axis=None), f"NaN in {list(answer.columns[answer.isna().any()])}"
    wrong, without = {}, {}
    expected = sheet.evaluate(values, rows, model=model, **mode)
    rounded = rounding(model, values, expected)
    for name, reference in expected.items():
        ours = answer[name].to_numpy()
        with np.errstate(invalid="ignore"):  # both infinite: c_z of a tire that the forces lift off the rim
            error = np.where(ours == reference, 0.0, np.abs(ours - reference) / (1 + np.abs(reference)))
        # Without deflection, a stated rule of the product: it counts as one micrometre, so that c_z is finite.
        flat = (
            expected["rho"] == 0.0 if "rho" in expected and name in ("rho", "c_z") else np.zeros(len(reference), bool)
        )
        assert np.all(answer["rho"].to_numpy()[flat] <= 1e-6)
        valued = ~np.isnan(reference) & ~flat
        bad = valued & ~(error < TOLERANCE + rounded.get(name, 0.0))
        if bad.any():
            worst = int(np.argmax(np.where(bad, error, -1.0)))
            at = {key: float(column[worst]) for key, column in rows.items()}
            wrong[name] = f"{bad.sum()} rows, worst {ours[worst]!r} for {reference[worst]!r} at {at}"
        if np.isnan(reference).any():
            without[name] = np.isnan(reference)
    return wrong, without, expected


def assert_agrees(sheet, model, values, rows, **given) -> None:
    """Assert that only the loaded radius of MF6.2 has no value, and only where the rim touches the ground.

    Fx and Fy soften the tire (Q_FCX, Q_FCY): it is on its rim under less load than when it rolls freely.
    """
    wrong, without, forces = compare(sheet, model, values, rows, **given)
    assert wrong == {}
    if not without:
        return
    stiffness = values["VERTICAL_STIFFNESS"] * (1 + values["PFZ1"] * (rows["p"] / values["NOMPRES"] - 1))
    soft = [(values[key] * forces[name] / values["FNOMIN"]) ** 2 for key, name in (("Q_FCX", "Fx"), ("Q_FCY", "Fy"))]
    clearance = values["UNLOADED_RADIUS"] - values["RIM_RADIUS"] - values["BOTTOM_OFFST"]
    bottomed = rows["Fz"] > clearance * stiffness * (1 - sum(soft))
    assert (model, without.keys()) == ("mf62", {"R_l", "rho", "c_z"})
    assert all(bottomed[where].all() for where in without.values())


def test_every_quantity_is_compared(sheet, model, values):
    rows = {name: np.array([x]) for name, x in zip(INPUTS, (0.1, 0.1, 0.1, 4000.0, 2e5, 20.0, 0.0), strict=True)}
    ours = set(made(model, values).evaluate(pd.DataFrame(rows)).columns)
    assert set(sheet.evaluate(values, rows, model=model)) <= ours


def test_no_coefficient_is_neutral(model, values):
    """A neutral coefficient would hide a wrong line."""
    declarations = MODELS[model].coefficients
    assert not [name for name in declarations.keys() - values.keys() if declarations[name].published]
    neutral = {name for name in declarations.keys() & values.keys() if values[name] == declarations[name].neutral}
    assert neutral <= {"Q_A1", "Q_A2"}  # 0 in every other tire: then MF5.2 estimates them


def edges(values) -> dict[str, np.ndarray]:
    """Return zero slip, zero camber, standstill, the locked wheel, the speeds and loads at which rules change."""
    speeds = (0.0, values["VXLOW"], -values["VXLOW"], 20.0, -20.0)
    grid = product((0.0, -1.0, 0.1), (0.0, 0.1), (0.0, -0.08), (values["FZMIN"], 4000.0), (2e5,), speeds, (0.0, 0.04))
    return {name: np.array(column) for name, column in zip(INPUTS, zip(*grid, strict=True), strict=True)}


@pytest.mark.parametrize("mode", MODES)
def test_every_mode(sheet, model, values, seed, random_rows, mode):
    """Random rows and edges, and a spin moment beyond its peak.

    Where M_zphi90 exceeds D_rphi zeta7 is complex, of either sign: G_yk is below 0 in wide slip.
    """
    rows = random_rows(values, 400, seed)
    turning = {**rows, "phit": np.where(rows["phit"] == 0, 0.05, rows["phit"])}
    extreme = edges(values)
    all_rows = {name: np.concatenate([column, extreme[name]]) for name, column in rows.items()}
    for changed, given in (({}, all_rows), ({"RCY1": 1.35, "QCRP2": 3.0}, turning)):
        assert_agrees(sheet, model, values | changed, given, **mode)


@pytest.mark.parametrize("code", ["c", "casadi"])
@pytest.mark.parametrize("mode", MODES[::7])
def test_random_rows_in_other_languages(sheet, model, values, seed, random_rows, mode, code):
    assert_agrees(sheet, model, values, random_rows(values, 200, seed + 50), code=code, **mode)


@pytest.mark.parametrize("model", ["mf52", "mf61"])  # MF6.2 has no closed form
def test_quadratic_stiffness_of_zero_is_the_limit(sheet, model, values, seed, random_rows):
    assert_agrees(sheet, model, values | {"Q_FZ2": 0.0}, random_rows(values, 200, seed + 300))


@pytest.mark.parametrize("mode", MODES)
def test_off_the_ground(sheet, model, values, seed, random_rows, mode):
    """A negative load is treated as no load; without turn slip all results are defined."""
    rows = random_rows(values, 200, seed + 100)
    rows["Fz"] = np.resize([0.0, -500.0], 200)
    wrong, without, _ = compare(sheet, model, values, rows, **mode)
    assert wrong == {}
    rest = rows["V"] == 0
    for name, where in without.items():
        assert name in NO_VALUE_AT_NO_LOAD | NO_VALUE_AT_REST, name
        assert (rows["phit"][where] != 0).all()
        assert name in NO_VALUE_AT_NO_LOAD or rest[where].all()
