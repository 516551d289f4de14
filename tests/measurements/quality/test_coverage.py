"""Each lack of information is reported once; a complete recording has no notes."""

import numpy as np
import pandas as pd
import pytest

from tirefmu.measurements import (
    Recording,
    VirtualBench,
    alpha_sweeps,
    coverage,
    coverage_notes,
    read_recording,
    small_tire_program,
    trento_program,
)
from tirefmu.tires import published


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
        (sweep(rows=10), ["a.csv: 10 rows are fewer than a fit of one force needs"]),
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
