"""Bad data on the command line: rejected with one line, or fitted with notes."""

from __future__ import annotations

import numpy as np
import pandas as pd
import pytest


def sweeps(friction=1.7, load=1.0, seed=0, rows=300):
    """Return a sweep of slip angle at each of two loads, then of slip, at 100 Hz, in iso, with noise."""
    ramp = np.tile(np.interp(np.arange(rows) / rows, [0.0, 0.25, 0.75, 1.0], [0.0, 0.2, -0.2, 0.0]), 4)
    part, random = np.repeat(np.arange(4), rows), np.random.default_rng(seed)
    lateral, heavy = part < 2, np.where(part % 2, 900.0, 500.0)
    mu = friction - 0.3 * heavy / 1000.0
    alpha, kappa = np.where(lateral, ramp, 0.0), np.where(lateral, 0.0, ramp)
    side = -load * mu * heavy * np.sin(1.4 * np.arctan(10.0 * alpha))
    return pd.DataFrame(
        {
            "t": np.arange(4 * rows) / 100.0, "kappa": kappa, "alpha": alpha,
            "gamma": np.random.default_rng(seed + 1).normal(0, 1e-4, 4 * rows), "Fz": load * heavy, "p": 83e3,
            "V": 11.0,
            "Fx": load * mu * heavy * np.sin(1.5 * np.arctan(12.0 * kappa)) + random.normal(0, 5, 4 * rows),
            "Fy": side + random.normal(0, 5, 4 * rows),
            "Mz": -0.03 * side * np.cos(1.1 * np.arctan(9.0 * alpha)) + random.normal(0, 0.3, 4 * rows),
        }
    )  # fmt: skip


def side_alone(table):
    return table[["t", "alpha", "gamma", "Fz", "Fy"]].iloc[: len(table) // 2]


#: In addition to the inputs of docs/awkward_inputs.md, which `test_awkward_inputs.py` compares, and to wrong signs and
#: units (tests/measurements/column_meaning).
REFUSED = {
    "outputs that were not measured": (lambda t: [t.assign(Fx=np.nan, Fy=np.nan, Mz=np.nan)], "a.csv: no measured"),
    "all rows standing": (lambda t: [t.assign(V=0.0)], "1200 of 1200 rows excluded: standing (the wheel does not"),
    "infinity in an output": (lambda t: [t.assign(Fx=t["Fx"].where(t.index != 7, np.inf))], "a.csv: line 9: Fx is inf"),
    "one row": (lambda t: [t.iloc[:1]], "is measured over a varying slip: nothing to fit"),
    "the second file is bad": (
        lambda t: [t, t.assign(Fz=-t["Fz"])], "b.csv: Fz is negative in 100 % of the rows: SAE signs?",
    ),
}  # fmt: skip
REPORTED = {
    "no slip": (
        lambda t: [t.drop(columns="kappa").assign(Fx=0.1 * t["Fx"])], "a.csv: Fx is not fitted, kappa does not vary",
    ),
    "ten rows": (lambda t: [side_alone(t).iloc[::60]], "a.csv: 10 rows are fewer than a fit of one force needs"),
}  # fmt: skip


@pytest.fixture
def fitted(command, tmp_path, monkeypatch):
    """Return a function that writes tables as a.csv, b.csv and fits them."""
    monkeypatch.chdir(tmp_path)

    def run(tables):
        files = [f"{name}.csv" for name, _ in zip("ab", tables, strict=False)]
        for file, table in zip(files, tables, strict=True):
            table.to_csv(file, index=False)
        outcome = command(
            "fit", *files, "--model", "mf96", "-o", "new.tir", "--effects", "none", "--nominal", "Fz0=700,R0=0.25",
            "--all",
        )  # fmt: skip
        return outcome, sorted(path.name for path in tmp_path.iterdir() if path.name not in files)

    return run


@pytest.mark.parametrize("fault", REFUSED)
def test_it_is_refused_in_one_line(fitted, fault):
    change, message = REFUSED[fault]
    outcome, left = fitted(change(sweeps()))
    assert outcome.status == 2
    (line,) = outcome.err.splitlines()
    assert line.startswith("tirefmu: error: ")
    assert message in line
    assert outcome.out == ""
    assert left == []


@pytest.mark.parametrize("fault", REPORTED)
def test_it_is_fitted_and_reported(fitted, fault):
    change, message = REPORTED[fault]
    outcome, left = fitted(change(sweeps()))
    assert outcome.status in (0, 1), outcome.err
    shown = [line for line in outcome.out.splitlines() if line.startswith(("note: ", "warning: "))]
    assert len([line for line in shown if message in line]) == 1
    assert left == ["new.tir"]


def test_a_missing_slip_follows_the_verdict_before_all_tables(fitted):
    table = sweeps().drop(columns="alpha")
    outcome, _ = fitted([table.assign(Fy=0.1 * table["Fy"])])
    headline, _ = outcome.out.split("Goodness of fit", 1)
    assert headline.startswith("verdict: ")
    assert "warning: a.csv: NO COLUMN alpha (slip angle): Fy and Mz cannot be fitted" in headline


def test_a_tire_that_is_not_usable_is_written_with_exit_status_1(fitted):
    """The second file has a third of the side force: no tire has both, and which one it is nearer to is arbitrary."""
    table = side_alone(sweeps())
    outcome, left = fitted([table, table.assign(Fy=0.33 * table["Fy"])])
    verdict, *reasons = outcome.out.splitlines()
    assert (outcome.status, verdict) == (1, "verdict: not usable")
    assert any(
        reason.startswith("  - a.csv: the slip stiffness of Fy differs from the data by -") for reason in reasons
    )
    assert left == ["new.tir"]
