"""Results of the Trento worksheet: every column, in every language and sign convention."""

from __future__ import annotations

import json

import numpy as np
import pandas as pd
import pytest

from tirefmu.tires import Tire, convert_signs, published

#: Columns of the worksheet and names of tirefmu.
COLUMNS = {
    "kappa__x": "kappa_x", "Bx": "B_x", "Cx": "C_x", "Dx": "D_x", "Ex": "E_x", "SVx": "S_Vx", "Kxk": "K_xkappa",
    "SHx": "S_Hx", "mu__x": "mu_x", "alpha__y": "alpha_y", "By": "B_y", "Cy": "C_y", "Dy": "D_y", "Ey": "E_y",
    "SVy": "S_Vy", "Kya": "K_yalpha", "SHy": "S_Hy", "mu__y": "mu_y", "Br": "B_r", "Bt": "B_t", "Ct": "C_t",
    "Dr": "D_r", "Dt": "D_t", "Et": "E_t", "alpha__r": "alpha_r", "alpha__t": "alpha_t", "Gxa": "G_xa",
    "Gyk": "G_yk", "SVyk": "S_Vyk", "FX0": "F_x0", "FY0": "F_y0", "MZ0": "M_z0", "FX": "Fx", "FY": "Fy",
    "Gxa_from_FX": "G_xa", "Gyk_from_FY": "G_yk", "CorneringStiffness_x": "F_x0_slope",
    "CorneringStiffness_y": "F_y0_slope", "FX0_vec": "F_x0", "Kxk_vec": "K_xkappa", "FY0_vec": "F_y0",
    "Kya_vec": "K_yalpha", "MZ0_vec": "M_z0", "FX_vec": "Fx", "FY_vec": "Fy",
}  # fmt: skip
INPUTS = ["kappa", "alpha", "gamma", "Fz"]


@pytest.fixture(scope="module")
def rows(golden) -> pd.DataFrame:
    return pd.read_csv(golden / "mf96_trento.csv.xz")


@pytest.fixture(scope="module")
def worksheet_tire(golden) -> Tire:
    names = {"FZ0": "FNOMIN", "R0": "UNLOADED_RADIUS"}
    parameters = json.loads((golden / "mf96_trento_params.json").read_text(encoding="utf-8"))
    values = {names.get(key, key.upper()): value for key, value in parameters.items()}
    return Tire("mf96", values, signs="adapted-sae")


def largest_error(ours: pd.DataFrame, theirs: pd.DataFrame) -> float:
    """Return the largest |error| / (1 + |reference|) over all columns; NaN where any number is NaN."""
    reference = theirs[list(COLUMNS)].to_numpy()
    return float(np.max(np.abs(ours[list(COLUMNS.values())].to_numpy() - reference) / (1 + np.abs(reference))))


def test_nan_is_a_difference(rows, worksheet_tire):
    ours = worksheet_tire.evaluate(rows[INPUTS], signs="adapted-sae")
    ours.loc[7, "B_t"] = np.nan
    assert not largest_error(ours, rows) < 1e-9


def test_every_column_is_compared(rows):
    assert set(rows.columns) == {"id", "block", *INPUTS, *COLUMNS}
    assert len(rows) == 600


@pytest.mark.parametrize("code", ["numpy", "c", "casadi"])
def test_every_column_from_every_language(rows, worksheet_tire, code):
    ours = worksheet_tire.evaluate(rows[INPUTS], signs="adapted-sae", code=code)
    assert largest_error(ours, rows) < 1e-9


def test_a_bench_table_in_sae(rows, worksheet_tire):
    bench = convert_signs(rows[INPUTS], "adapted-sae", "sae")
    assert (bench["Fz"] < 0).all()
    answer = worksheet_tire.in_signs("iso").evaluate(bench, signs="sae")
    # Forces and inputs are returned in sae; the named quantities are those of the formula in adapted SAE.
    assert largest_error(convert_signs(answer, "sae", "adapted-sae"), rows) < 1e-9
    pd.testing.assert_frame_equal(answer[INPUTS], bench)


def test_the_published_tire_has_these_parameters_to_the_bit(worksheet_tire):
    tire = published("trento_hoosier")
    assert {name: value.hex() for name, value in tire.values.items()} == {
        name: value.hex() for name, value in worksheet_tire.values.items()
    }
    assert tire.signs == "adapted-sae"
    assert worksheet_tire.defaulted == ("LS", "SSZ1", "SSZ2", "SSZ3", "SSZ4")  # the worksheet has no combined Mz
