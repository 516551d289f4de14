"""A small version of benchmarks/recovery.py: recovery of a complete MF96 tire, intervals, other initial values."""

from __future__ import annotations

import runpy
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from tirefmu.fitting import fit
from tirefmu.fitting.constraints.constraint_functions import measured_values
from tirefmu.fitting.constraints.physical import chosen_constraints, grid, operating_range

from .known_tires import CHANNELS, NOMINAL, SIZES, known_tire, moved, recorded

ROOT = Path(__file__).parents[2]
MODEL, ROWS = "mf96", 2500
TRUTH = known_tire(MODEL)
RECORDING = recorded(TRUTH, ROWS, correlation_time=0.5)


def difference(tire, other=TRUTH):
    """Return the largest root mean square difference of a channel, relative to its noise."""
    table = RECORDING.with_signs("adapted-sae").table
    inputs = {name: table[name].to_numpy() for name in TRUTH.inputs}
    one, two = tire.in_signs("adapted-sae").forces(**inputs), other.in_signs("adapted-sae").forces(**inputs)
    return max(float(np.sqrt(np.mean((one[name] - two[name]) ** 2))) / SIZES[name] for name in CHANNELS)


@pytest.fixture(scope="module")
def found():
    return fit([RECORDING], MODEL, nominal=NOMINAL)


def test_predictions_are_within_the_noise(found):
    assert found.ok, found.status
    assert difference(found.tire) < 0.4
    for channel in found.channels:
        assert channel.rmse == pytest.approx(SIZES[channel.channel], rel=0.1)


def test_intervals_contain_the_true_values(found):
    truth = TRUTH.in_signs(found.signs)
    known = [c for c in found.coefficients if np.isfinite(c.interval) and not c.at_bound]
    inside = [abs(c.value - truth.values[c.name]) <= c.interval for c in known]
    assert len(inside) > 60
    assert np.mean(inside) > 0.87  # one recording; benchmarks/recovery.py counts many
    assert np.mean([abs(c.value - truth.values[c.name]) <= 0.2 * c.interval for c in known]) < 0.6  # nor far too wide


@pytest.mark.parametrize(("share", "seed"), [(0.3, 0), (0.3, 2), (0.6, 2)])
def test_other_starts_have_the_same_solution(found, share, seed):
    start = moved(TRUTH, share, seed)
    assert difference(start) > 5.0
    result = fit([RECORDING], MODEL, start=start)
    assert result.ok, result.status
    assert difference(result.tire, found.tire) < 0.1


@pytest.mark.parametrize("model", ["mf96", "mf52", "mf61"])
def test_the_known_tires_satisfy_every_constraint(model):
    tire = known_tire(model)
    table = recorded(tire, 300, level=0.0).with_signs("adapted-sae").table
    ranges = operating_range(table, tire)
    nominal = {name: tire.nominal(name) for name in tire.inputs}
    for constraint in (c for channel in CHANNELS for c in chosen_constraints(model)[channel]):
        values = measured_values(
            tire.symbolic_model, constraint, grid(constraint, ranges, nominal, density=2), tire.parameters()
        )
        assert constraint.distance(values).min() > 0, constraint.name


def test_coverages_are_stored_one_by_one_and_tabulated(tmp_path):
    """An interrupted study continues with what is stored; the table has a line for each kind of bench."""
    page = runpy.run_path(str(ROOT / "benchmarks" / "recovery_table.py"))
    task, refit, path = page["RecoveryTask"], page["Refit"], tmp_path / "results.jsonl"
    quantities = dict.fromkeys(page["PREDICTED"], 23)
    refits = [
        refit(task("mf61", noise, 3000, seed), True, 0.1, 90 + 2 * seed, 100, 1.0, 24, quantities)
        for noise in ("white", "correlated")
        for seed in (0, 1)
    ]
    for each in refits:
        page["store"](path, each)
    assert list(page["stored"](path)) == refits
    assert list(page["stored"](tmp_path / "missing")) == []
    rows = [line for line in page["table"](refits).splitlines() if line.startswith("| MF6.1")]
    assert [row.split(" | ")[:2] for row in rows] == [
        [f"| MF6.1, {noise}, 3,000 rows", "2"] for noise in ("white", "correlated")
    ]
    assert all("| 95.8 +- 0.0 % |" in row and "| 91.0 +- 1.0 % | - |" in row for row in rows)


def test_a_study_of_one_kind_leaves_the_lines_of_the_others(tmp_path):
    page = runpy.run_path(str(ROOT / "benchmarks" / "recovery_table.py"))
    path = tmp_path / "page.md"
    page["write"].__globals__["PAGE"] = path

    def refits(noise, replicates, covered):
        task, counts = page["RecoveryTask"]("mf61", noise, 3000, 0, replicates), dict.fromkeys(page["PREDICTED"], 23)
        first = page["Refit"](task, True, 0.1, covered, 100, 1.0, 24, counts, 93, 100 if replicates else 0)
        return [first, replace(first, task=replace(task, seed=1))]

    path.write_text(f"before\n{page['table'](refits('white', 0, 91) + refits('correlated', 0, 92))}after\n", "utf-8")
    page["write"](refits("white", 100, 93) + refits("correlated", 0, 94))
    text = path.read_text(encoding="utf-8")
    assert (text[:7], text[-6:]) == ("before\n", "after\n")
    rows = [[cell.strip() for cell in line.split("|")[1:-1]] for line in text.splitlines() if "| MF6.1" in line]
    assert [(row[0], row[-2], row[-1]) for row in rows] == [
        ("MF6.1, white, 3,000 rows", "91.0 +- 0.0 %", "-"),
        ("MF6.1, correlated, 3,000 rows", "94.0 +- 0.0 %", "-"),
        ("MF6.1, white, 3,000 rows", "93.0 +- 0.0 %", "93.0 +- 0.0 %"),
    ]
