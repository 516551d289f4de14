"""FSAE TTC files: without units, with unusual fields, with missing channels; and measured ones."""

import warnings
from math import radians

import numpy as np
import pandas as pd
import pytest
from scipy.io import savemat

from tirefmu.boundary.errors import DataError
from tirefmu.measurements import check_plausible, column_notes, levels, read_recording

ROWS = 12
SI = {"ET": "sec", "V": "kph", "SA": "deg", "IA": "deg", "P": "kPa", "FX": "N", "FY": "N", "FZ": "N",
      "MX": "N-m", "MZ": "N-m", "TSTC": "deg C", "SL": "none", "SR": "none", "N": "rpm"}  # fmt: skip
VALUES = {"ET": 0.01, "V": 36.0, "SA": 2.0, "IA": 4.0, "P": 80.0, "FX": 10.0, "FY": -300.0, "FZ": -900.0,
          "MX": 5.0, "MZ": 7.0, "TSTC": 60.0, "SL": 0.05, "SR": -1.0, "N": 400.0}  # fmt: skip


def bench_file(folder, name="run.mat", *, units=SI, drop=(), **fields):
    """Write a bench file: column vectors, and a channel struct as MATLAB's cell arrays make it."""
    columns = {key: np.full((ROWS, 1), value) for key, value in VALUES.items() if key not in drop}
    columns["ET"] = 0.01 * np.arange(ROWS)[:, None] if "ET" in columns else np.empty((0, 0))
    if units is not None:
        names = [key for key in units if key not in drop]
        channel = {
            "name": np.array(names, dtype=object),
            "units": np.array([units[key] for key in names], dtype=object),
        }
        columns["channel"] = channel
    columns |= fields
    columns = {key: value for key, value in columns.items() if key not in drop}
    savemat(folder / name, columns)
    return folder / name


def test_channels_in_si_and_sae(tmp_path):
    path = bench_file(tmp_path, tireid="Round 9", testid="Drive", source="FSAE TTC", RUN=np.zeros((3, 1)))
    recording = read_recording(path)
    expected = {"t": 0.0, "kappa": 0.05, "alpha": radians(2), "gamma": radians(4), "Fz": -900.0, "p": 80e3,
                "V": 10.0, "T": 60.0, "Fx": 10.0, "Fy": -300.0, "Mz": 7.0, "Mx": 5.0}  # fmt: skip
    assert recording.table.iloc[0].to_dict() == pytest.approx(expected)
    assert recording.signs == "sae"
    assert recording.about["credit"] == "FSAE TTC"
    assert recording.about["tireid"] == "Round 9"
    assert recording.about["units"] == "declared in the file"
    iso = recording.with_signs("iso").table.iloc[0]
    assert (iso["Fz"], iso["Fy"], iso["Mz"]) == (900.0, 300.0, -7.0)
    assert iso["alpha"] == -radians(2)


def test_a_file_without_units_and_with_names_in_another_case(tmp_path):
    path = bench_file(tmp_path, "A1464run30.mat", units=None, drop=["TSTC"], tstc=np.full((ROWS, 1), 140.0))
    recording = read_recording(path)
    assert recording.table["T"].iloc[0] == pytest.approx(60.0)
    assert recording.table["Fz"].iloc[0] == pytest.approx(-4003.4, rel=1e-5)
    assert recording.about["units"].startswith("assumed USCS")
    assert recording.about["declared"] == ""


@pytest.mark.parametrize("name", ["tireid", "testid"])
@pytest.mark.parametrize(
    ("value", "expected"),
    [
        ("Round 9", "Round 9"),
        (np.array(["Round 9"], dtype=object), "Round 9"),
        ({"maker": "Hoosier", "size": "16x7.5-10", "rim": ""}, "Hoosier, 16x7.5-10"),
        (np.empty((0, 0)), ""),
    ],
)
def test_identities_in_every_form(tmp_path, name, value, expected):
    assert read_recording(bench_file(tmp_path, **{name: value})).about[name] == expected


def test_channels_within_a_struct(tmp_path):
    columns = {key: np.full((ROWS, 1), value) for key, value in VALUES.items()}
    savemat(tmp_path / "a.mat", {"data": columns | {"tireid": "inside"}, "note": "made by hand"})
    recording = read_recording(tmp_path / "a.mat")
    assert len(recording) == ROWS
    assert recording.about["tireid"] == "inside"


@pytest.mark.parametrize(
    ("options", "expected"),
    [
        ({"drop": ["FZ"], "FZN": np.ones((ROWS, 1))}, r"no channel FZ \(Fz\): did you mean FZN\?"),
        ({"SA": np.ones((ROWS + 1, 1))}, rf"channel SA has {ROWS + 1} rows, ET has {ROWS}"),
        ({"SA": np.r_[np.ones(3), np.full(9, np.nan)][:, None]}, r"row 4: SA: alpha is NaN \(9 of 12 rows\)"),
        ({"units": SI | {"FZ": "stone"}}, "channel FZ: unknown unit 'stone'"),
    ],
)
def test_bad_files(tmp_path, options, expected):
    path = bench_file(tmp_path, **options)
    with pytest.raises(DataError, match=expected) as caught:
        read_recording(path)
    assert str(caught.value).startswith(str(path))


@pytest.fixture(scope="session")
def matio():
    """Return the optional package; importing it warns of an option of pandas."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        return pytest.importorskip("matio")


@pytest.mark.parametrize("version", ["v7", "v7.3"])
@pytest.mark.parametrize("form", ["vectors", "table"])
def test_newer_forms_hold_the_same_recording(tmp_path, matio, version, form):
    plain = bench_file(tmp_path, "plain.mat", tireid="Round 9")
    columns = {key: np.full((ROWS, 1), value) for key, value in VALUES.items()}
    columns["ET"] = 0.01 * np.arange(ROWS)[:, None]
    channel = {"name": np.array(list(SI), dtype=object), "units": np.array(list(SI.values()), dtype=object)}
    table = pd.DataFrame({key: value[:, 0] for key, value in columns.items()})
    content = {"data": table} if form == "table" else columns
    path = tmp_path / f"{form}.mat"
    matio.save_to_mat(str(path), {**content, "channel": channel, "tireid": "Round 9"}, version=version)
    newer, older = read_recording(path), read_recording(plain)
    pd.testing.assert_frame_equal(newer.table, older.table)
    assert newer.signs == older.signs
    assert newer.about == older.about


def test_a_table_with_contract_names_is_read_like_a_csv(tmp_path, matio):
    table = pd.DataFrame({"alpha": [0.1, 0.2], "Fz": [900.0, 901.0], "Fy": [-800.0, -900.0]})
    matio.save_to_mat(str(tmp_path / "a.mat"), {"sweep": table}, version="v7")
    recording = read_recording(tmp_path / "a.mat")
    pd.testing.assert_frame_equal(recording.table, table)
    assert recording.signs == "iso"


def test_missing_mat_io_names_the_extra(tmp_path, without_package):
    without_package("matio")
    (tmp_path / "b.mat").write_bytes(b"MATLAB 7.3 MAT-file".ljust(124) + b"\x00\x02IM" + b"\x89HDF" * 50)
    with pytest.raises(DataError, match=r"MATLAB 7.3 \(HDF5\) files need mat-io, .*'tirefmu\[matlab\]'"):
        read_recording(tmp_path / "b.mat")


@pytest.fixture(scope="module", params=["cornering", "drivebrake"])
def measured(request, data_folder):
    return read_recording(data_folder / f"{request.param}.mat")


def test_real_files_are_plausible_in_every_convention(measured):
    assert len(measured) == {"cornering.mat": 59965, "drivebrake.mat": 76484}[measured.source]
    assert "Tire Test" in measured.about["credit"]
    for signs in ("sae", "iso", "adapted-sae"):
        turned = measured.with_signs(signs)
        check_plausible(turned)
        assert column_notes(turned) == []


def test_real_files_misread_are_noticed(measured):
    as_iso = type(measured)(measured.table, "iso", measured.source, measured.about)
    with pytest.raises(DataError, match=r"Fz is negative in 100 % of the rows: SAE signs\? \(--signs sae\)"):
        check_plausible(as_iso)
    iso = measured.with_signs("iso")
    notes = column_notes(type(iso)(iso.table, "adapted-sae", iso.source))
    assert len(notes) == 1
    assert ": the data fit iso (--signs iso), camber thrust -1" in notes[0]


def test_real_levels(measured):
    table = measured.with_signs("iso").table
    cornering = measured.source == "cornering.mat"
    loads = [530, 1093, 1656, 2190, 2750] if cornering else [515, 1650, 2184, 2740]
    assert levels(table["Fz"]) == pytest.approx(loads, rel=0.02)
    assert np.degrees(levels(table["gamma"])) == pytest.approx([0.0, 1.6, 3.2], abs=0.06)
    assert levels(table["p"]) == pytest.approx([69.5e3, 83.2e3, 97e3], rel=0.01)
    assert levels(table["V"]) == pytest.approx([11.18], rel=0.01)
    if cornering:
        assert levels(table["alpha"]) == []
    else:
        assert np.degrees(levels(table["alpha"])) == pytest.approx([0.05, 2.44, 4.84], abs=0.02)
        assert levels(table["kappa"]) == []


def test_real_segments_are_single_sweeps(measured):
    lengths = [segment.stop - segment.start for segment in measured.segments()]
    assert len(lengths) == {"cornering.mat": 48, "drivebrake.mat": 139}[measured.source]
    assert sum(lengths) == len(measured)
