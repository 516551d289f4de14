"""The declarations agree with the contract. Names that resemble a channel are recognized, others are not."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from tirefmu.boundary.errors import DataError, UnknownName
from tirefmu.measurements.channels import CHANNELS, INPUTS, OUTPUTS, channel
from tirefmu.measurements.column_names import intended_channel, unit_in_name
from tirefmu.measurements.units import UNITS, to_si, unit_named
from tirefmu.tires import TABLE_INPUTS, TABLE_OUTPUTS


def test_declarations_are_the_columns_of_the_contract():
    assert set(INPUTS) == set(TABLE_INPUTS)
    assert set(OUTPUTS) == set(TABLE_OUTPUTS)
    assert tuple(CHANNELS) == INPUTS + OUTPUTS


@pytest.mark.parametrize("name", CHANNELS)
def test_each_declaration_is_in_si_and_complete(name):
    declared = channel(name)
    assert to_si([1.0, 300.0], declared.unit, declared.quantity).tolist() == [1.0, 300.0]
    assert declared.meaning
    assert declared.limits[0] < declared.limits[1]


def test_no_alias_means_two_channels():
    aliases = [alias for declared in CHANNELS.values() for alias in {*declared.bench_names, *declared.aliases}]
    assert len(aliases) == len(set(aliases))


@pytest.mark.parametrize(
    ("column", "expected"),
    [
        ("ALPHA", "alpha"), ("aplha", "alpha"), ("alphas", "alpha"), ("gama", "gamma"), ("kapa", "kappa"),
        ("SA", "alpha"), ("SL", "kappa"), ("FZ", "Fz"), ("ET", "t"), ("TSTC", "T"), ("AMBTMP", "T_ambient"),
        ("RST", "T_road"), ("ambient temperature", "T_ambient"), ("slip angle", "alpha"),
        ("Camber", "gamma"), ("p_kPa", "p"), ("alpha (deg)", "alpha"), ("slip_angle_deg", "alpha"),
        ("Fz kN", "Fz"), ("FY", "Fy"), ("alpha [de[g]", "alpha"), ("Alpha\x1b[2J", "alpha"), ("load [kN] raw", "Fz"),
        ("SlipAngle", "alpha"), ("slipAngle", "alpha"), ("SLIP_ANGLE", "alpha"), ("SlipAngel", "alpha"), 
        ("Slip-Angle", "alpha"),
        ("SlipAngleFL", "alpha"), ("SlipAngle_deg", "alpha"), ("slip angle deg", "alpha"), ("alpha_raw", "alpha"),
        ("SlipRatio", "kappa"), ("CamberAngle", "gamma"), ("Preassure", "p"), ("InflationPressure", "p"),
        ("VerticalLoad", "Fz"), ("F_z", "Fz"), ("NormalForce", "Fz"), ("LateralForce", "Fy"), ("AligningMoment", "Mz"),
        ("TreadTemperature", "T"), ("road speed", "V"), ("Time", "t"),
    ],
)  # fmt: skip
def test_meant(column, expected):
    assert intended_channel(column) == expected


@pytest.mark.parametrize(
    "column",
    ["alpha_y", "kappa_x", "alpha__y", "Fz_in", "kappa_in", "p_in", "Et", "Vx", "F_x0", "mu_x", "rho", "2a",
     "id", "SR", "N", "B_x", "sigma_y", "kind", "remark", "Fz0", "", "_", "Re", "lap [1]", "slide",
     "rolling", "alpha_star", "wheel_speed", "load_ratio", "speed_sum", "tire"],
)  # fmt: skip
def test_not_meant(column):
    assert intended_channel(column) is None


@pytest.mark.parametrize("name", ["kappa", "alpha", "gamma", "phit"])
def test_every_single_typing_error_is_recognized(name):
    for at in range(len(name)):
        left, right = name[:at], name[at:]
        for misspelled in (
            left + right[1:],
            left + "w" + right,
            left + "w" + right[1:],
            left + right[1::-1] + right[2:],
        ):
            assert intended_channel(misspelled) == name


def test_unknown_channel():
    with pytest.raises(UnknownName, match="unknown channel 'gama': did you mean gamma"):
        channel("gama")


def test_the_unit_must_fit_the_channel():
    assert unit_in_name("gamma_deg") == ("gamma", "deg")
    assert unit_in_name("gamma_kPa") is None


# ------------------------------------------------------------ Units are converted to SI, and anything else is rejected


@pytest.mark.parametrize(
    ("value", "unit", "expected"),
    [
        (180.0, "deg", np.pi), (36.0, "kph", 10.0), (36.0, "km/h", 10.0), (25.0, "mph", 11.176), (2.2, "bar", 2.2e5),
        (10.0, "ft-lb", 13.5582), (212.0, "deg F", 100.0), (300.0, "K", 26.85), (12.0, "%", 0.12),
        (2.54, "cm", 0.0254), (60.0, "rpm", 2.0 * np.pi),
    ],
)  # fmt: skip
def test_known_values(value, unit, expected):
    assert to_si(value, unit) == pytest.approx(expected, rel=1e-5)


@pytest.mark.parametrize(
    ("unit", "exact"),
    [("kgf", 9.80665), ("lbf", 0.45359237 * 9.80665), ("psi", 0.45359237 * 9.80665 / 0.0254**2), ("in", 0.0254)],
)
def test_units_that_a_standard_defines_are_exact(unit, exact):
    """ISO 80000-4: the kilogram-force is the weight of 1 kg at 9.80665 m/s^2; the pound is 0.45359237 kg."""
    assert to_si(1.0, unit) == pytest.approx(exact, rel=1e-12)


@given(value=st.floats(-1e6, 1e6), spelling=st.sampled_from(sorted(UNITS)))
def test_conversion_can_be_undone(value, spelling):
    unit = unit_named(spelling)
    back = (to_si(value, spelling) - unit.offset) / unit.factor
    assert back == pytest.approx(value, rel=1e-12, abs=1e-9)


@given(value=st.floats(allow_nan=False))
@pytest.mark.parametrize("spelling", ["N", "rad", "Pa", "m/s", "sec", "none", "deg C", "N-m", "1/m"])
def test_si_values_are_unchanged_to_the_bit(value, spelling):
    assert to_si(value, spelling) == value


def test_spelling_does_not_matter():
    assert unit_named(" FT-LB ") == unit_named("ftlb") == unit_named("lb ft")
    assert unit_named("\u00b0C") == unit_named("deg C")


def test_an_unknown_unit_suggests_the_nearest():
    with pytest.raises(UnknownName, match="unknown unit 'kPas': did you mean kpa"):
        unit_named("kPas")


def test_a_unit_of_another_quantity_is_rejected():
    with pytest.raises(DataError, match="'kPa' measures pressure, not angle"):
        to_si([1.0], "kPa", "angle")


def test_a_value_that_is_too_large_in_si_is_an_error():
    assert np.isinf(to_si([np.inf], "kN")).all()
    with pytest.raises(DataError, match="a value in kN is too large"):
        to_si([1.0, 1e307], "kN")
