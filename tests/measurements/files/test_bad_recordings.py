"""Errors in recordings beside those of docs/awkward_inputs.md: one clear line, or notes on missing information."""

import numpy as np
import pandas as pd
import pytest

from tirefmu.boundary.errors import DataError, TirefmuError
from tirefmu.measurements import check_plausible, column_notes, coverage_notes, read_recording
from tirefmu.measurements.findings.two_tires import two_tires


def good_table(rows=600):
    """Return sweeps of slip angle at two loads, then of slip, in iso."""
    ramp = np.tile(np.linspace(-1.0, 1.0, rows // 4), 4)
    lateral = np.arange(rows) < rows // 2
    return pd.DataFrame(
        {
            "t": np.arange(rows) / 100.0,
            "kappa": np.where(lateral, 0.0, 0.2 * ramp),
            "alpha": np.where(lateral, 0.2 * ramp, 0.0),
            "gamma": 0.0,
            "Fz": np.where(np.arange(rows) % (rows // 2) < rows // 4, 500.0, 900.0),
            "p": 83e3,
            "Fx": np.where(lateral, 0.0, 900.0 * np.tanh(4.0 * ramp)),
            "Fy": np.where(lateral, -900.0 * np.tanh(3.0 * ramp), 0.0),
            "Mz": np.where(lateral, 20.0 * np.sin(6.0 * ramp) * np.exp(-6.0 * np.abs(ramp)), 0.0),
        }
    )


@pytest.fixture
def messages(tmp_path):
    """Return all messages on a table: the error, or the notes."""

    def messages_of(table, signs="iso"):
        table.to_csv(tmp_path / "a.csv", index=False)
        try:
            recording = read_recording(tmp_path / "a.csv", signs=signs)
            check_plausible(recording)
        except TirefmuError as error:
            return [str(error)]
        return column_notes(recording) + coverage_notes(recording) + two_tires([recording])

    return messages_of


def test_a_good_table_has_no_messages(messages):
    assert messages(good_table()) == []


@pytest.mark.parametrize(
    ("change", "expected"),
    [
        # What is missing, and what does not vary
        (lambda table: table.drop(columns="kappa"), "kappa is missing: Fx shows no slip curve"),
        (lambda table: table.iloc[:10], "10 rows are fewer than a fit of one force needs"),
        (lambda table: table.iloc[:0], "no rows"),
        # Units
        (lambda table: table.assign(gamma=4.0), "gamma reaches 4 rad: in degrees?"),
        (lambda table: table.assign(kappa=20.0 * table["kappa"]), "a wheel that turns backwards: in percent?"),
        (lambda table: table.assign(V=40.0 * 3.6 + 7.0), "V reaches 151 m/s: in km/h?"),
        # Signs
        (lambda table: table.assign(Fy=-table["Fy"]), "in iso it falls: Fy has the other sign (--columns Fy=-Fy)"),
        (lambda table: table.assign(Fx=-table["Fx"]), "kappa has the other sign (--columns kappa=-kappa), or Fx"),
        # Rows
        (lambda table: table.assign(alpha=table["alpha"].where(table.index % 2 < 1)), "line 3: alpha is NaN (300"),
        (lambda table: table.assign(Fz=5e6), "Fz reaches 5e+06 N: in another unit?"),
        (lambda table: pd.concat([table, table.assign(Fz=9.0 * table["Fz"])]), "two tires? a.csv: the clock restarts"),
    ],
)  # fmt: skip
def test_each_fault_is_reported(messages, change, expected):
    lines = messages(change(good_table()))
    assert any(expected in line for line in lines), lines
    assert not any("\n" in line for line in lines)
    assert all(line.startswith(("a.csv", "two tires? a.csv")) or "a.csv: " in line for line in lines)


def test_signs_of_a_bench_in_a_table_declared_as_iso(messages):
    table = good_table().assign(alpha=-good_table()["alpha"], Fz=-good_table()["Fz"])
    assert "SAE signs?" in messages(table.assign(Fy=-table["Fy"], Mz=-table["Mz"]))[0]
    assert messages(table.assign(Fy=-table["Fy"], Mz=-table["Mz"]), signs="sae") == []


def test_a_restarted_clock_separates_the_segments(tmp_path):
    table = pd.concat([good_table(), good_table()])
    table.to_csv(tmp_path / "a.csv", index=False)
    assert read_recording(tmp_path / "a.csv").segments() == [slice(0, 600), slice(600, 1200)]


def test_declared_percent_is_used(tmp_path):
    table = good_table().assign(kappa=20.0 * good_table()["kappa"]).rename(columns={"kappa": "kappa [1]"})
    table.to_csv(tmp_path / "a.csv", index=False)
    check_plausible(read_recording(tmp_path / "a.csv"))


def test_an_unmeasured_fx_does_not_affect_the_slip(tmp_path):
    table = good_table().assign(kappa=-5.0).drop(columns="Fx")
    table.to_csv(tmp_path / "a.csv", index=False)
    check_plausible(read_recording(tmp_path / "a.csv"))
    table.assign(Fx=1.0).to_csv(tmp_path / "a.csv", index=False)
    with pytest.raises(DataError, match="turns backwards"):
        check_plausible(read_recording(tmp_path / "a.csv"))
