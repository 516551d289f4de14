"""Large Parquet tables are evaluated in parts: same results, same checks, few rows in memory at a time."""

from __future__ import annotations

import json

import numpy as np
import pandas as pd
import pytest

from tirefmu.fmu.comparison import large_check
from tirefmu.measurements import evaluation, large_table, write_table
from tirefmu.measurements.large_table import LargeTable
from tirefmu.tires import Tire, published

pytest.importorskip("pyarrow", reason="Parquet needs pyarrow")
ROWS, PART = 900, 100


@pytest.fixture(autouse=True)
def small(monkeypatch):
    """Let a table of a few hundred rows be large."""
    monkeypatch.setattr(large_table, "LARGE", ROWS)
    monkeypatch.setattr(large_table, "PART", PART)
    monkeypatch.setattr(large_table, "SURVEYED", 300)


@pytest.fixture
def rows():
    """Return a sweep of slip angle with the side force of a tire, in ISO."""
    random = np.random.default_rng(0)
    alpha = 0.2 * np.sin(np.arange(ROWS) / 30.0)
    return pd.DataFrame({
        "alpha": alpha, "kappa": random.uniform(-0.1, 0.1, ROWS), "Fz": random.uniform(500.0, 1100.0, ROWS),
        "Fy": -1500.0 * np.sin(1.4 * np.arctan(10.0 * alpha)), "lap": "first",
    })  # fmt: skip


@pytest.fixture
def evaluated(command, published_tir, tmp_path):
    """Return a function that writes a table, evaluates the tire over it, and returns the outcome and the result."""

    def run(table, *options, name="out.parquet"):
        write_table(table, tmp_path / "in.parquet")
        outcome = command("evaluate", published_tir, tmp_path / "in.parquet", "-o", tmp_path / name, *options)
        path = tmp_path / name
        read = pd.read_csv if path.suffix == ".csv" else pd.read_parquet
        return outcome, read(path) if path.exists() else None

    return run


@pytest.fixture
def counted(monkeypatch):
    """Return the numbers of rows that are evaluated at a time."""
    numbers, evaluate = [], evaluation.Tire.evaluate

    def counting(tire, table, **options):
        numbers.append(len(table))
        return evaluate(tire, table, **options)

    monkeypatch.setattr(evaluation.Tire, "evaluate", counting)
    return numbers


@pytest.mark.parametrize("name", ["out.parquet", "out.csv"])
def test_the_result_is_that_of_the_table_in_memory(evaluated, counted, rows, tmp_path, name, monkeypatch):
    outcome, found = evaluated(rows, "--json", tmp_path / "large.json", name=name)
    assert outcome.status == 0, outcome.err
    assert sum(counted) == ROWS
    assert max(counted) <= PART
    monkeypatch.setattr(large_table, "LARGE", ROWS + 1)
    counted.clear()
    whole, expected = evaluated(rows, "--json", tmp_path / "whole.json", name=name)
    assert counted == [ROWS]
    pd.testing.assert_frame_equal(found, expected, check_exact=True)
    assert outcome.out == whole.out
    assert (tmp_path / "large.json").read_text() == (tmp_path / "whole.json").read_text()


def test_parts_are_those_of_the_file_in_any_order_of_requests(rows, tmp_path):
    """Two readers of one file do not disturb each other: the process reads from the requested row."""
    write_table(rows, tmp_path / "in.parquet")
    table = LargeTable.of(tmp_path / "in.parquet")
    for part, other in zip(table.parts(), table.parts(), strict=True):
        pd.testing.assert_frame_equal(part, other)
    whole = pd.concat(table.parts(), ignore_index=True)
    pd.testing.assert_frame_equal(whole, rows, check_dtype=False)


@pytest.mark.parametrize(("change", "message"), [
    (lambda t: t.assign(alpha=t["alpha"].where(t.index != 700, 12.0)), "in.parquet: alpha reaches 12 rad: in degrees?"),
    (lambda t: t.assign(Fz=t["Fz"].where(t.index != 801, np.nan)), "in.parquet: row 802: Fz is NaN: every row of"),
    (lambda t: t.assign(Fy=t["Fy"].where(t.index != 3, np.inf)), "in.parquet: row 4: Fy is infinite"),
    (lambda t: t.assign(Fz="heavy"), "in.parquet: row 1: column Fz: 'heavy' is not a number"),
])  # fmt: skip
def test_bad_values_anywhere_are_refused_in_one_line(evaluated, rows, tmp_path, change, message):
    outcome, found = evaluated(change(rows))
    assert outcome.status == 2
    assert message in outcome.err
    assert outcome.err.count("\n") == 1
    assert found is None
    assert [path.name for path in tmp_path.iterdir()] == ["in.parquet"]


def test_wrong_signs_are_reported_in_the_same_words(evaluated, rows, tmp_path):
    outcome, _ = evaluated(rows.assign(Fy=-rows["Fy"]), "--json", tmp_path / "out.json")
    (warning,) = json.loads((tmp_path / "out.json").read_text())["warnings"]
    assert warning.startswith(
        "in.parquet: Fy rises with alpha, in iso it falls: the data fit adapted-sae (--signs adapted-sae), or alpha has"
    )
    assert f"warning: {warning}" in outcome.text


def test_units_are_those_of_the_header(evaluated, rows):
    _, expected = evaluated(rows)
    _, found = evaluated(rows.assign(Fz=rows["Fz"] / 1000.0).rename(columns={"Fz": "Fz [kN]"}))
    np.testing.assert_allclose(found["Fy"], expected["Fy"], rtol=1e-12)


def test_rows_that_depend_on_others_are_evaluated_together(evaluated, counted, rows, command, published_tir, tmp_path):
    """Selected rows need the whole table."""
    outcome, found = evaluated(rows, "--where", "Fz > 800")
    assert outcome.status == 0, outcome.err
    assert counted == [int((rows["Fz"] > 800.0).sum())]
    assert len(found) == counted[0]


def test_rows_depend_on_others_through_lags_distance_and_time(rows, tmp_path):
    tire = published("unicamp_small_tire")
    lagging = Tire(tire.model, tire.values, effects=tire.has | {"relax_lat"}, signs=tire.signs)
    write_table(rows, tmp_path / "in.parquet")
    write_table(rows.assign(t=np.arange(ROWS) / 100.0), tmp_path / "timed.parquet")
    untimed, timed = (LargeTable.of(tmp_path / f"{name}.parquet") for name in ("in", "timed"))
    assert untimed.rows_are_independent(lagging)
    assert timed.rows_are_independent(tire)
    assert not timed.rows_are_independent(lagging)
    assert timed.rows_are_independent(lagging, steady=True)


@pytest.fixture
def recorded(rows, tmp_path):
    """Return a file with segments that do not end where the parts do, and rows that were not measured."""
    t = np.arange(ROWS) / 100.0 + 10.0 * (np.arange(ROWS) // 170)
    path = tmp_path / "in.parquet"
    write_table(rows.drop(columns="lap").assign(t=t, Fy=rows["Fy"].where(rows.index >= 2 * PART)), path)
    return path


def test_an_fmu_is_checked_in_parts(command, published_fmu, recorded, tmp_path, monkeypatch):
    sizes, simulate = [], large_check.simulate

    def counting(path, folder, time, inputs, *arguments):
        sizes.append(len(inputs))
        return simulate(path, folder, time, inputs, *arguments)

    monkeypatch.setattr(large_check, "simulate", counting)
    monkeypatch.setattr(large_table, "PART", 3 * PART)
    outcome = command("check", published_fmu, recorded, "--json", tmp_path / "large.json")
    assert sizes == [3 * PART] * 3
    monkeypatch.setattr(large_table, "LARGE", ROWS + 1)
    whole = command("check", published_fmu, recorded, "--json", tmp_path / "whole.json")
    assert len(sizes) == 3
    assert (outcome.status, outcome.out) == (whole.status, whole.out)
    found, expected = (json.loads((tmp_path / f"{name}.json").read_text()) for name in ("large", "whole"))
    assert found["segments"] == 6
    for name in ("rmse", "relative_rmse", "r2", "r2_uncentred"):
        assert found["channels"]["Fy"].pop(name) == pytest.approx(expected["channels"]["Fy"].pop(name), rel=1e-12)
    assert found == expected
