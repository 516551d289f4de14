"""CSV and Parquet: a round trip preserves every bit, and invalid tables give one clear line."""

import re
import shlex
import sys

import numpy as np
import pandas as pd
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from tirefmu.boundary.errors import DataError, TirefmuError, UnknownName
from tirefmu.measurements import Recording, read_recording, recording_from, write_table
from tirefmu.measurements.files.columns.content import MAX_COLUMNS

finite = st.floats(allow_nan=False, allow_infinity=False)


@pytest.fixture
def written(tmp_path):
    def write(text: str, name: str = "table.csv") -> str:
        (tmp_path / name).write_bytes(text.encode())
        return str(tmp_path / name)

    return write


def complaint(path: str, **options) -> str:
    with pytest.raises(TirefmuError) as caught:
        read_recording(path, **options)
    assert "\n" not in str(caught.value)
    return str(caught.value)


@pytest.mark.parametrize("kind", ["csv", "parquet"])
@settings(suppress_health_check=[HealthCheck.function_scoped_fixture, HealthCheck.too_slow], deadline=None)
@given(rows=st.lists(st.tuples(finite, finite, finite), min_size=1, max_size=20))
def test_round_trip_to_the_bit(rows, kind, tmp_path):
    if kind == "parquet":
        pytest.importorskip("pyarrow")
    table = pd.DataFrame(rows, columns=["alpha", "Fz", "Fy"])
    path = tmp_path / f"table.{kind}"
    write_table(table, path)
    back = read_recording(path)
    assert back.table.to_numpy().tobytes() == table.to_numpy().tobytes()
    assert (back.signs, back.source) == ("iso", path.name)


@pytest.mark.parametrize("separator", [",", ";", "\t", " , "])
def test_separators_comments_blank_lines_and_marks(written, separator):
    lines = ["\ufeff# made by hand", "", "kappa,Fz,remark", "0.1,900,first", "", " -0.1,901 ,", ""]
    recording = read_recording(written("\r\n".join(lines).replace(",", separator)))
    assert recording.table["kappa"].tolist() == [0.1, -0.1]
    assert recording.table["Fz"].tolist() == [900.0, 901.0]
    assert recording.table["remark"].iloc[0] == "first"


def test_declared_units(written):
    path = written("alpha [deg],Fz [kN],p [kPa],V [km/h],T [deg F],kappa [%],lap [m]\n90,1.5,83,36,212,10,7\n")
    recording = read_recording(path)
    expected = {"alpha": np.pi / 2, "Fz": 1500.0, "p": 83e3, "V": 10.0, "T": 100.0, "kappa": 0.1, "lap [m]": 7.0}
    assert recording.table.iloc[0].to_dict() == pytest.approx(expected)
    assert recording.about["declared"] == "alpha Fz p V T kappa"


def test_signs_are_those_declared(written):
    assert read_recording(written("Fz\n-1\n"), signs="sae").signs == "sae"
    with pytest.raises(UnknownName, match="unknown sign convention 'SEA'"):
        read_recording(written("Fz\n1\n"), signs="SEA")


def test_outputs_may_be_unmeasured_and_columns_unknown(written):
    recording = read_recording(written("kappa,Fx,F_x0,kind,alpha_y\n0.1,,1,purex,2\n0.2,3,4,,5\n"))
    assert np.isnan(recording.table["Fx"].iloc[0])
    assert list(recording.table) == ["kappa", "Fx", "F_x0", "kind", "alpha_y"]
    assert recording.table["kind"].iloc[0] == "purex"


def test_names_that_are_accepted(written):
    """A similar name if the channel is present, a separator at the end of each line, the index of another program."""
    assert list(read_recording(written("p,P,Fz,FX\n1e5,3,900,4\n")).table) == ["p", "P", "Fz", "FX"]
    assert list(read_recording(written("kappa,Fz,\n0.1,900,\n")).table) == ["kappa", "Fz"]
    assert list(read_recording(written(",Fz\n0,900\n")).table) == ["column 1", "Fz"]


def test_inputs_by_their_names_in_files_of_the_bench(written):
    """The names of a quantity that the bench does not measure in SI units need a unit."""
    read = read_recording(written("ET,SL,SA [deg],IA [deg],FZ,P [kPa],TSTC,FX\n1,0.1,90,0,900,83,61,5\n"))
    row = {"t": 1.0, "kappa": 0.1, "alpha": np.pi / 2, "gamma": 0.0, "Fz": 900.0, "p": 83e3, "T": 61.0, "Fx": 5.0}
    assert read.signs == "sae"
    assert read.table.iloc[0].to_dict() == pytest.approx(row)
    assert read.about["declared"].split() == ["alpha", "gamma", "p"]
    assert "column 'P' is not a channel" in complaint(written("alpha,P\n0.1,83\n"))
    assert "column 'T' occurs 2 times" in complaint(written("alpha,TSTC,TSTC [deg F]\n0.1,60,140\n"))
    both = read_recording(written("alpha,T,TSTC,P [kPa],p\n0.1,60,61,83,80e3\n"))
    assert list(both.table) == ["alpha", "T", "TSTC", "P [kPa]", "p"]


@pytest.mark.parametrize("column", ["SlipAngle", "F_z"])
def test_a_column_that_looks_like_a_missing_input_is_refused_in_memory_too(written, column):
    assert f"column {column!r} is not a channel: did you mean" in complaint(written(f"kappa,{column}\n0.1,4\n"))
    table = pd.DataFrame({"kappa": [0.1], column: 4.0})
    for argument in (table, Recording(table, "iso", "made")):
        with pytest.raises(DataError, match=f"column '{column}' is not a channel: did you mean"):
            recording_from(argument)


@pytest.mark.parametrize(
    "headers",
    [
        {"t": "Time (s)", "alpha": "Slip Angle (deg)", "Fz": "Normal Load (N)", "Fy": "Lateral Force (N)"},
        {"t": "time_ms", "alpha": "alpha_deg", "Fz": "load_kN", "Fy": "side_force_N"},
        {"t": "t", "alpha": "alpha", "Fz": "WheelLoad [kN]", "Fy": "FY"},
    ],
)
def test_the_option_that_a_refusal_names_reads_all_such_columns(tmp_path, headers):
    alpha = 0.15 * np.sin(np.arange(200) / 10.0)
    rows = {
        "t": np.arange(200) / 100.0,
        "alpha": alpha,
        "Fz": np.full(200, 900.0),
        "Fy": -900.0 * np.tanh(20.0 * alpha),
    }
    factors = {"deg": np.degrees(1.0), "kN": 1e-3, "ms": 1e3}
    written = {}
    for name, header in headers.items():
        unit = re.split(r"[ _(\[]", header.rstrip(")]"))[-1]
        written[header] = rows[name] * factors.get(unit, 1.0)
    path = tmp_path / "bench.csv"
    pd.DataFrame(written).to_csv(path, index=False)
    (option,) = re.findall(r"--columns (.*)$", complaint(path))
    columns = dict(text.split("=") for text in shlex.split(option)[0].split(","))
    read = read_recording(path, columns=columns).table
    for name, values in rows.items():
        np.testing.assert_allclose(read[name], values, rtol=1e-12, atol=1e-12)


@pytest.mark.parametrize("column", ["FX", "LateralForce", "Mz_raw"])
def test_a_column_that_looks_like_a_missing_output_is_refused_where_outputs_are_read(column):
    """A table to evaluate may have such a column: the reference tables of other tools have."""
    measured = {"Fx": 1.0, "Fy": 2.0, "Mz": 3.0}
    measured.pop({"FX": "Fx", "LateralForce": "Fy", "Mz_raw": "Mz"}[column])
    recording = recording_from(pd.DataFrame({"kappa": [0.1], column: 4.0, **measured}))
    with pytest.raises(DataError, match=f"column '{column}' is not a channel: did you mean"):
        recording.measured()


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("", "the file is empty"),
        ("alpha,Fz\n", "no rows"),
        ("alpha,Fz\n0.1,900\n\n0.2,9oo\n", "line 4: column Fz: '9oo' is not a number"),
        ("# c\nalpha,Fz\n0.1,900\ntrue,1\n", "line 4: column alpha: 'true' is not a number"),
        ("Fy,Fz\n0.1,900\nx,1\n", "line 3: column Fy: 'x' is not a number"),
        ("alpha;Fz\n0.1;1,250\n", "line 2: column Fz: '1,250' is not a number"),
        ("alpha;Fz\n0,1;1.250\n", "line 2: column alpha: '0,1' is not a number"),
        ("IA,Fz\n0.1,900\n", "'IA' is not a channel: did you mean gamma (rad; 'gamma [deg]' declares degrees)?"),
        ("remark,id\n1,2\n", "no column is a channel: it has 'remark, id'; known are t, kappa,"),
        ("0.0,1.5\n0.1,1.6\n", "no column is a channel: its first row has numbers and no names: write a row of"),
        ("alpha|Fz\n0.1|900\n", "it has 'alpha|Fz': columns are separated by commas, semicolons or tabs; known"),
        ("alpha,Fz\n0.1,900\n,900\n0.1,900\nnan,900\n", "line 3: alpha is NaN (2 of 4 rows)"),
        ("alpha,Fz\n0.1,900\n0.2\n", "line 3: Fz is NaN (1 of 2 rows)"),
        ("alpha,Fz\n0.1,inf\n", "line 2: Fz is infinite (1 of 1 rows)"),
        ("alpha,alpha [deg]\n0.1,900\n", "column 'alpha' occurs 2 times"),
        ("alpha,Fz\n0.1,900\n0.1,900,3\n", "line 3: more cells than the header's 2"),
        ("alpha [dge],Fz\n0.1,900\n", "column alpha: unknown unit 'dge': did you mean deg?"),
    ],
)
def test_bad_tables(written, text, expected):
    path = written(text)
    message = complaint(path)
    assert expected in message
    assert message.startswith(path)


def test_files_that_are_no_tables(tmp_path):
    assert complaint(str(tmp_path / "none.csv")).endswith("none.csv: no such file")
    assert "unknown kind of recording '.xls': did you mean .xlsx? Known are .csv, .parquet" in complaint("a.xls")
    for name in ("run.txt", "run.asc", "run"):
        (tmp_path / name).write_text("alpha,Fz\n", encoding="utf-8")
        assert "read under the name .csv, one of the FSAE TTC under .dat; known are" in complaint(str(tmp_path / name))
    (tmp_path / "run.bin").write_bytes(b"\x00")
    assert "unknown kind of recording '.bin': did you mean" in complaint(str(tmp_path / "run.bin"))
    (tmp_path / "binary.csv").write_bytes(b"alpha\n\xff\xfe\x00")
    assert "not a text file" in complaint(str(tmp_path / "binary.csv"))
    (tmp_path / "folder.csv").mkdir()
    assert "directory" in complaint(str(tmp_path / "folder.csv"))


def test_a_text_named_parquet(written):
    pytest.importorskip("pyarrow")
    assert "cannot be read as Parquet" in complaint(written("alpha\n1\n", "a.parquet"))


def test_parquet_is_checked_like_csv(tmp_path):
    pytest.importorskip("pyarrow")
    path = tmp_path / "a.parquet"
    pd.DataFrame({"alpha [deg]": [1.0, None], "Fz": [900, 901]}).to_parquet(path)
    assert "row 2: alpha is NaN (1 of 2 rows)" in complaint(str(path))
    pd.DataFrame({"alpha": ["0.5", "x"]}).to_parquet(path)
    assert "row 2: column alpha: 'x' is not a number" in complaint(str(path))
    pd.DataFrame({"alpha": [True, False]}).to_parquet(path)
    assert "row 1: column alpha: 'True' is not a number" in complaint(str(path))
    pd.DataFrame({"Fz": pd.array([900, 901], dtype="Int64"), "Fy": pd.array([1, None], dtype="Int64")}).to_parquet(path)
    assert np.isnan(read_recording(path).table["Fy"].iloc[1])


def test_missing_pyarrow_names_the_extra(tmp_path, monkeypatch, without_package):
    pytest.importorskip("pyarrow")
    without_package("pyarrow", "fastparquet")
    path = tmp_path / "a.parquet"
    write_table(pd.DataFrame({"Fz": [1.0]}), path)
    loaded = [name for name in sys.modules if name.partition(".")[0] == "pyarrow"]
    for module in (*loaded, "pyarrow", "fastparquet"):
        monkeypatch.setitem(sys.modules, module, None)
    assert "extra 'parquet'" in complaint(str(path))
    with pytest.raises(DataError, match="extra 'parquet'"):
        write_table(pd.DataFrame({"Fz": [1.0]}), tmp_path / "b.parquet")
    assert [file.name for file in tmp_path.iterdir()] == ["a.parquet"]


class Unwritable:
    def __str__(self) -> str:
        raise OSError(28, "No space left on device")


def test_a_failed_write_preserves_the_old_file_and_creates_no_other(tmp_path):
    path = tmp_path / "out.csv"
    write_table(pd.DataFrame({"Fy": [1.0]}), path)
    before = path.read_bytes()
    rows = [*range(200_000), Unwritable()]  # the invalid cell is reached after much has been written
    with pytest.raises(DataError, match=r"out\.csv: cannot be written \(No space left"):
        write_table(pd.DataFrame({"Fy": pd.Series(rows, dtype=object)}), path)
    assert path.read_bytes() == before
    assert list(tmp_path.iterdir()) == [path]


def test_targets_that_cannot_be_written(tmp_path):
    table = pd.DataFrame({"Fy": [1.0]})
    with pytest.raises(DataError, match=r"known are \.csv, \.parquet"):
        write_table(table, tmp_path / "out.xlsx")
    with pytest.raises(DataError, match="cannot be written"):
        write_table(table, tmp_path / "nowhere" / "out.csv")
    (tmp_path / "out.csv").mkdir()
    with pytest.raises(DataError, match="cannot be written"):
        write_table(table, tmp_path / "out.csv")
    assert [file.name for file in tmp_path.iterdir()] == ["out.csv"]


def test_a_table_of_any_width_is_one_line(tmp_path):
    path = tmp_path / "wide.csv"
    path.write_text("alpha,Fz," + ",".join(f"c{i}" for i in range(MAX_COLUMNS)) + "\n", encoding="ascii")
    with pytest.raises(DataError, match=rf"wide\.csv: {MAX_COLUMNS + 2} columns: at most {MAX_COLUMNS} are read"):
        read_recording(path)
