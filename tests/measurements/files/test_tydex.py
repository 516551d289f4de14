"""TYDEX: factors and offsets, constants that apply to every row, and files that cannot be used."""

from math import radians

import pytest

from tirefmu.boundary.errors import DataError
from tirefmu.measurements import read_recording

CHANNELS = [
    "MEASNUMB  measurement point              -         1         0         0",
    "RUNTIME   running time                   s         0.01      0         0",
    "LONGSLIP  longitudinal slip              %         0.1       0         0",
    "SLIPANGL  slip angle                     deg       1         0         0.5",
    "INCLANGL  inclination angle              deg       1         0         0",
    "FZW       vertical force                 kN        0.001     0         0",
    "FYW       side force N                   N         2         -10       0",
    "MZW       aligning moment                Nm        1         0         0",
]
CONSTANTS = ["INFLPRES  inflation pressure             bar       2.5", "LONGVEL   speed   km/h   36",
             "MANUFACT  who made it"]  # fmt: skip
ROWS = ["1 0 50 1.5 2 3000 -110 7", "2 1 -50 -0.5 2 3100 110 -7"]


@pytest.fixture
def written(tmp_path):
    def write(channels=CHANNELS, rows=ROWS, constants=CONSTANTS):
        header = ["**HEADER", "RELEASE   1.3", "MEASID    sweep 12", "! a comment", "**COMMENTS", "SLIPANGL of ours"]
        lines = [*header, "**CONSTANTS", *constants, "**MEASURCHANNELS", *channels, "", "**MEASURDATA", *rows, "**END"]
        (tmp_path / "run.tdx").write_text("\n".join(lines), encoding="latin-1")
        return tmp_path / "run.tdx"

    return write


def test_factors_offsets_units_and_constants(written):
    recording = read_recording(written())
    assert recording.signs == "iso"
    assert recording.about["testid"] == "sweep 12"
    expected = {"t": 0.0, "kappa": 0.05, "alpha": radians(2.0), "gamma": radians(2.0), "Fz": 3000.0, "p": 2.5e5,
                "V": 10.0, "Fy": -240.0, "Mz": 7.0}  # fmt: skip
    assert recording.table.iloc[0].to_dict() == pytest.approx(expected)
    assert recording.table["t"].tolist() == [0.0, 0.01]
    assert recording.table["Fy"].iloc[1] == 200.0


def test_a_measured_channel_takes_precedence_over_a_constant(written):
    channels = [*CHANNELS, "INFLPRES  inflation pressure  bar  1  0  0"]
    recording = read_recording(written(channels, [row + " 2.2" for row in ROWS]))
    assert recording.table["p"].tolist() == pytest.approx([2.2e5, 2.2e5])


@pytest.mark.parametrize(
    ("changed", "expected"),
    [
        ({"rows": ["1 0 50 1.5 2 3000 -110"]}, r"line 22: 7 cells for 8 channels"),
        ({"rows": ["1 0 50 1.5 2 3ooo -110 7"]}, r"line 22: channel FZW: '3ooo' is not a number"),
        ({"rows": ["1 0 50 nan 2 3000 -110 7"]}, r"line 22: SLIPANGL: alpha is NaN"),
        ({"rows": []}, "no rows"),
        ({"channels": [line.replace("deg ", "stone ") for line in CHANNELS]}, r"line 15: .*unknown unit 'stone'"),
        (
            {"channels": [line.replace("FZW", "FZC") for line in CHANNELS]},
            r"no channel FZW \(Fz\); forces in the axes C",
        ),
    ],
)
def test_bad_files(written, changed, expected):
    with pytest.raises(DataError, match=expected) as caught:
        read_recording(written(**changed))
    assert "\n" not in str(caught.value)


def test_a_file_that_is_no_tydex(tmp_path):
    (tmp_path / "a.tdx").write_text("alpha,Fz\n1,2\n")
    with pytest.raises(DataError, match=r"no section \*\*MEASURCHANNELS: not a TYDEX file"):
        read_recording(tmp_path / "a.tdx")
