"""The declarations agree with the contract. Names that resemble a channel are recognized, others are not."""

import pytest

from tirefmu.boundary.errors import UnknownName
from tirefmu.measurements import CHANNELS, INPUTS, OUTPUTS, channel, to_si
from tirefmu.measurements.column_names import intended_channel, unit_in_name
from tirefmu.symbolic import quantities
from tirefmu.symbolic.declarations import Quantity
from tirefmu.tires import SIGNS, TABLE_INPUTS, TABLE_OUTPUTS


def test_declarations_are_the_columns_of_the_contract():
    assert tuple(CHANNELS) == INPUTS + OUTPUTS == TABLE_INPUTS + TABLE_OUTPUTS


def test_every_channel_has_a_random_stream_of_its_own():
    assert sorted(declared.stream for declared in CHANNELS.values()) == list(range(len(CHANNELS)))


def test_what_changes_signs_is_a_convention_or_the_mirror():
    assert {change for declared in CHANNELS.values() for change in declared.reversed_in} <= {*SIGNS[1:], "mirror"}


@pytest.mark.parametrize("name", CHANNELS)
def test_each_declaration_is_in_si_and_complete(name):
    declared = channel(name)
    assert to_si([1.0, 300.0], declared.unit, declared.quantity).tolist() == [1.0, 300.0]
    assert declared.meaning
    assert declared.limits[0] < declared.limits[1]


def test_a_quantity_of_the_equations_has_the_unit_of_its_channel():
    """Printed code spells deg C without the blank."""
    declared = [each for each in vars(quantities).values() if isinstance(each, Quantity) and each.name in CHANNELS]
    assert {each.name for each in declared} >= {"kappa", "alpha", "Fz", "T", "Fy"}
    for each in declared:
        assert each.unit.replace("degC", "deg C") == CHANNELS[each.name].unit


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
        ("SlipAngleFL", "alpha"), ("Alpha_L1", "alpha"), ("Fy_rr", "Fy"), ("Fz_R2 [kN]", "Fz"), ("GammaLF", "gamma"),
        ("SlipAngle_deg", "alpha"), ("slip angle deg", "alpha"), ("alpha_raw", "alpha"),
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
