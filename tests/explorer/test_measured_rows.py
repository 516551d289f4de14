"""The measured rows of a page: every row of a condition once, at most as many as a page can draw."""

from __future__ import annotations

import base64
from math import radians

import numpy as np
import pytest

from tirefmu.applications.explorer.measured_rows import MIN_ROWS, measured_rows, rows_data
from tirefmu.measurements import Noise, Recording, VirtualBench, alpha_sweeps, exclude_rows
from tirefmu.tires import published

INPUTS = ("kappa", "alpha", "gamma", "Fz")


@pytest.fixture(scope="module")
def bench():
    tire = published("trento_hoosier")
    return VirtualBench(tire, Noise.none()).run(alpha_sweeps([440.0, 900.0], [0.0, radians(3.0)], sample_rate=8.0))


def test_each_included_row_is_in_one_condition(bench):
    found = measured_rows([bench], INPUTS)
    rows = sorted(index for condition in found for index in condition.table.index)
    assert rows == np.flatnonzero(exclude_rows(bench).included).tolist()
    assert [round(condition.levels["Fz"], -1) for condition in found].count(900.0) == 2
    iso = bench.with_signs("iso").table
    for condition in found:
        assert f"{len(condition.table)} rows" in condition.title
        assert (condition.table["Fy"] == iso.loc[condition.table.index, "Fy"]).all()


def test_conditions_with_few_rows_are_not_listed(bench):
    """A condition of a second recording is cut to the least number of rows, and to one less."""
    largest = measured_rows([bench], INPUTS)[0].table.index
    for count, listed in ((MIN_ROWS, 1), (MIN_ROWS - 1, 0)):
        part = Recording(bench.table.loc[largest[:count]].reset_index(drop=True), bench.signs, "part")
        assert len(measured_rows([part], INPUTS)) == listed


@pytest.mark.parametrize("most", [10**6, 100])
def test_columns_are_those_rows_as_floats(bench, most):
    conditions = measured_rows([bench], INPUTS)
    data = rows_data(conditions, most)
    assert data["total"] == sum(len(condition.table) for condition in conditions)
    assert sum(drawn["rows"] for drawn in data["conditions"]) <= most
    for drawn, condition in zip(data["conditions"], conditions, strict=True):
        for name, text in drawn["columns"].items():
            values = np.frombuffer(base64.b64decode(text), dtype="<f4")
            assert len(values) == drawn["rows"]
            assert set(values) <= set(condition.table[name].to_numpy(dtype="<f4"))
            if most > data["total"]:
                np.testing.assert_array_equal(values, condition.table[name].to_numpy(dtype="<f4"))
