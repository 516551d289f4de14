"""Inputs in another unit or sign and loads far beyond a tire are refused, one number or an array alike."""

from __future__ import annotations

import numpy as np
import pandas as pd
import pytest

from tirefmu import draw, evaluate
from tirefmu.boundary.errors import DataError, TirefmuError, WrongType
from tirefmu.measurements import Recording
from tirefmu.tires import Tire, published

TIRE = published("trento_hoosier").in_signs("iso")
MANY = np.linspace(-1.0, 1.0, 49)
WRONG = {
    "degrees": ({"alpha": 12.0 * MANY}, "alpha from -12 to 12 .*in degrees"),
    "camber in degrees": ({"gamma": np.array([0.0, 2.0, 4.0])}, "gamma from 0 to 4 .*in degrees"),
    "percent": ({"kappa": 20.0 * MANY}, "kappa from -20 to 20 .*in percent"),
    "km/h": ({"V": [0.0, 200.0]}, "V from 0 to 200 .*36 km/h is 10"),
    "one of many rows": ({"alpha": np.append(0.1 * MANY, 5.0)}, "alpha from -0.1 to 5"),
    "far load": ({"Fz": np.array([900.0, 90e3])}, "Fz from 900 to 90000 N is far beyond .* 6100 N, 5 times FZMAX"),
}


@pytest.mark.parametrize("kind", WRONG)
@pytest.mark.parametrize("shape", [np.asarray, lambda x: np.asarray(x)[:, None], list, pd.Series])
def test_wrong_units_are_refused_in_every_form(kind, shape):
    given, message = WRONG[kind]
    with pytest.raises(TirefmuError, match=message):
        TIRE.forces(**{name: shape(values) for name, values in given.items()})
    for function in (TIRE.evaluate, lambda table: evaluate(TIRE, table)):
        with pytest.raises(TirefmuError) as caught:
            function(pd.DataFrame(given).assign(**({} if "Fz" in given else {"Fz": 900.0})))
        assert "\n" not in str(caught.value)


@pytest.mark.parametrize("name", ["alpha", "gamma", "kappa", "Fz", "V"])
def test_a_number_and_an_array_have_one_rule(name):
    for value in (-11.0, -5.0, -1.6, -1.0, 0.5, 1.0, 1.5, 5.0, 200.0, 1e4):
        outcomes = []
        for given in (value, np.array([value]), [[value]] * 30):
            try:
                TIRE.forces(**{name: given})
                outcomes.append("")
            except (TirefmuError, UserWarning) as answer:
                outcomes.append(str(answer))
        assert len(set(outcomes)) == 1, outcomes


PERCENT = ([0.0, 2.0, 5.0, 8.0], np.linspace(0.0, 10.0, 21), 10.0 * MANY, [-4.0, -8.0, np.nan], -5.0, 9.0)


@pytest.mark.parametrize("given", PERCENT, ids=str)
def test_slips_that_are_probably_in_percent_are_evaluated_with_a_warning(given):
    """They may be those of a wheel that spins, which no number tells."""
    with pytest.warns(UserWarning, match=r"kappa .* is that of a wheel that spins: .*in percent\?") as caught:
        forces = TIRE.forces(kappa=given)["Fx"]
    assert [warning.filename for warning in caught] == [__file__]
    rows = pd.DataFrame({"kappa": np.atleast_1d(given)[np.isfinite(np.atleast_1d(given))]})
    for table in (rows, Recording(rows, "iso", "a.csv")):
        with pytest.warns(UserWarning, match="in percent") as caught:
            result = TIRE.evaluate(table)
        assert [warning.filename for warning in caught] == [__file__]
        np.testing.assert_allclose(result["Fx"], np.atleast_1d(forces)[: len(rows)], rtol=1e-12)
    TIRE.evaluate(Recording(rows, "iso", "a.csv", {"declared": "kappa"}))


def test_pressures_that_are_not_in_pascal_are_refused():
    tire = published("unicamp_small_tire")
    for pressure in (2.0, 83.0, np.full(30, 200.0)):
        with pytest.raises(TirefmuError, match="it is in Pa"):
            tire.forces(alpha=0.1, p=pressure)
    assert np.isfinite(tire.forces(alpha=0.1, p=[0.0, 2e5])["Fy"]).all()


def test_loads_of_the_wrong_sign_are_refused():
    with pytest.raises(TirefmuError, match="positive where the wheel is pressed to the road"):
        TIRE.forces(alpha=np.full(5, 0.1), Fz=np.full(5, -900.0))
    table = pd.DataFrame({"alpha": 0.1, "Fz": np.full(5, -900.0)})
    with pytest.raises(DataError, match="Fz is negative in 100 % of the rows: signs='sae'"):
        TIRE.evaluate(table)
    with pytest.raises(DataError, match="Fz is positive in 100 % of the rows"):
        TIRE.evaluate(table.assign(Fz=900.0), signs="sae")
    assert len(TIRE.evaluate(table, signs="sae")) == 5


def test_shapes_and_types_that_do_not_fit_are_our_errors():
    with pytest.raises(TirefmuError, match=r"do not broadcast: alpha \(3,\), Fz \(2,\)"):
        TIRE.forces(alpha=[0.1, 0.2, 0.3], Fz=[500.0, 900.0])
    dates, texts = pd.to_datetime(["2020-01-01"]), np.array(["0.1"])
    no_numbers = ("abc", "0.1", [[0.1], [0.1, 0.2]], np.array([0.1 + 1j]), object(), None, True, [0.1, "0.2"])
    for given in (*no_numbers, dates, texts, texts.astype(object), np.array([True])):
        with pytest.raises(WrongType, match="alpha is"):
            TIRE.forces(alpha=given)


def test_masked_and_missing_values_are_nan_and_integers_are_numbers():
    expected = TIRE.forces(alpha=[0.1, np.nan], Fz=900.0)["Fy"]
    nullable = pd.Series([0.1, None], dtype="Float64")
    for given in (np.ma.masked_array([0.1, 0.5], [False, True]), nullable, [0.1, None], np.array([0.1, np.nan], "f4")):
        np.testing.assert_allclose(TIRE.forces(alpha=given, Fz=900)["Fy"], expected, rtol=1e-5)
    loads = (np.int16([900]), np.ma.masked_array([900], [False]), pd.Series([900], index=["x"]), np.array(900))
    for given in loads:
        assert TIRE.forces(alpha=0.1, Fz=given)["Fy"].item() == expected[0]


@pytest.mark.parametrize("header", ["alpha [deg]", "alpha (deg)", "alpha[rad]"])
def test_a_unit_in_a_header_is_read_or_refused(header):
    """Another column is ignored: the slip angle would be zero."""
    with pytest.raises(DataError, match="is not alpha: the columns are in SI units and have plain names"):
        TIRE.evaluate(pd.DataFrame({header: [0.0, 5.0], "Fz": 900.0}))
    both = pd.DataFrame({"alpha": [0.0, np.radians(5.0)], "Fz": 900.0})
    assert TIRE.evaluate(both.assign(**{header: 0.0}))["Fy"].iloc[1] < -100.0


def test_a_table_with_units_is_evaluated_in_them():
    plain = pd.DataFrame({"alpha": np.radians([-5.0, 5.0]), "Fz": 900.0})
    written = pd.DataFrame({"alpha [deg]": [-5, 5], "Fz [kN]": 0.9})
    np.testing.assert_allclose(evaluate(TIRE, written)["Fy"], evaluate(TIRE, plain)["Fy"], rtol=1e-12)


def test_a_channel_that_occurs_twice_is_refused():
    twice = pd.DataFrame([[0.0, 0.1, 900.0]], columns=["alpha", "alpha", "Fz"])
    for function in (TIRE.evaluate, lambda table: evaluate(TIRE, table)):
        with pytest.raises(DataError, match="column 'alpha' occurs more than once"):
            function(twice)


def test_what_a_simulation_needs_is_accepted():
    assert not TIRE.forces(kappa=[0.1, 9.0], Fz=0.0)["Fx"].any()
    for spinning in ([-1.0, -1.6, -1.8], 1.5, [0.5, 3.0, 1.2]):  # backwards, or in the first gear
        assert np.isfinite(TIRE.forces(kappa=spinning)["Fx"]).all()
    assert np.isfinite(TIRE.forces(kappa=np.array([-1.0, 0.0, 10.0]), V=[0.0, -3.0, 80.0])["Fx"]).all()
    np.testing.assert_array_equal(np.isnan(TIRE.forces(alpha=[0.1, np.nan])["Fy"]), [False, True])
    lifted = pd.DataFrame({"alpha": 0.1, "Fz": [900.0, 400.0, -3.0]})  # noise of a load cell
    assert TIRE.evaluate(lifted)["Fy"].iloc[2] == 0.0
    spin = Recording(pd.DataFrame({"alpha": [0.1, 2.0], "Fz": 900.0}), "iso", "spin.csv", {"declared": "alpha"})
    assert np.isfinite(TIRE.evaluate(spin)["Fy"]).all()


def test_a_load_beyond_the_range_is_evaluated_and_a_far_one_is_not(tmp_path):
    assert np.isfinite(TIRE.forces(alpha=0.1, Fz=[1220.0, 6100.0])["Fy"]).all()
    with pytest.raises(TirefmuError, match="far beyond the loads of this tire"):
        draw(TIRE, tmp_path, loads=[90e3])
    assert not list(tmp_path.iterdir())


def test_the_convention_of_a_recording_is_its_own():
    recording = Recording(pd.DataFrame({"alpha": [0.1], "Fz": [-900.0]}), "sae", "run.csv")
    with pytest.raises(DataError, match="the recording is in sae signs, not iso"):
        TIRE.evaluate(recording, signs="iso")
    with pytest.raises(WrongType, match=r"tirefmu\.evaluate takes a path"):
        TIRE.evaluate("run.csv")


@pytest.mark.parametrize("name", ["SA", "Alpha", "alpha_deg", "slip_angle", "Slip Angle", "alpha (deg)"])
def test_an_input_under_another_name_is_not_ignored(name):
    with pytest.raises(DataError, match=r"is not alpha: the columns are in SI units and have plain names"):
        TIRE.evaluate(pd.DataFrame({name: [5.0], "Fz": 900.0}))
    TIRE.evaluate(pd.DataFrame({name: [5.0], "alpha": 0.1, "Fz": 900.0}))
    TIRE.evaluate(TIRE.evaluate(pd.DataFrame({"alpha": [0.1], "Fz": 900.0})))  # quantities are no inputs


@pytest.mark.parametrize("name", ["t [ms]", "time", "ET"])
def test_a_time_under_another_name_is_not_ignored(name):
    with pytest.raises(DataError, match=r"is not t: "):
        TIRE.evaluate(pd.DataFrame({name: [0.0, 1.0], "alpha": 0.1, "Fz": 900.0}))


def test_time_is_no_temperature():
    warm = Tire("mf96", TIRE.values, effects=TIRE.has | {"temp_friction"})
    assert "T" in warm.inputs
    warm.evaluate(pd.DataFrame({"t": [0.0, 1.0], "alpha": 0.1, "Fz": 900.0}))
