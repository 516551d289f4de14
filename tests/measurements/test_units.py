"""Units are converted to SI, and anything else is rejected."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from tirefmu.boundary.errors import DataError, UnknownName
from tirefmu.measurements import UNITS, to_si, unit_named


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
