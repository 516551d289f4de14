"""Each excluded row has a reason. All other rows and the recording do not change."""

import numpy as np
import pandas as pd
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tirefmu.boundary.errors import DataError
from tirefmu.measurements import (
    EXCLUSION_REASONS,
    Recording,
    VirtualBench,
    alpha_sweeps,
    concatenate,
    coverage,
    coverage_notes,
    exclude_rows,
    kappa_sweeps,
    outliers,
    phases,
    read_recording,
    small_tire_program,
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


@pytest.mark.parametrize("rows", [80, 120, 200])
def test_the_peak_of_a_trail_is_no_outlier_without_a_clock(rows):
    """At an assumed rate the running median would span a third of the sweep."""
    alpha = 0.25 * np.sin(np.linspace(0.0, 2.0 * np.pi, rows))
    moment = np.sin(1.2 * np.arctan(9.0 * alpha)) * np.cos(1.1 * np.arctan(8.0 * alpha))
    table = pd.DataFrame({"alpha": alpha, "Fz": 3000.0, "Mz": 60.0 * moment})
    assert outliers(Recording(table, "iso", "a.csv")) == []
    table.loc[rows // 3, "Mz"] = 300.0
    assert [outlier.row for outlier in outliers(Recording(table, "iso", "a.csv"))] == [rows // 3]


# -------------- A value far from the running median of its channel is found in any row; a clean signal has no outliers


#: Larger than any change in the raw run within 0.01 s.
SPIKES = {"alpha": 0.1, "Fz": 1500.0, "p": 30e3, "V": 4.0, "T": 40.0, "Fy": 3000.0, "Mz": 60.0}


@pytest.mark.parametrize("seed", range(3))
def test_a_noisy_bench_has_no_outliers(make_raw, seed):
    assert outliers(make_raw(seed=seed).recording) == []


def test_the_virtual_benches_have_none():
    for tire, program in (("trento_hoosier", trento_program()), ("unicamp_small_tire", small_tire_program())):
        assert outliers(VirtualBench(published(tire), seed=2).run(program)) == []


@settings(max_examples=40)
@given(
    channel=st.sampled_from(list(SPIKES)),
    rows=st.sets(st.integers(0, 1500), min_size=1, max_size=4),
    sign=st.sampled_from([-1.0, 1.0]),
    signs=st.sampled_from(["iso", "sae", "adapted-sae"]),
)
def test_every_spike_is_found_and_only_it(raw, channel, rows, sign, signs):
    # At least ten rows apart: a running median of fifteen rows tolerates seven outliers, not eight.
    at = sorted(row * 10 for row in rows)
    table = raw.recording.table.copy()
    table.loc[at, channel] += sign * SPIKES[channel]
    spoilt = Recording(table, "iso", "a.csv").with_signs(signs)
    found = outliers(spoilt)
    assert [(reading.row, reading.channel) for reading in found] == [(row, channel) for row in at]
    assert [reading.value for reading in found] == spoilt.table[channel].iloc[at].tolist()


def test_missing_values_are_not_outliers_and_hide_none(raw):
    table = raw.recording.table.copy()
    table.loc[::3, "Fy"] = np.nan
    table.loc[700, "Fy"] = 9e3
    assert [(reading.row, reading.channel) for reading in outliers(Recording(table, "iso", "a.csv"))] == [(700, "Fy")]


def test_a_coarse_sensor_has_none(raw):
    speed = 11.2 + 0.003 * (np.random.default_rng(0).random(len(raw.recording)) < 0.1)
    assert outliers(Recording(raw.recording.table.assign(V=speed), "iso", "a.csv")) == []


def test_the_sentence():
    time = np.arange(200) / 100.0
    table = {"t": time, "Fy": np.where(np.arange(200) == 70, 900.0, 100.0)}
    (reading,) = outliers(Recording(pd.DataFrame(table), "iso", "a.csv"))
    assert str(reading) == "row 71: Fy is 900 N, the running median is 100"


# ---------------------------------------- Each lack of information is reported once; a complete recording has no notes


def sweep(rows=500, **columns):
    angle = np.linspace(-0.2, 0.2, rows)
    table = {"t": np.arange(rows) / 100.0, "alpha": angle, "Fz": np.where(np.arange(rows) < rows / 2, 500.0, 900.0)}
    return Recording(pd.DataFrame({**table, "Fy": -900.0 * np.tanh(12.0 * angle), **columns}), "iso", "a.csv")


@pytest.mark.parametrize(
    ("tire", "program"), [("trento_hoosier", trento_program()), ("unicamp_small_tire", small_tire_program())]
)
def test_complete_programs_have_no_missing_conditions(tire, program):
    recording = VirtualBench(published(tire), seed=5).run(program)
    for signs in ("iso", "sae", "adapted-sae"):
        assert coverage_notes(recording.with_signs(signs)) == []


@pytest.mark.parametrize(
    ("recording", "expected"),
    [
        (sweep(), []),
        (sweep(alpha=0.02), ["a.csv: alpha stays at 0.02 rad: Fy shows no slip curve"]),
        (sweep(kappa=0.0, Fx=np.linspace(-1, 1, 500)), ["a.csv: kappa stays at 0: Fx shows no slip curve"]),
        (sweep(Fx=np.linspace(-1, 1, 500)), ["a.csv: kappa is missing: Fx shows no slip curve"]),
        (sweep(Fz=900.0), ["a.csv: only one load (900 N): the influence of load cannot be determined"]),
        (sweep(Mz=0.0), ["a.csv: Mz is 0 in every row: was it measured?"]),
        (sweep(t=-np.arange(500.0)), ["a.csv: t runs backwards in 499 of 499 steps: the rows are not in the order of"]),
        (sweep(Fy=np.nan), []),
    ],
)
def test_each_missing_condition_is_reported_once(recording, expected):
    notes = coverage_notes(recording)
    assert len(notes) == len(expected)
    assert all(note.startswith(start) for note, start in zip(notes, expected, strict=True))


def test_camber_alone_is_a_slip_of_the_side_force():
    assert coverage_notes(sweep(alpha=0.0, gamma=np.linspace(-0.1, 0.1, 500))) == []


def test_coverage_of_a_program():
    recording = VirtualBench(published("trento_hoosier"), seed=1).run(alpha_sweeps([300.0, 900.0], [0.0, 0.05]))
    found = {channel.channel: channel for channel in coverage(recording)}
    assert found["alpha"].swept
    assert found["Fz"].levels == pytest.approx((300.0, 900.0), rel=0.02)
    assert found["gamma"].levels == pytest.approx((0.0, 0.05), abs=0.002)
    assert str(found["Fz"]).startswith("Fz: held at 2 levels, ")
    for channel in found.values():
        assert all(channel.lowest <= level <= channel.highest for level in channel.levels)


def test_no_rows_cover_nothing():
    empty = Recording(pd.DataFrame({"alpha": [], "Fz": []}), "iso", "a.csv")
    assert coverage(empty) == []
    assert coverage_notes(empty) == []


def test_measured_files_have_only_their_known_missing_conditions(data_folder):
    both = [read_recording(data_folder / f"{name}.mat") for name in ("cornering", "drivebrake")]
    assert [coverage_notes(recording) for recording in both] == [
        ["cornering.mat: kappa stays at 0: Fx shows no slip curve"],
        [],
    ]
