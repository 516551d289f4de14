"""The Trento report's section 4: "coefficients ... in the worst conditions for each case".

It names neither load nor camber. The column FX0 is the tire at 1120 N and 4 deg, the columns FY0 and MZ0 at
1120 N and 5 deg, all at zero slip: E_x, E_y and E_t (through the shifted slip), alpha_r and alpha_t show this.
"""

from __future__ import annotations

from decimal import ROUND_DOWN, Decimal

import numpy as np
import pandas as pd
import pytest

from tirefmu.tires import published

FX0_COLUMN = {"B_x": "14.77", "D_x": "2.167e3", "E_x": "0.2788", "S_Vx": "-213.4", "S_Hx": "0.0043", "mu_x": "1.9347"}
FY0_COLUMN = {
    "B_y": "11.31", "C_y": "1.135", "E_y": "0.9474", "S_Hy": "0.0038",
    "mu_y": "2.3724",  # printed as mu_x
    "D_y": "2.657e3",  # printed as 2.567e3: two digits changed places; it is 2657.12
}  # fmt: skip
MZ0_COLUMN = {
    "B_t": "1.4916", "D_t": "0.041", "E_t": "-0.1087", "alpha_r": "0.0052", "alpha_t": "-0.0426",
    "B_r": "-4.436",  # printed as -4.434: a misprint; it is -4.4359
}  # fmt: skip
#: The report truncated these instead of rounding them: 1.5387, 47.9998, 4.9995, 48.1451.
CUT_OFF = {"C_x": "1.538", "S_Vy": "47.99", "C_t": "4.999", "D_r": "48.14"}


@pytest.fixture(scope="module")
def at_zero_slip():
    conditions = pd.DataFrame(
        {"kappa": 0.0, "alpha": 0.0, "gamma": np.radians([4.0, 5.0]), "Fz": 1120.0}, index=["4 deg", "5 deg"]
    )
    return published("trento_hoosier").evaluate(conditions, signs="adapted-sae")


@pytest.mark.parametrize(
    ("camber", "name", "printed"),
    [("4 deg", *item) for item in FX0_COLUMN.items()]
    + [("5 deg", *item) for item in [*FY0_COLUMN.items(), *MZ0_COLUMN.items()]],
)
def test_rounded_to_the_printed_digits(at_zero_slip, camber, name, printed):
    half_a_unit = 0.5 * 10.0 ** Decimal(printed).as_tuple().exponent
    assert abs(at_zero_slip.loc[camber, name] - float(printed)) <= half_a_unit


@pytest.mark.parametrize(("name", "printed"), CUT_OFF.items())
def test_cut_off_after_the_printed_digits(at_zero_slip, name, printed):
    value = Decimal(at_zero_slip.loc["4 deg" if name == "C_x" else "5 deg", name])
    assert value.quantize(Decimal(printed), ROUND_DOWN) == Decimal(printed)


def test_the_misprints(at_zero_slip):
    at_5_deg = at_zero_slip.loc["5 deg"]
    assert round(at_5_deg["D_y"], 2) == 2657.12
    assert round(at_5_deg["B_r"], 4) == -4.4359
    assert round(at_5_deg["mu_x"], 4) == 1.8273  # not the 2.3724 printed with this name
