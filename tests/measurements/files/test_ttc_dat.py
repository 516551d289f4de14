"""ASCII bench files in all known variants: titles, units lines, USCS, missing channels."""

from math import radians

import numpy as np
import pytest

from tirefmu.boundary.errors import DataError
from tirefmu.measurements import POUND, PSI, read_recording

NAMES = ["ET", "V", "N", "SA", "IA", "RL", "RE", "P", "FX", "FY", "FZ", "MX", "MZ", "TSTI", "TSTC", "TSTO", "AmbTmp",
         "SR", "SL"]  # fmt: skip
SI = ["sec", "kph", "rpm", "deg", "deg", "cm", "cm", "kPa", "N", "N", "N", "N-m", "N-m", "deg C", "deg C", "deg C",
      "deg C", "none", "none"]  # fmt: skip
USCS = ["sec", "mph", "rpm", "deg", "deg", "in", "in", "psi", "lb", "lb", "lb", "lb-ft", "lb-ft", "deg F", "deg F",
        "deg F", "deg F", "none", "none"]  # fmt: skip
ROW = [0.01, 40.0, 400.0, 2.0, 4.0, 25.0, 26.0, 83.0, 10.0, -300.0, -900.0, 5.0, 7.0, 60.0, 61.0, 62.0, 25.0, -0.9,
       0.05]  # fmt: skip
TITLE = "Tire_Name=Somebody's 16x7.5-10\tRim_Width=7\tISO False"


def bench_text(*, title=TITLE, units=SI, drop=(), rows=9, separator="\t", **values):
    columns = [number for number, name in enumerate(NAMES) if name not in drop]
    lines = [] if title is None else [title]
    lines.append(separator.join(NAMES[number] for number in columns))
    if units is not None:
        lines.append(separator.join(units[number] for number in columns))
    cells = dict(zip(NAMES, ROW, strict=True)) | values
    for row in range(rows):
        cells["ET"] = 0.01 * row
        lines.append(separator.join(str(cells[NAMES[number]]) for number in columns))
    return "\n".join(lines) + "\n"


@pytest.fixture
def bench_file(tmp_path):
    def write(name="run.dat", *, text=None, **options):
        (tmp_path / name).write_bytes((bench_text(**options) if text is None else text).encode("latin-1"))
        return tmp_path / name

    return write


@pytest.mark.parametrize("separator", ["\t", "  ", " \t "])
def test_channels_in_si_and_sae(bench_file, separator):
    recording = read_recording(bench_file(separator=separator))
    expected = {"t": 0.08, "kappa": 0.05, "alpha": radians(2), "gamma": radians(4), "Fz": -900.0, "p": 83e3,
                "V": 40 / 3.6,
                "T": 61.0, "T_ambient": 298.15, "Fx": 10.0, "Fy": -300.0, "Mz": 7.0, "Mx": 5.0}  # fmt: skip
    assert recording.table.iloc[-1].to_dict() == pytest.approx(expected)
    assert len(recording) == 9
    assert recording.signs == "sae"
    assert recording.about["units"] == "declared in the file"
    assert "16x7.5-10" in recording.about["tireid"]


@pytest.mark.parametrize(
    ("name", "pressure", "load", "reported"),
    [
        ("A1464raw30.dat", 12.0, -900 * POUND, "assumed USCS: the file's name begins with A"),
        ("B1464raw30.dat", 83.0, -900.0, "assumed SI: the file's name begins with B"),
        ("run.dat", 12.0, -900 * POUND, "assumed USCS: the file declares none, and P is about 12"),
        ("run.dat", 83.0, -900.0, "assumed SI: the file declares none"),
    ],
)
def test_units_assumed_where_none_are_declared(bench_file, name, pressure, load, reported):
    recording = read_recording(bench_file(name, units=None, P=pressure))
    assert recording.table["Fz"].iloc[0] == pytest.approx(load)
    assert recording.about["units"].startswith(reported)
    assert len(recording) == 9


def test_the_same_bench_in_both_unit_systems_is_the_same_recording(bench_file):
    pounds = {"V": 40 / 3.6 / 0.44704, "P": 83e3 / PSI, "TSTC": 61.0 * 1.8 + 32.0, "AmbTmp": 25.0 * 1.8 + 32.0}
    pounds |= {name: value / POUND for name, value in (("FX", 10.0), ("FY", -300.0), ("FZ", -900.0))}
    pounds |= {name: value / POUND / 0.3048 for name, value in (("MX", 5.0), ("MZ", 7.0))}
    si, uscs = read_recording(bench_file("B1run1.dat")), read_recording(bench_file("A1run1.dat", units=USCS, **pounds))
    np.testing.assert_allclose(uscs.table.to_numpy(), si.table.to_numpy(), rtol=1e-12)


def test_axes_that_the_title_names(bench_file):
    path = bench_file(title="Tire X\tISO True")
    assert read_recording(path).signs == "iso"
    assert read_recording(path, signs="sae").signs == "sae"
    assert read_recording(bench_file(title="a tire of the isolated kind")).signs == "sae"


def test_titles_that_are_absent_long_or_not_utf8(bench_file):
    for title in (None, "one\ntwo\n\nthree", "Reifen für 20 \xb0C"):
        assert len(read_recording(bench_file(title=title))) == 9


def test_what_may_be_missing(bench_file):
    recording = read_recording(bench_file(drop=["V", "N", "P", "TSTC", "MX", "AmbTmp", "SR"]))
    assert list(recording.table) == ["t", "kappa", "alpha", "gamma", "Fz", "Fx", "Fy", "Mz"]


def test_warm_up_files_without_slip_roll_freely(bench_file):
    recording = read_recording(bench_file(drop=["SL"]))
    assert (recording.table["kappa"] == 0.0).all()
    assert "rolls freely" in recording.about["kappa"]


@pytest.mark.parametrize(
    ("options", "expected"),
    [
        ({"drop": ["SL"], "FX": -700.0}, r"no channel SL \(kappa\), and FX is that of a driven wheel \(SR is another"),
        ({"drop": ["FZ"]}, r"no channel FZ \(Fz\)"),
        ({"drop": ["FX", "FY", "MZ", "MX"]}, "nothing was measured"),
        ({"rows": 0}, "no rows"),
        ({"SA": "nan"}, r"line 4: SA: alpha is NaN \(9 of 9 rows\)"),
        ({"SA": "2,5"}, "line 4: channel SA: '2,5' is not a number"),
        ({"SA": ""}, "line 4: 18 cells for 19 channels"),
        ({"units": [*SI[:10], "stone", *SI[11:]]}, "channel FZ: unknown unit 'stone'"),
        ({"units": [*SI[:10], "deg", *SI[11:]]}, "channel FZ: unit 'deg' measures angle, not force"),
        ({"units": [*SI[:-1], ""]}, "line 3: 18 units for 19 channels"),
        ({"text": ""}, "the file is empty"),
        ({"text": "alpha Fz\n1 2\n"}, "no line has the channel names"),
        ({"text": "ET SA\0"}, "not a text file"),
    ],
)
def test_bad_files(bench_file, options, expected):
    path = bench_file(**options)
    with pytest.raises(DataError, match=expected) as caught:
        read_recording(path)
    assert str(caught.value).startswith(str(path))
    assert "\n" not in str(caught.value)


def test_lines_are_counted_as_editors_do(bench_file):
    text = bench_text(title="one\n\nthree").replace("\n", "\n\n")
    lines = text.splitlines()
    at = max(number for number, line in enumerate(lines, start=1) if "83.0" in line)
    lines[at - 1] = lines[at - 1].replace("83.0", "83.O")
    with pytest.raises(DataError, match=f"line {at}: channel P: '83.O' is not a number"):
        read_recording(bench_file(text="\n".join(lines)))


def test_a_channel_under_another_name_is_not_ignored(bench_file):
    renamed = bench_text().replace("\tP\t", "\tPressure\t", 1)
    with pytest.raises(DataError, match=r"run\.dat: channel 'Pressure' is not one of a bench file: did you mean P\?"):
        read_recording(bench_file(text=renamed))
