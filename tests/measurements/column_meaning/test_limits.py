"""Impossible values are rejected with one line; unusual but possible values are accepted."""

import numpy as np
import pandas as pd
import pytest

from tirefmu.boundary.errors import DataError, FitError
from tirefmu.estimation.nominal_values import check_nominal, check_radius
from tirefmu.measurements import Recording, check_plausible, read_recording
from tirefmu.measurements.column_meaning.radii import radii
from tirefmu.symbolic.models import model_named


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
        ({"kappa": [-4.0, 4.0], "Fx": [-1.0, 1.0]}, "backwards: in percent? declare it: 'kappa [%]' (or 'kappa [1]')"),
        ({"kappa": [-15.0, 100.0]}, "kappa reaches 100: in percent? declare it: 'kappa [%]'"),
        ({"Fz": [0.9, 1.1]}, "no |Fz| is above 1.1 N: in kN?"),
        ({"Fz": [5e6]}, "Fz reaches 5e+06 N: in another unit?"),
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


# ---------------------------------------------- Radii that a bench file shows, and nominal values that contradict them


@pytest.mark.parametrize(
    ("title", "radius"),
    [("Hoosier 43075 16x7.5-10 LCO, 7 inch rim", 0.2032), ("18.0x6.0-10", 0.2286), ("205/55R16", 0.316), ("R7", None)],
)
def test_the_size_of_a_tire_gives_its_radius(title, radius):
    found = radii(Recording(pd.DataFrame(), "iso", "a", {"tireid": title}))
    assert found == ({} if radius is None else {"size of its tire": pytest.approx(radius, abs=1e-4)})


@pytest.mark.parametrize(("wheel", "loaded", "expected"), [
    (468.5, 21.96, {"loaded radius": 0.2196, "wheel speed": 0.2265}), (0.03, 64178.97, {}), (0.0, np.nan, {})
])  # fmt: skip
def test_unusable_channels_of_a_bench_give_no_radius(tmp_path, wheel, loaded, expected):
    rows = pd.DataFrame({"ET": np.arange(9) / 100.0, "SA": 1.0, "IA": 0.0, "FZ": -900.0, "FY": 1.0, "V": 40.0})
    rows.assign(N=wheel, RL=loaded).to_csv(tmp_path / "a.csv", index=False)
    assert radii(read_recording(tmp_path / "a.csv")) == pytest.approx(expected, abs=1e-4)


def test_nominal_values_that_contradict_the_recordings_are_refused():
    bench = Recording(pd.DataFrame({"Fz": [190.0, 700.0, 1168.0]}), "iso", "a", {"loaded radius": "0.22"})
    check_radius({"R0": 0.23}, [bench])
    check_radius({}, [bench])
    with pytest.raises(FitError, match=r"R0 = 0.46 m contradicts a: 0.22 m by the loaded radius"):
        check_radius({"R0": 0.46}, [bench])
    model = model_named("mf96")
    check_nominal({"Fz0": 220.0, "R0": 0.23}, model, [bench.table])
    with pytest.raises(FitError, match=r"Fz0 = 3600 N is far outside the tested loads, 200.2 to 1159 N"):
        check_nominal({"Fz0": 3600.0, "R0": 0.23}, model, [bench.table])
