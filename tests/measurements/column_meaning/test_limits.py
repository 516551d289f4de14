"""Impossible values are rejected with one line; unusual but possible values are accepted."""

import numpy as np
import pandas as pd
import pytest

from tirefmu.boundary.errors import DataError
from tirefmu.measurements import Recording, check_plausible


def recording(signs="iso", declared="", **columns) -> Recording:
    return Recording(pd.DataFrame(columns), signs, "a.csv", {"declared": declared})


@pytest.mark.parametrize(
    ("columns", "expected"),
    [
        ({"alpha": [-12.0, 3.0]}, "alpha reaches -12 rad: in degrees? declare it: 'alpha [deg]'"),
        (
            {"alpha": [*np.linspace(-0.2, 0.2, 9), *np.linspace(-11.46, 11.46, 9)]},
            "mixed units? alpha reaches 0.2 rad in the first rows and 11.46 rad from row 10 on",
        ),
        ({"gamma": [0.0, 4.0]}, "gamma reaches 4 rad: in degrees?"),
        (
            {"kappa": [0.0, 2.0, 5.0, 8.0], "Fx": [0.0, 9.0, 9.0, 9.0]},
            "|kappa| is 2 or more in 75 % of the rows, a wheel that spins: in percent?",
        ),
        ({"kappa": [-4.0, 4.0], "Fx": [-1.0, 1.0]}, "backwards: in percent? declare it: 'kappa [%]' (or 'kappa [1]')"),
        ({"kappa": [-15.0, 100.0]}, "kappa reaches 100: in percent? declare it: 'kappa [%]'"),
        ({"Fz": [0.9, 1.1]}, "no |Fz| is above 1.1 N: in kN?"),
        ({"p": [83.0, 84.0]}, "p is about 83.5 Pa: in kPa?"),
        ({"p": [2.2, 2.2]}, "p is about 2.2 Pa: in bar?"),
        ({"p": [12.0, 14.0]}, "p is about 13 Pa: in psi?"),
        ({"p": [-1e4, 1e5]}, "p reaches -1e+04 Pa: in another unit?"),
        ({"V": [200.0]}, "V reaches 200 m/s: in km/h?"),
        ({"T": [330.0]}, "T reaches 330 deg C: in kelvin?"),
        ({"T": [2000.0]}, "T reaches 2000 deg C: in another unit?"),
        ({"T": [-273.15]}, "T reaches -273.1 deg C: in another unit?"),
        ({"Fz": [-900.0] * 98 + [10.0] * 2}, "Fz is negative in 98 % of the rows: SAE signs? (--signs sae)"),
        ({"signs": "adapted-sae", "Fz": [-900.0]}, "Fz is negative in 100 %"),
        ({"signs": "sae", "Fz": [900.0]}, "Fz is positive in 100 % of the rows: not SAE?"),
    ],
)
def test_refused(columns, expected):
    with pytest.raises(DataError) as caught:
        check_plausible(recording(**columns))
    assert str(caught.value).startswith("a.csv: ")
    assert expected in str(caught.value)
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize(
    "columns",
    [
        {"alpha": [-1.4, 1.4], "kappa": [-1.0, 10.0], "gamma": [-0.35, 0.35], "Fz": [1.0, 5000.0]},
        {"Fz": [60.0, 110.0, 160.0], "p": [206843.0] * 3},
        {"Fz": [0.0, 0.0]},
        {"Fz": [60e3], "p": [9e5]},
        {"signs": "sae", "Fz": [-60.0]},
        {"Fz": [-5.0, 400.0, 900.0]},
        {"Fy": [1e7]},
        {"kappa": [-5.0, 5.0]},  # Fx was not measured
        {"T": [-20.0, 130.0], "V": [0.0, 90.0]},
    ],
)
def test_possible(columns):
    check_plausible(recording(**columns))


@pytest.mark.parametrize(("name", "value"), [("alpha", 12.0), ("Fz", 1.0), ("p", 5.0), ("kappa", -4.0)])
def test_a_declared_unit_is_used(name, value):
    check_plausible(recording(declared=name, Fx=[1.0], **{name: [value]}))


def test_declared_unit_does_not_excuse_the_sign():
    with pytest.raises(DataError, match="SAE signs"):
        check_plausible(recording(declared="Fz", Fz=[-900.0]))
