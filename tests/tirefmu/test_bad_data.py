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
            "t": np.arange(4 * rows) / 100.0, "kappa": kappa, "alpha": alpha, "gamma": 0.0, "Fz": load * heavy,
            "p": 83e3, "V": 11.0,
            "Fx": load * mu * heavy * np.sin(1.5 * np.arctan(12.0 * kappa)) + random.normal(0, 5, 4 * rows),
            "Fy": side + random.normal(0, 5, 4 * rows),
            "Mz": -0.03 * side * np.cos(1.1 * np.arctan(9.0 * alpha)) + random.normal(0, 0.3, 4 * rows),
        }
    )  # fmt: skip


def side_alone(table):
    return table[["t", "alpha", "gamma", "Fz", "Fy"]].iloc[: len(table) // 2]


REFUSED = {
    "no output": (lambda t: [t.drop(columns=["Fx", "Fy", "Mz"])], "a.csv: no measured output (Fx, Fy, Mz, Mx, My)"),
    "outputs that were not measured": (lambda t: [t.assign(Fx=np.nan, Fy=np.nan, Mz=np.nan)], "a.csv: no measured"),
    "load under another name": (
        lambda t: [t.rename(columns={"Fz": "load"})], "column 'load' is not a channel: did you mean Fz?",
    ),
    "constant slips": (
        lambda t: [t.assign(alpha=0.05, kappa=0.0)],
        "a.csv: alpha is constant although Fy changes from -1.6 to 1.6 times the load: name its column (--columns",
    ),
    "all rows lifted": (
        lambda t: [t.assign(Fz=0.0)],
        "a.csv: Fz is 0 in every row: it was not measured: name its column (--columns Fz=NAME)",
    ),
    "no slip": (lambda t: [t.drop(columns="kappa")], "a.csv: kappa is missing although Fx changes from -1.6 to 1.6"),
    "load in lbf": (lambda t: [t.assign(Fz=t["Fz"] / 4.448)], "a.csv: the largest force over load is 6.89 (tires"),
    "all rows standing": (lambda t: [t.assign(V=0.0)], "1200 of 1200 rows excluded: standing (the wheel does not"),
    "all loads out of range": (lambda t: [t.assign(Fz=5e6)], "a.csv: Fz reaches 5e+06 N: in another unit?"),
    "slip angle under another name": (
        lambda t: [t.rename(columns={"alpha": "SlipAngle"})],
        "a.csv: column 'SlipAngle' is not a channel: did you mean alpha?",
    ),
    "side force under another name": (
        lambda t: [t.rename(columns={"Fy": "LateralForce"})], "column 'LateralForce' is not a channel: did you mean",
    ),
    "load in kN": (lambda t: [t.assign(Fz=t["Fz"] / 1e3)], "a.csv: no |Fz| is above 0.9 N: in kN? declare it"),
    "load of the other sign": (
        lambda t: [t.assign(Fz=-t["Fz"])], "a.csv: Fz is negative in 100 % of the rows: SAE signs? (--signs sae)",
    ),
    "side force of the other sign": (
        lambda t: [side_alone(t).assign(Fy=-side_alone(t)["Fy"])],
        "a.csv: Fy rises with alpha, in iso it falls: the data fit adapted-sae (--signs adapted-sae)",
    ),
    "moment of the other sign": (
        lambda t: [t.assign(Mz=-t["Mz"])], "a.csv: Mz falls with alpha at small angles, in iso it rises: Mz has the",
    ),
    "slip of the other sign": (lambda t: [t.assign(Fx=-t["Fx"])], "a.csv: Fx falls with kappa, in iso it rises"),
    "forces exchanged": (
        lambda t: [t.rename(columns={"Fx": "Fy", "Fy": "Fx"})],
        "Fy follows kappa and Fx does not: the columns Fx and Fy are exchanged (--columns Fx=Fy,Fy=Fx)",
    ),
    "degrees for radians": (
        lambda t: [t.assign(alpha=np.degrees(t["alpha"]))],
        "a.csv: alpha reaches 11.46 rad: in degrees? declare it: 'alpha [deg]'",
    ),
    "inclination in degrees": (lambda t: [t.assign(gamma=4.0)], "a.csv: gamma reaches 4 rad: in degrees?"),
    "slip in percent": (lambda t: [t.assign(kappa=100 * t["kappa"])], "a.csv: kappa reaches 20: in percent?"),
    "NaN in most rows of an input": (
        lambda t: [t.assign(Fz=t["Fz"].where(t.index % 3 == 0))], "a.csv: line 3: Fz is NaN (800 of 1200",
    ),
    "infinity in an output": (lambda t: [t.assign(Fx=t["Fx"].where(t.index != 7, np.inf))], "a.csv: line 9: Fx is inf"),
    "one row": (lambda t: [t.iloc[:1]], "is measured over a varying slip: nothing to fit"),
    "no row": (lambda t: [t.iloc[:0]], "a.csv: no rows"),
    "the second file is bad": (
        lambda t: [t, t.assign(Fz=-t["Fz"])], "b.csv: Fz is negative in 100 % of the rows: SAE signs?",
    ),
}  # fmt: skip

REPORTED = {
    "no load": (lambda t: [side_alone(t).drop(columns="Fz")], "a.csv: no column Fz: every row is evaluated at the"),
    "no slip": (
        lambda t: [t.drop(columns="kappa").assign(Fx=0.1 * t["Fx"])], "a.csv: Fx is not fitted, kappa does not vary",
    ),
    "one load": (lambda t: [side_alone(t).assign(Fz=900.0)], "a.csv: only one load (900 N): the influence of load"),
    "ten rows": (lambda t: [side_alone(t).iloc[::60]], "a.csv: 10 rows are fewer than a fit of one force needs"),
    "time going backwards": (lambda t: [side_alone(t).iloc[::-1]], "a.csv: t runs backwards in 599 of 599 steps"),
    "NaN in an input": (
        lambda t: [t.assign(Fz=t["Fz"].where(t.index != 7))],
        "a.csv: 1 of 1200 rows lack an input: NaN in Fz (1), the first in row 8: excluded",
    ),
    "two tires in two files": (
        lambda t: [side_alone(t), side_alone(sweeps(1.1, seed=1))], "two tires? at 900 N the largest |Fy|/Fz is 1.",
    ),
    "two tires in one file": (
        lambda t: [pd.concat([side_alone(t), side_alone(sweeps(1.1, seed=1))])],
        "two tires? at 900 N the largest |Fy|/Fz is 1.",
    ),
    "two sizes of tires": (
        lambda t: [side_alone(t), side_alone(sweeps(load=9.0, seed=1))], "two tires? the load reaches 900 N in a.csv",
    ),
    "a wild reading": (
        lambda t: [side_alone(t).assign(Fy=t["Fy"].where(t.index != 70, 9e3))],
        "a.csv: 1 of 600 rows excluded: outlier (a value is far from the running median of its channel)",
    ),
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
            "fit", *files, "--model", "mf96", "-o", "new.tir", "--effects", "none", "--nominal", "Fz0=700,R0=0.25"
        )
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
    assert any(reason.startswith("  - a.csv: the slip stiffness of Fy differs by -") for reason in reasons)
    assert left == ["new.tir"]


def test_good_data_give_no_message(fitted):
    outcome, _ = fitted([side_alone(sweeps()).iloc[:300], side_alone(sweeps(seed=1)).iloc[300:].assign(p=80e3)])
    shown = [line for line in outcome.out.splitlines() if line.startswith(("note: ", "warning: "))]
    notes = [line for line in shown if "only one load" not in line]
    assert notes == []
