"""Units in SI base exponents."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from tirefmu.fmu.description.units import FACTORS, base_unit


@pytest.mark.parametrize(
    ("unit", "expected"),
    [
        ("1", {}),
        ("N", {"kg": 1, "m": 1, "s": -2}),
        ("N m", {"kg": 1, "m": 2, "s": -2}),
        ("N/rad", {"kg": 1, "m": 1, "s": -2, "rad": -1}),
        ("1/rad^2", {"rad": -2}),
        ("Pa", {"kg": 1, "m": -1, "s": -2}),
        ("1/Pa", {"kg": -1, "m": 1, "s": 2}),
        ("m/s", {"m": 1, "s": -1}),
        ("N/m", {"kg": 1, "s": -2}),
        ("m/m", {}),
        ("deg C", {"K": 1, "offset": 273.15}),
    ],
)
def test_known_units(unit, expected):
    assert base_unit(unit) == expected


@given(st.sampled_from(sorted(FACTORS)), st.sampled_from(sorted(FACTORS)), st.integers(1, 4))
def test_a_product_divided_by_itself_is_one(a, b, power):
    product = f"{a}^{power} {b}"
    assert base_unit(f"{product}/{product}") == {}
    assert base_unit(f"1/{product}") == {name: -n for name, n in base_unit(product).items()}
