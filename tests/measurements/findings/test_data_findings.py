"""Each contradiction is found where it was planted, and a sound recording has none."""

from __future__ import annotations

import re
import shlex

import numpy as np
import pandas as pd
import pytest

from tirefmu.measurements import Recording, data_findings, recording_from, residual_findings
from tirefmu.measurements.row_selection.expression import parse_selection

STEP = 0.01


def bench(
    *, seed=0, friction=1.5, stiffness=20.0, shift=0.0, lag=0.0, heat=0.0, first=60.0, pressures=(83e3, 83e3), rows=900,
    noise=5.0,
):  # fmt: skip
    """Return sweeps of slip angle at two loads and two pressures at 100 Hz, in iso, with noise."""
    sweep = np.arange(rows) * STEP
    angle = 0.2 * np.interp(sweep / sweep[-1], [0.0, 0.25, 0.75, 1.0], [0.0, 1.0, -1.0, 0.0])
    program = [(load, pressure) for pressure in pressures for load in (500.0, 900.0)]
    alpha, load = np.tile(angle, len(program)), np.repeat([load for load, _ in program], rows)
    clock, random = np.arange(len(alpha)) * STEP, np.random.default_rng(seed)
    late = np.interp(clock - lag, clock, alpha)
    warm = 60.0 - (60.0 - first) * np.exp(-clock / 8.0) + (5.0 * np.sin(0.37 * clock + 1.0) if heat else 0.0)
    force = -friction * load * np.sin(1.4 * np.arctan(stiffness / 1.4 / friction * (late + shift)))
    return pd.DataFrame(
        {
            "t": clock, "alpha": alpha, "gamma": 1e-4, "Fz": load + random.normal(0.0, 4.0, len(alpha)),
            "p": np.repeat([pressure for _, pressure in program], rows) + random.normal(0.0, 200.0, len(alpha)),
            "V": 11.0, "T": warm, "Fy": force * (1.0 + heat * (warm - 60.0)) + random.normal(0.0, noise, len(alpha)),
        }
    )  # fmt: skip


def found(*tables):
    recordings = [recording_from(Recording(table, "iso", f"{name}.csv")) for name, table in zip("abc", tables)]  # noqa: B905
    return data_findings(recordings)


def kinds(*tables):
    return {finding.kind for finding in found(*tables)}


def test_sound_recordings_of_one_tire_have_no_finding():
    assert found(bench()) == []
    assert found(bench(), bench(seed=1)) == []


def test_the_order_of_rows_is_no_unit_of_the_clock():
    table = bench()
    shuffled = table.sample(frac=1.0, random_state=1, ignore_index=True)
    assert not any(finding.serious for finding in found(shuffled))
    (finding,) = (finding for finding in found(shuffled.assign(t=1e6 * shuffled["t"])) if finding.serious)
    assert "in us?" in finding.text


@pytest.mark.parametrize(("step", "parts", "few"), [(100, 1, True), (100, 2, False), (200, 2, True), (10, 3, False)])
def test_few_rows_are_counted_over_all_tables(step, parts, few):
    tables = [bench(seed=part).iloc[::step] for part in range(parts)]
    assert ("few rows" in kinds(*tables)) == few


def test_a_file_given_twice_in_any_signs():
    twice = bench()
    (finding,) = data_findings([Recording(twice, "iso", "a.csv"), Recording(twice, "iso", "b.csv").with_signs("sae")])
    assert (finding.kind, finding.serious) == ("repeated rows", True)
    assert finding.text.startswith("a.csv is given twice")


def test_files_that_share_rows():
    assert "a.csv shares 900 rows with b.csv" in str(found(bench(), pd.concat([bench().iloc[:900], bench(seed=1)]))[0])


def channels(**columns):
    sweep = {"kappa": [0.0, 0.1] * 40, "alpha": [-0.1, 0.1] * 40, "Fz": [500.0, 900.0] * 40, "Fy": [9.0, -9.0] * 40}
    sweep |= {"gamma": [1e-3] * 80}
    table = {name: values for name, values in (sweep | columns).items() if values is not None}
    return data_findings([Recording(pd.DataFrame(table), "iso", "a.csv")])


def test_a_missing_slip_comes_first_and_is_serious():
    first, *others = channels(alpha=None)
    assert (first.kind, first.serious) == ("missing slip", True)
    assert first.text.startswith("a.csv: NO COLUMN alpha (slip angle): Fy cannot be fitted, and every row counts as")
    assert not any(finding.kind == "missing slip" for finding in others)
    assert channels(kappa=None) == []  # it has no influence on Fy


def test_what_a_fit_refuses_is_serious():
    held = bench().assign(alpha=0.1)
    assert [f.kind for f in found(held) if f.serious][-1] == "nothing to fit"
    assert "nothing to fit" not in kinds(held, bench())  # the other file has a curve
    assert [f.kind for f in found(bench().drop(columns="Fz")) if f.serious] == ["missing load"]


def test_a_table_without_camber_is_fitted_at_an_assumed_one():
    (finding,) = channels(gamma=None)
    assert (finding.kind, finding.serious) == ("assumed camber", False)
    assert finding.text.startswith("a.csv: no column gamma: 0 deg assumed")
    assert channels(gamma=None, Fy=None, Fx=[-9.0, 9.0] * 40) == []  # camber has no influence on Fx
    assert channels(gamma=[0.0, 0.05] * 40) == []
    assert [finding.text[:41] for finding in channels(gamma=0.0)] == ["a.csv: gamma is exactly 0 in every row; i"]


def test_columns_that_are_not_read_are_named_and_counted():
    (few,) = channels(lap=1)
    assert (few.kind, few.serious) == ("unread columns", False)
    assert few.text == "a.csv: columns that are no channels are not fitted: lap"
    (many,) = channels(**{f"c{number}": 1 for number in range(11)})
    assert many.text.endswith(": c0, c1, c2, c3, c4, c5, c6, c7 and 3 more")


@pytest.mark.parametrize(("rows", "serious"), [(100, False), (1800, True)])
def test_repeated_rows(rows, serious):
    table = bench()
    repeated = table.iloc[:rows].assign(t=table["t"].iloc[:rows] + 1000.0)
    findings = found(pd.concat([table, repeated]))
    (finding,) = [finding for finding in findings if finding.kind == "repeated rows"]
    assert finding.serious == serious
    assert f"{rows} of {len(table) + rows} rows repeat earlier rows in every channel but t, the first" in finding.text
    assert f"at row {len(table) + 1}" in finding.text


def test_a_sweep_back_without_noise_is_no_repetition():
    there = np.linspace(-0.1, 0.1, 200)
    alpha = np.concatenate([there, there[::-1]])
    table = pd.DataFrame({"alpha": alpha, "gamma": 1e-3, "Fz": 500.0, "Fy": -9e3 * alpha})
    assert kinds(table) == {"coverage"}  # one load


def test_two_tires_in_one_file_without_a_restart_of_the_clock():
    first, second = bench(), bench(seed=1, friction=1.0)
    (finding,) = found(pd.concat([first, second.assign(t=second["t"] + 100.0)]))[:1]
    assert (finding.kind, finding.serious) == ("two tires", True)
    assert "the largest |Fy|/Fz is 1.5" in finding.text


def two_tires(recordings):
    return [finding.text for finding in data_findings(recordings) if finding.kind == "two tires"]


def test_names_of_tires():
    named = [Recording(bench(rows=100), "iso", f"{name}.mat", {"tireid": "Hoosier"}) for name in "ab"]
    unnamed = Recording(bench(rows=100), "iso", "c.mat", {"tireid": ""})
    assert two_tires([*named, unnamed]) == []
    both = [Recording(bench(rows=100), "iso", f"{name}.mat", {"tireid": name}) for name in ("Hoosier", "Avon")]
    assert two_tires(both) == ["two tires? the tire is 'Hoosier' in Hoosier.mat, 'Avon' in Avon.mat"]


def test_two_files_in_one():
    table = pd.concat([bench(rows=100), bench(rows=100).assign(Fz=9000.0)], ignore_index=True)
    (note,) = two_tires([Recording(table, "iso", "both.csv")])
    assert note.startswith("two tires? both.csv: the clock restarts at row 401, and the loads reach 90")


def test_two_tires_in_two_files():
    assert "two tires" not in kinds(bench(), bench(seed=1, friction=1.12 * 1.5))  # pressure changes friction as much
    (finding,) = [finding for finding in found(bench(), bench(seed=1, friction=1.0)) if finding.kind == "two tires"]
    assert "of a.csv and 1" in finding.text
    assert "of b.csv" in finding.text


@pytest.mark.parametrize(
    ("change", "expected"),
    [
        ({"stiffness": 22.0}, r"dFy/dalpha between -1.1 and 1.1 deg by \+(9|10)\.. % on average over 2 conditions"),
        ({"shift": -0.004}, r"the zero of Fy by \+0\.2. deg"),
    ],
)
def test_stiffness_and_shift_between_files(change, expected):
    (finding,) = found(bench(), bench(seed=1, **change))
    assert finding.kind == "stiffness between files"
    assert finding.text.startswith("b.csv differs from a.csv at equal conditions: ")
    assert re.search(expected, finding.text)


def test_a_shift_is_judged_by_the_noise_of_both_files():
    """The same shift is found without noise, and is uncertain if either file has much of it."""
    first, second, noisy = bench(), bench(seed=1, shift=-0.004), bench(seed=2, shift=-0.004, noise=80.0)
    assert "stiffness between files" in kinds(first, second)
    assert "stiffness between files" not in kinds(first, noisy) | kinds(noisy, first)


def test_a_warm_up():
    (finding,) = found(bench(first=48.0, rows=2000))
    assert finding.kind == "warm-up"
    # 12 K decay to 4 K within 8.8 s. The running median follows by up to its half window.
    after = float(finding.command.split(">= ")[1].split(" s")[0])
    assert after == pytest.approx(8.8, abs=10.0)
    assert after > 0.0
    assert kinds(bench(first=58.0, rows=2000)) == set()
    (finding, *_) = [each for each in found(bench(first=48.0, rows=2000), bench(seed=1)) if each.kind == "warm-up"]
    assert finding.command.startswith('--where \'file != "a.csv" or t >= ')
    hostile = [Recording(bench(first=48.0, rows=2000), "iso", "a';$(b).csv"), Recording(bench(seed=1), "iso", "b.csv")]
    (other, *_) = [each for each in data_findings(hostile) if each.kind == "warm-up"]
    assert shlex.split(other.command)[1].startswith('file != "a\';$(b).csv" or t >= ')
    parse_selection(finding.command.removeprefix("--where '").removesuffix("'"))


def test_pressures_that_were_run_one_after_another():
    (finding,) = found(bench(pressures=(83e3, 70e3, 97e3)))
    assert finding.kind == "run order"
    assert "the levels of p were run one after another (83, 70, 97 kPa)" in finding.text
    assert kinds(bench(pressures=(83e3, 70e3, 83e3))) == set()


def test_a_pause_between_two_sweeps_is_no_finding():
    table = bench()
    assert found(table.assign(t=table["t"] + 20.0 * (table.index // 900))) == []
    ramp = np.tile(np.linspace(-0.2, 0.2, 900), 4)  # each sweep from one end to the other
    clock = np.arange(3600) * STEP + 20.0 * (table.index // 900)
    assert "clock" not in kinds(table.assign(t=clock, alpha=ramp, Fz=500.0))


def test_temperature_and_lag_in_the_residual():
    sound, late, hot = bench(), bench(lag=0.06), bench(heat=-0.01)
    predicted = sound[["Fy"]]
    given = {
        name: Recording(table, "iso", "a.csv") for name, table in {"sound": sound, "lag": late, "heat": hot}.items()
    }
    assert residual_findings([given["sound"].with_signs("sae")], [predicted]) == []
    (lag,) = residual_findings([given["lag"]], [predicted])
    assert lag.kind == "lag"
    assert re.match(r"a.csv: the residual of Fy is like a lag of (5[5-9]|6[0-5]) ms \(9\d % of", lag.text)
    assert lag.effects == ("relax_lat",)
    (heat,) = residual_findings([given["heat"]], [predicted])
    assert re.search(r"like a change of Fy by -(0\.9[7-9]|1\.0[0-3]) % per K", heat.text)
    assert heat.effects == ("temp_friction", "temp_stiffness")
    both = Recording(hot.assign(Mz=0.02 * hot["Fy"]), "iso", "a.csv")
    (merged,) = residual_findings([both], [predicted.assign(Mz=0.02 * predicted["Fy"])])  # one finding for each cause
    assert re.match(r"a.csv: the residuals of Fy and Mz follow the tread temperature, ", merged.text)
    assert re.search(r" of Fy by \S+ % per K and a change of Mz by \S+ % per K \(\d+ % and \d+ % of their", merged.text)
