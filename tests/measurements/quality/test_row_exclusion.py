"""Each excluded row has a reason. All other rows and the recording do not change."""

import numpy as np
import pandas as pd
import pytest

from tirefmu.boundary.errors import DataError
from tirefmu.measurements import (
    EXCLUSION_REASONS,
    Recording,
    VirtualBench,
    alpha_sweeps,
    concatenate,
    exclude_rows,
    kappa_sweeps,
    phases,
    read_recording,
    transitions,
    trento_program,
)
from tirefmu.measurements.thresholds import SETTLING_TIME
from tirefmu.tires import published


@pytest.fixture(scope="module")
def spoilt(make_raw):
    """Return a raw run with rows for every reason of exclusion."""
    run = make_raw(first=20.0)
    table = run.recording.table.copy()
    table.loc[9000, "Fy"] = 9e3
    table.loc[12000:12100, "Fz"] = 0.0
    table.loc[13000:13100, "V"] = 0.0
    return Recording(table, "iso", "raw.csv")


def test_every_reason_is_found_counted_and_reported(spoilt):
    result = exclude_rows(spoilt)
    assert list(result.counts) == list(EXCLUSION_REASONS)
    assert sum(result.counts.values()) + result.included.sum() == len(spoilt)
    assert {note.partition(":")[0] for note in result.notes} == set(EXCLUSION_REASONS)
    assert result.counts["lifted"] == 101
    assert result.counts["standing"] == 101
    assert result.counts["outlier"] == 1
    assert result.reasons[9000] == "outlier"
    assert "outlier: row 9001: Fy is 9000 N, the running median is" in result.notes[-1]
    # Eleven transitions of one second, each with 0.3 s of settling. The conditions were held in all other rows.
    assert result.counts["transition"] < 11 * 130


@pytest.mark.parametrize("signs", ["sae", "adapted-sae"])
def test_signs_have_no_influence(spoilt, signs):
    assert (exclude_rows(spoilt.with_signs(signs)).reasons == exclude_rows(spoilt).reasons).all()


def test_a_cold_tread_is_excluded_until_it_is_warm(make_raw):
    run = make_raw(first=20.0).recording
    rows = np.flatnonzero(exclude_rows(run).reasons == "warm-up")
    assert rows[0] == 0
    assert (np.diff(rows) == 1).all()
    # 40 exp(-t/15 s) falls to 5 K after 31 s, then by 0.33 K/s: three deviations of the noise are reached 1 s earlier.
    assert rows[-1] / 100.0 == pytest.approx(15.0 * np.log(8.0), abs=1.5)


@pytest.mark.parametrize("first", [50.0, 60.0, 75.0])
def test_a_warm_tread_is_not(make_raw, first):
    assert "warm-up" not in exclude_rows(make_raw(first=first).recording).counts


def test_a_tread_that_never_gets_warm_is_not_excluded(raw):
    table = raw.recording.table.assign(T=np.linspace(20.0, 60.0, len(raw.recording)))
    assert exclude_rows(Recording(table, "iso", "a.csv")).counts.get("warm-up", 0) <= 0.5 * len(table) + 1


@pytest.mark.parametrize(
    ("source", "testid"), [("B1464warmup1.dat", ""), ("run1.mat", "Cornering Warm-up"), ("warm up.csv", "")]
)
def test_a_recording_named_warm_up(raw, source, testid):
    result = exclude_rows(Recording(raw.recording.table, "iso", source, {"testid": testid}))
    assert not result.included.any()
    assert "is named" in result.notes[0]
    assert result.counts == {"warm-up": 15600}


def test_transitions_are_excluded_with_their_settling_time(raw):
    result = exclude_rows(raw.recording)
    assert ((result.reasons == "transition") == (transitions(raw.recording, settling=SETTLING_TIME) != "")).all()
    assert result.included.mean() > 0.9


def test_no_row_of_the_virtual_bench_is_excluded():
    recording = VirtualBench(published("trento_hoosier"), seed=4).run(trento_program(signs="sae"))
    result = exclude_rows(recording)
    assert result.included.all()
    assert (result.counts, result.notes) == ({}, ())


@pytest.mark.parametrize(("loads", "counts"), [([0.0, -5.0], {"lifted": 2}), ([], {})])
def test_a_wheel_that_is_always_lifted_and_no_rows(loads, counts):
    table = pd.DataFrame({"Fz": loads, "T": 60.0, "Fy": 1.0}, index=range(len(loads)))
    assert exclude_rows(Recording(table, "iso", "a.csv")).counts == counts


@pytest.mark.parametrize("bad", [np.nan, np.inf])
def test_inputs_that_are_not_finite_are_errors(bad):
    recording = Recording(pd.DataFrame({"Fz": [900.0, bad], "Fy": [1.0, 2.0]}), "iso", "a.csv")
    with pytest.raises(DataError, match=r"^a.csv: row 2: Fz is not finite \(1 of 2 rows\)$"):
        exclude_rows(recording)


def test_almost_no_row_of_the_measured_files_is_excluded(data_folder):
    for name in ("cornering", "drivebrake"):
        result = exclude_rows(read_recording(data_folder / f"{name}.mat"))
        assert result.included.mean() > 0.999
        assert set(result.counts) <= {"transition", "outlier"}


@pytest.mark.parametrize("rate", [4.0, 10.0])
def test_sweeps_of_few_samples_have_neither_steps_nor_outliers(rate):
    """Their rows return to the same slips, and their turning points have few rows."""
    sideways = alpha_sweeps([220.0, 700.0, 1120.0], [0.0, 0.07], sample_rate=rate)
    along = kappa_sweeps([220.0, 700.0, 1120.0], [0.0, 0.05], sample_rate=rate)
    recording = VirtualBench(published("trento_hoosier"), seed=3).run(concatenate([sideways, along]))
    assert exclude_rows(recording).counts == {}
    kinds = {kind for phase in phases(recording) for kind in [phase.kind] if phase.rows.stop - phase.rows.start > 30}
    assert kinds <= {"sweep", "points"}
