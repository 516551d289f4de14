"""Sign conventions of tables."""

from __future__ import annotations

import itertools

import pandas as pd
import pytest

from tirefmu.boundary.errors import UnknownName
from tirefmu.tires import SIGNS, TABLE_INPUTS, TABLE_OUTPUTS, convert_signs
from tirefmu.tires.signs import reversed_columns

PAIRS = list(itertools.product(SIGNS, SIGNS))


@pytest.fixture
def table():
    columns = [*TABLE_INPUTS, *TABLE_OUTPUTS, "remark"]
    return pd.DataFrame({name: [i + 1.0, -i - 2.0] for i, name in enumerate(columns)})


def test_the_contract():
    assert reversed_columns("adapted-sae", "iso") == {"Fy", "My", "Mz"}
    assert reversed_columns("sae", "iso") == {"Fy", "My", "Mz", "alpha", "Fz"}


@pytest.mark.parametrize(("source", "target"), PAIRS)
def test_there_and_back(table, source, target):
    there = convert_signs(table, source, target)
    pd.testing.assert_frame_equal(convert_signs(there, target, source), table)
    pd.testing.assert_frame_equal(abs(there), abs(table))
    assert list(there) == list(table)


@pytest.mark.parametrize(("source", "target"), PAIRS)
def test_by_way_of_a_third(table, source, target):
    for third in SIGNS:
        detour = convert_signs(convert_signs(table, source, third), third, target)
        pd.testing.assert_frame_equal(detour, convert_signs(table, source, target))


def test_missing_columns_are_ignored_and_the_table_is_not_modified(table):
    slips = table[["kappa", "alpha"]]
    turned = convert_signs(slips, "sae", "iso")
    assert turned["alpha"].tolist() == (-slips["alpha"]).tolist()
    assert turned["kappa"].tolist() == slips["kappa"].tolist()
    pd.testing.assert_frame_equal(slips, table[["kappa", "alpha"]])


@pytest.mark.parametrize(("source", "target"), [("din", "iso"), ("iso", "ISO")])
def test_unknown_conventions(table, source, target):
    with pytest.raises(UnknownName, match="unknown sign convention"):
        convert_signs(table, source, target)
