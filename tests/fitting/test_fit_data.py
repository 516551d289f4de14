"""The data of a fit: included and excluded rows, weights, notes."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pandas as pd
import pytest

from tirefmu.boundary.errors import DataError
from tirefmu.fitting import fit
from tirefmu.fitting.data import prepare
from tirefmu.measurements import Noise, Recording, VirtualBench, alpha_sweeps, concatenate
from tirefmu.symbolic.models import model_named

MODEL = model_named("mf96")


@pytest.fixture(scope="module")
def bench(known):
    """Return a recording of the side force at 25 Hz, as a time series."""

    def run(*programs, noise=None, seed=2):
        recording = VirtualBench(known, noise or Noise(), seed=seed).run(concatenate(programs))
        return replace(recording, table=recording.table.drop(columns=["Fx", "Mz"]))

    return run


@pytest.fixture(scope="module")
def once(bench):
    return bench(alpha_sweeps([400.0, 700.0, 1100.0], [0.0], sample_rate=25.0))


def spoiled(recording, rows, force=9e3):
    table = recording.table.copy()
    table.loc[rows, "Fy"] = force
    return replace(recording, table=table)


def test_excluded_outliers_do_not_change_a_fit(once, known, make):
    rows = np.arange(20, len(once), 60)
    bad = spoiled(once, rows)
    options = {"effects": ("load_friction", "load_stiffness", "plysteer"), "nominal": make.nominal}
    clean, screened, bent = (
        fit([data], "mf96", screening=screening, **options)
        for data, screening in ((once, True), (bad, True), (bad, False))
    )
    (excluded,) = screened.excluded_rows
    assert (excluded.reason, excluded.rows, excluded.of) == ("outlier", len(rows), len(once))
    assert len(excluded.findings) == len(rows)
    assert excluded.findings[0].startswith("outlier: row 21: Fy is 9000 N, the running median is ")
    assert clean.excluded_rows == bent.excluded_rows == ()
    points = pd.DataFrame({"alpha": np.tile(np.linspace(-0.2, 0.2, 21), 2), "Fz": np.repeat([500.0, 1000.0], 21)})
    curves = [result.tire.evaluate(points)["Fy"] for result in (clean, screened, bent)]
    assert np.abs(curves[1] - curves[0]).max() < 10.0
    assert np.abs(curves[2] - curves[0]).max() > 100.0
    # The score counts every row, the bad ones too.
    assert screened.channels[0].rows == len(once)
    assert screened.channels[0].rmse > 10 * clean.channels[0].rmse
    assert screened.to_json()["set_aside"][0]["rows"] == len(rows)


def test_a_range_is_that_of_the_rows_that_are_fitted(once):
    table = once.table.copy()
    table.loc[100, "Fz"] = 40e3
    data = prepare([replace(once, table=table)], MODEL)
    assert data.fitted["Fz"].max() < 1300.0
    assert data.table["Fz"].max() == 40e3


def test_repeated_conditions_count_once_by_default(bench):
    sweep = alpha_sweeps([400.0, 700.0, 1100.0], [0.0], sample_rate=25.0)
    again = alpha_sweeps([1100.0], [0.0], sample_rate=25.0)
    recording = bench(sweep, again, again, again)
    tables = {rows: prepare([recording], MODEL, rows=rows).table for rows in ("condition", "equal")}
    heavy = tables["condition"]["Fz"] > 900.0
    share = {rows: table.loc[heavy, "weight"].sum() / table["weight"].sum() for rows, table in tables.items()}
    assert share["equal"] == pytest.approx(4 / 6, rel=0.01)
    assert share["condition"] == pytest.approx(1 / 3, rel=0.02)


def test_an_error_in_repeats_has_less_weight_if_conditions_are_weighted_equally(bench, known, make):
    sweep = alpha_sweeps([400.0, 700.0, 1100.0], [0.0], sample_rate=25.0)
    again = alpha_sweeps([1100.0], [0.0], sample_rate=25.0)
    recording = bench(sweep, again, again, again, noise=Noise.none())
    odd = recording.table["Fz"] > 900.0  # a load at which the bench read 5 % too much
    recording = replace(recording, table=recording.table.assign(Fy=recording.table["Fy"] * np.where(odd, 1.05, 1.0)))
    options = {"effects": ("load_stiffness",), "nominal": make.nominal}
    friction = [fit([recording], "mf96", rows=rows, **options).tire.values["PDY1"] for rows in ("equal", "condition")]
    lighter = fit([replace(recording, table=recording.table[~odd.to_numpy()])], "mf96", **options).tire.values["PDY1"]
    assert abs(friction[1] - lighter) < abs(friction[0] - lighter)


def test_weights_by_load_make_errors_relative_to_the_load(bench):
    """Every load has the same weight in relative errors; noise of the load does not change the weight of a row."""
    recording = bench(alpha_sweeps([400.0, 700.0, 1100.0], [0.0], sample_rate=25.0))
    table = prepare([recording], MODEL, rows="load").table
    level = table["Fz"].round(-2)
    relative = table["weight"] * level**2
    assert table["weight"].groupby(level).nunique().tolist() == [1, 1, 1]
    assert relative.to_numpy() == pytest.approx(relative.iloc[0], rel=0.02)
    assert table["weight"].mean() == pytest.approx(1.0)


def test_weights_by_load_do_not_depend_on_signs_and_are_limited_near_lift_off(bench):
    recording = bench(alpha_sweeps([400.0, 700.0, 1100.0], [0.0], sample_rate=25.0))
    lifted = recording.table.assign(Fz=recording.table["Fz"].mask(recording.table.index < 5, 0.0))
    tables = [prepare([replace(recording, table=lifted).with_signs(signs)], MODEL, screening=False, rows="load").table
              for signs in ("iso", "sae")]  # fmt: skip
    np.testing.assert_allclose(tables[0]["weight"], tables[1]["weight"], rtol=1e-12)
    assert np.isfinite(tables[0]["weight"]).all()


def test_independent_weights_use_the_effective_sample_size(once, known, make):
    """Two recordings have errors of equal size, one slow and one random: the second contains more information."""
    size, n = 60.0, len(once)
    slow = size * np.sqrt(2.0) * np.sin(2 * np.pi * np.arange(n) / n + 0.7)
    quick = np.random.default_rng(0).normal(0.0, size, n)
    shifted = 1.06 * once.table["Fy"]
    drifting = replace(once, table=once.table.assign(Fy=shifted + slow), source="slow")
    noisy = replace(once, table=once.table.assign(Fy=once.table["Fy"] + quick), source="quick")
    options = {"effects": make.effects, "nominal": make.nominal, "screening": False}
    by_row, by_sample_size = (fit([drifting, noisy], "mf96", rows=rows, **options) for rows in ("equal", "independent"))
    assert by_sample_size.ok
    true = once.table["Fy"].to_numpy()

    def error(result):
        force = result.tire.evaluate(once.table, signs=once.signs)["Fy"].to_numpy()
        return float(np.sqrt(np.mean((force - true) ** 2)))

    assert error(by_sample_size) < 0.7 * error(by_row)


def test_a_file_with_warm_up_only_is_excluded(once):
    cold = replace(once, source="warmup.csv", table=once.table.assign(Fy=0.5 * once.table["Fy"]))
    data = prepare([once, cold], MODEL)
    assert set(data.fitted["recording"]) == {0}
    assert [str(excluded) for excluded in data.excluded_rows] == [
        f"warmup.csv: {len(cold)} of {len(cold)} rows excluded: warm-up (the tread is still cold)"
    ]
    with pytest.raises(DataError, match=r"all rows are excluded \(--all-rows includes them\): warmup.csv: "):
        prepare([cold], MODEL)
    assert len(prepare([cold], MODEL, screening=False).fitted) == len(cold)


@pytest.mark.parametrize(("degrees", "fitted"), [(1.2, True), (0.3, False)])
def test_a_channel_is_fitted_if_its_slip_varies_sufficiently(degrees, fitted):
    """A sweep of one degree determines the cornering stiffness; variation of a held slip angle does not."""
    alpha = np.radians(degrees) * np.linspace(-0.5, 0.5, 300)
    kappa = np.linspace(-0.1, 0.1, 300)
    table = pd.DataFrame({"alpha": alpha, "kappa": kappa, "Fz": 700.0, "Fx": kappa, "Fy": alpha})
    data = prepare([Recording(table, "adapted-sae", "small")], MODEL, screening=False)
    assert data.table["Fy"].notna().all() == fitted
    assert any("Fy is not fitted, alpha does not vary there" in note for note in data.notes) != fitted


@pytest.mark.parametrize(("channel", "value"), [("Mz", 0.0), ("Mz", 5.0), ("Fx", 0.0), ("My", 0.0)])
def test_a_channel_without_variance_is_not_fitted(once, channel, value):
    """Its noise has no scale: with a weight it would reduce the forces that it depends on to zero."""
    table = once.table.assign(kappa=once.table["alpha"], **{channel: value})
    data = prepare([replace(once, table=table)], model_named("mf61"), screening=False)
    assert data.table[channel].isna().all()
    assert data.table["Fy"].notna().all()
    assert any(note.endswith(f"{channel} is not fitted, it is {value:.4g} in every row") for note in data.notes)


def test_a_constant_rolling_resistance_is_fitted(once):
    data = prepare([replace(once, table=once.table.assign(My=-5.0))], model_named("mf61"), screening=False)
    assert data.table["My"].notna().all()
