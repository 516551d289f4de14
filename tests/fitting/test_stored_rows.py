"""Rows that stay in a file: the problem and the fit are those of rows in memory, and few rows are read at a time."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pandas as pd
import pytest

from tirefmu.fitting import fit
from tirefmu.fitting.data import fit_data, stored_recording
from tirefmu.fitting.data.fit_data import prepare
from tirefmu.fitting.evidence.uncertainty import sandwich, uncertainty
from tirefmu.fitting.problem import rows as rows_module
from tirefmu.fitting.problem import weighted_residuals
from tirefmu.fitting.problem.loss import LOSSES
from tirefmu.fitting.problem.rows import Rows, StoredRows
from tirefmu.fitting.problem.weighted_residuals import Problem
from tirefmu.fitting.problem.weights import equal_weights, limits_of, noise_weights
from tirefmu.fitting.solvers.convergence import noise_of
from tirefmu.fitting.stage_rows import ranges_of
from tirefmu.fitting.stage_solution import sampled
from tirefmu.measurements import VirtualBench, alpha_sweeps, concatenate, large_table, read_recording, write_table
from tirefmu.measurements.large_table import LargeTable
from tirefmu.symbolic.errors import DataError, FitError
from tirefmu.symbolic.models import model

from .known_tires import NOMINAL, known_tire, recorded

FREE = ("PCY1", "PDY1", "PDY2", "PKY1", "PKY2", "PHY1", "PVY1", "PCX1", "PKX1")
#: Rows of a part of the file in these tests.
PART = 1500


@pytest.fixture(scope="module")
def rows():
    """Return two recordings in which one row in ten has no side force."""
    tables = [recorded(known_tire("mf96"), n, seed=n).with_signs("adapted-sae").table for n in (4000, 2500)]
    each = [Rows.of(table, known_tire("mf96"), ["Fx", "Fy"]) for table in tables]
    measured = np.concatenate([part.measured for part in each])
    measured[::10, 1] = np.nan
    group = np.repeat([0, 1], [len(part) for part in each])
    weight = np.random.default_rng(0).uniform(0.5, 1.5, len(group))
    return Rows(np.concatenate([part.inputs for part in each], axis=1), measured, group, np.arange(len(group)) // 700,
                weight)  # fmt: skip


def problem_of(rows, loss="squares"):
    tire = known_tire("mf96")
    scale = np.array([max(abs(tire.values[name]), 0.1) for name in FREE])
    start = np.array([tire.values[name] for name in FREE]) / scale
    problem = Problem(tire, rows, FREE, equal_weights(rows), scale, LOSSES[loss])
    problem.weights = noise_weights(problem, start)
    problem.limits = limits_of(problem, start)
    return problem, start * 1.03


def stored(rows, survey=None):
    """Return rows as if they were in a file that is read in parts of `PART` rows."""

    def parts(number):
        own = np.flatnonzero(rows.group == number)
        for start in range(0, len(own), PART):
            yield rows.take(own[start : start + PART])

    of = rows if survey is None else rows.take(survey)
    totals = {number: int((rows.group == number).sum()) for number in (0, 1)}
    return StoredRows(of.inputs, of.measured, of.group, of.segment, of.weight, parts=parts, totals=totals, drawn=rows)


@pytest.fixture
def small_blocks(monkeypatch):
    for module in (rows_module, weighted_residuals):
        monkeypatch.setattr(module, "BLOCK", 1000)


def equal(one, other):
    """Compare cost, gradient, matrix, and what intervals are computed from; sums differ in the order of their terms."""
    (problem, x), (second, _) = one, other
    np.testing.assert_allclose(second.weights, problem.weights, rtol=1e-12)
    assert second.cost(x) == pytest.approx(problem.cost(x), rel=1e-12)
    pairs = [
        *zip(problem.derivatives(x), second.derivatives(x), strict=True),
        (problem.residual(x), second.residual(x)),
    ]
    pairs += [*zip(sandwich(problem, x), sandwich(second, x), strict=True), (noise_of(problem, x), noise_of(second, x))]
    for expected, found in pairs:
        np.testing.assert_allclose(found, expected, rtol=1e-9, atol=1e-12 * np.max(np.abs(expected)))


@pytest.mark.parametrize("loss", ["squares", "cauchy"])
def test_blocks_of_rows_have_the_cost_and_the_derivatives_of_all_rows(rows, loss, monkeypatch):
    whole = problem_of(rows, loss)
    reference = whole[0].derivatives(whole[1])
    middle = sandwich(*whole)[1]
    for module in (rows_module, weighted_residuals):
        monkeypatch.setattr(module, "BLOCK", 1000)
    blocks = problem_of(rows, loss)
    for expected, found in zip(
        (*reference, middle), (*blocks[0].derivatives(blocks[1]), sandwich(*blocks)[1]), strict=True
    ):
        np.testing.assert_allclose(found, expected, rtol=1e-9, atol=1e-12 * np.max(np.abs(expected)))


@pytest.mark.parametrize("loss", ["squares", "cauchy"])
def test_rows_in_a_file_are_those_in_memory(rows, loss, small_blocks):
    """Parts end at ends of segments here, so that correlations are the same."""
    aligned = replace(rows, segment=np.concatenate([np.arange(int((rows.group == g).sum())) // PART + 100 * g
                                                    for g in (0, 1)]))  # fmt: skip
    equal(problem_of(aligned, loss), problem_of(stored(aligned), loss))


def test_a_survey_has_the_noise_and_every_row_the_information(rows):
    """A third of the rows of the first recording: the curvature is that of all rows, the noise about the same."""
    survey = np.concatenate([np.arange(1400), np.flatnonzero(rows.group == 1)])
    (whole, x), (some, _) = problem_of(rows), problem_of(stored(rows, survey))
    assert len(some.rows) == len(whole.rows)
    some.weights = whole.weights
    np.testing.assert_allclose(some.derivatives(x)[2], whole.derivatives(x)[2], rtol=1e-9, atol=1e-9)
    half, expected = (np.array(list(uncertainty(problem, x).intervals.values())) for problem in (some, whole))
    np.testing.assert_allclose(half, expected, rtol=0.15)  # the deviation of 1400 residuals is uncertain by 2 %
    np.testing.assert_allclose(noise_of(some, x), noise_of(whole, x), rtol=0.15)
    near = sampled(some, 1500)
    assert near.rows.whole
    assert near.cost(x) == pytest.approx(whole.cost(x), rel=0.1)


@pytest.fixture(scope="module")
def file(tmp_path_factory):
    """Return a file of 12,000 rows of Fx and Fy; the wheel is lifted in 300 of them."""
    recording = recorded(known_tire("mf96"), 12_000)
    table = recording.with_signs("iso").table.drop(columns="Mz")
    table.loc[2000:2299, ["Fz", "Fx", "Fy"]] = [1.0, 0.0, 0.0]
    path = tmp_path_factory.mktemp("stored") / "bench.parquet"
    write_table(table, path)
    return path


@pytest.fixture
def read(monkeypatch):
    """Return the numbers of rows that are read at a time from a file with parts of `PART` rows."""
    monkeypatch.setattr(stored_recording, "PART", PART)
    numbers, parts = [], LargeTable.parts

    def counting(table, *most):
        for part in parts(table, *most):
            numbers.append(len(part))
            yield part

    monkeypatch.setattr(LargeTable, "parts", counting)
    monkeypatch.setattr(large_table, "PART", PART)
    return numbers


def values(result):
    return np.array([one.value for one in result.coefficients])


@pytest.mark.parametrize("rows", ["condition", "equal"])
def test_a_file_of_one_part_is_prepared_as_in_memory(tmp_path, rows):
    """Excluded rows, segments, and weights where one load has five times the rows of the others."""
    program = concatenate(
        [alpha_sweeps([500.0, 1000.0], sample_rate=20.0), *[alpha_sweeps([1500.0], sample_rate=20.0)] * 5]
    )
    recorded = VirtualBench(known_tire("mf96")).run(program).with_signs("iso").table
    recorded.loc[100:119, "Fz"] = 1.0
    write_table(recorded, tmp_path / "bench.parquet")
    book, table = model("mf96"), LargeTable(tmp_path / "bench.parquet")
    whole = prepare([table.excerpt], book, rows=rows)
    parts = prepare([table.excerpt], book, rows=rows, large={0: table})
    found = pd.concat(parts.parts(0), ignore_index=True)
    known = {name: found[name] for name in found if name != "weight"}
    pd.testing.assert_frame_equal(pd.DataFrame(known), whole.table[list(known)])
    included = found["included"]
    assert 20 <= (~included).sum() < 100
    np.testing.assert_allclose(found["weight"][included], whole.table["weight"][included], rtol=1e-12)
    assert (found["weight"][included].std() > 0.1) == (rows == "condition")
    drawn, fitted = (each[["t", "alpha", "Fy", "weight"]] for each in (parts.drawn, whole.fitted))
    np.testing.assert_allclose(drawn, fitted, rtol=1e-12)  # few rows are all drawn


def test_random_rows_and_ranges_are_those_of_all_rows(file, read, monkeypatch):
    """The recordings have their shares of the random rows; an excerpt alone has not the largest slips."""
    other = recorded(known_tire("mf96"), 4000, seed=5).with_signs("iso")
    for name, number in (("EXCERPT", 200), ("PASSAGE", 20)):
        monkeypatch.setattr(large_table, name, number)
    monkeypatch.setattr(fit_data, "DRAWN", 2000)
    book, table = model("mf96"), LargeTable(file)
    parts = prepare([table.excerpt, other], book, screening=False, rows="equal", large={0: table})
    drawn = parts.drawn["recording"].value_counts()
    total = table.rows + len(other)
    assert drawn[0] == pytest.approx(2000 * table.rows / total, rel=0.1)  # three standard deviations
    assert drawn[1] == pytest.approx(2000 * len(other) / total, rel=0.1)
    whole = prepare([read_recording(file), other], book, screening=False, rows="equal")
    ranges = ranges_of(whole, known_tire("mf96"))
    assert ranges_of(parts, known_tire("mf96")) == ranges
    assert ranges_of(replace(parts, stored={}), known_tire("mf96")) != ranges


def test_a_fit_of_a_file_is_the_fit_in_memory(file, read):
    """Without screening the only difference is the order of sums: far less than the tolerance of convergence."""
    options = {"nominal": NOMINAL, "screening": False, "rows": "equal"}
    whole, parts = fit(file, "mf96", **options), fit(file, "mf96", stream_from=1000, **options)
    assert parts.stages[-1].rows == whole.stages[-1].rows
    assert parts.stages[-1].cost == pytest.approx(whole.stages[-1].cost, rel=1e-9)
    interval = np.array([one.interval for one in whole.coefficients])
    np.testing.assert_array_less(np.abs(values(parts) - values(whole))[np.isfinite(interval)],
                                 1e-3 * interval[np.isfinite(interval)] + 1e-12)  # fmt: skip
    for one, other in zip(parts.channels, whole.channels, strict=True):
        assert (one.channel, one.rows) == (other.channel, other.rows)
        assert (one.rmse, one.r2) == pytest.approx((other.rmse, other.r2), rel=1e-6)
    assert max(read) == PART
    assert parts.ok


def test_screening_and_an_excerpt_change_a_fit_by_less_than_its_noise(file, read, monkeypatch):
    """Parts are screened on their own, and the noise is that of an excerpt: the rows of the last stage are the same."""
    monkeypatch.setattr(large_table, "EXCERPT", 6000)
    monkeypatch.setattr(large_table, "PASSAGE", 500)
    whole, parts = fit(file, "mf96", nominal=NOMINAL), fit(file, "mf96", nominal=NOMINAL, stream_from=1000)
    assert parts.stages[-1].rows == pytest.approx(whole.stages[-1].rows, rel=0.01)
    interval = np.array([one.interval for one in whole.coefficients])
    known = np.isfinite(interval) & (interval > 0)
    off = (values(parts) - values(whole))[known] / interval[known]
    assert np.sqrt(np.mean(off**2)) < 0.25  # half a standard error
    assert max(read) == PART
    assert len(parts.evidence.table) <= 6000
    assert any("excerpt of 6,000 rows" in note for note in parts.notes)
    for name, limits in whole.tire.ranges.items():
        assert parts.tire.ranges[name] == pytest.approx(limits)
    assert not parts.solved


def test_excluded_rows_of_all_parts_are_counted(file, read):
    whole, parts = (fit(file, "mf96", nominal=NOMINAL, recipe="joint", stream_from=n) for n in (10**6, 1000))
    assert [(one.reason, one.rows, one.of) for one in parts.excluded_rows] == [
        (one.reason, one.rows, one.of) for one in whole.excluded_rows
    ]
    assert ("lifted", 300) in [(one.reason, one.rows) for one in parts.excluded_rows]
    assert parts.stages[-1].rows == LargeTable(file).rows - sum(one.rows for one in parts.excluded_rows)


def test_what_needs_all_rows_in_memory_is_refused(file):
    with pytest.raises(FitError, match=r"'load' needs all rows in memory.*stream_from"):
        fit(file, "mf96", nominal=NOMINAL, stream_from=1000, rows="load")
    with pytest.raises(FitError, match=r"needs all rows in memory.*stream_from"):
        fit(file, "mf96", nominal=NOMINAL, stream_from=1000, effects=["heat_friction"])


def test_a_file_that_changes_is_an_error(file, read, monkeypatch):
    table = LargeTable(file)
    table.rows += 1
    with pytest.raises(DataError, match="rows can be read"):
        fit(table, "mf96", nominal=NOMINAL)


def test_other_tables_are_fitted_together_with_a_file(file, read):
    other = recorded(known_tire("mf96"), 3000, seed=5).with_signs("iso")
    options = {"nominal": NOMINAL, "screening": False, "rows": "equal"}
    whole, parts = (fit([file, other], "mf96", stream_from=n, **options) for n in (10**6, 5000))
    assert [one.rows for one in parts.channels] == [one.rows for one in whole.channels]
    assert parts.stages[-1].cost == pytest.approx(whole.stages[-1].cost, rel=1e-9)
