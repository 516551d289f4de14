"""Tables with the columns of FSAE TTC files, and Excel workbooks."""

import numpy as np
import pandas as pd
import pytest

from tirefmu.boundary.errors import DataError
from tirefmu.measurements import CHANNELS, read_recording

ROWS = pd.DataFrame(
    {"ET": [0.0, 0.01], "V": 36.0, "SA": [2.0, -2.0], "IA": 4.0, "P": 80.0, "FX": 10.0, "FY": -300.0, "FZ": -900.0,
     "MX": 5.0, "MZ": 7.0, "TSTC": 60.0, "SL": 0.05, "AMBTMP": 20.0, "RST": 25.0, "MY": 3.0,
     "NFX": "text"}
)  # fmt: skip
EXPECTED = {
    "t": 0.0, "kappa": 0.05, "alpha": np.radians(2.0), "gamma": np.radians(4.0), "Fz": -900.0, "p": 80e3, "V": 10.0,
    "T": 60.0, "T_ambient": 293.15, "T_road": 298.15, "Fx": 10.0, "Fy": -300.0, "Mz": 7.0, "Mx": 5.0, "My": 3.0,
}  # fmt: skip


@pytest.fixture(params=["csv", "parquet", "xlsx"])
def written(request, tmp_path):
    """Return a function that writes a table in a format."""

    def write(table):
        path = tmp_path / f"run.{request.param}"
        if request.param == "csv":
            table.to_csv(path, index=False)
        elif request.param == "parquet":
            table.to_parquet(pytest.importorskip("pyarrow") and path)
        else:
            table.to_excel(pytest.importorskip("openpyxl") and path, index=False)
        return path

    return write


def test_a_table_with_ttc_columns_has_their_units_and_signs(written):
    assert EXPECTED.keys() == {name for name, channel in CHANNELS.items() if channel.bench_names}
    recording = read_recording(written(ROWS))
    assert recording.table.iloc[0].to_dict() == pytest.approx(EXPECTED)
    assert (recording.signs, recording.about["units"]) == ("sae", "assumed SI: the file declares none")
    assert read_recording(written(ROWS), signs="iso").signs == "iso"


def test_headers_and_options_declare_other_units(written):
    pounds = ROWS.rename(columns={"FZ": "FZ [lb]", "P": "P [psi]"}).assign(FYC=1.0)
    read = read_recording(written(pounds), columns={"Fy": "FYC", "alpha": "-SA"}, units={"gamma": "rad", "Fy": "kN"})
    first = read.table.iloc[0]
    assert first[["Fz", "p"]].tolist() == pytest.approx([-4003.4, 551581.0], rel=1e-4)
    assert first[["Fy", "alpha", "gamma"]].tolist() == pytest.approx([1000.0, -np.radians(2.0), 4.0])
    with pytest.raises(DataError, match=r"no column 'FYD' \(Fy\): did you mean FY"):
        read_recording(written(pounds), columns={"Fy": "FYD"})


def test_a_workbook_of_the_contract_is_a_table(tmp_path):
    path = tmp_path / "a.xlsx"
    pytest.importorskip("openpyxl")
    pd.DataFrame({"alpha [deg]": [1.0, 2.0], "Fz": [900, 901], "Fy": [-1.0, None]}).to_excel(path, index=False)
    table = read_recording(path).table
    assert table["alpha"].tolist() == pytest.approx(np.radians([1.0, 2.0]))
    assert table["Fy"].isna().tolist() == [False, True]
    pd.DataFrame({"alpha": [0.1, "high"], "Fz": 900.0}).to_excel(path, index=False)
    with pytest.raises(DataError, match=r"a.xlsx: row 3: column alpha: 'high' is not a number"):
        read_recording(path)
    path.write_bytes(b"not a workbook")
    with pytest.raises(DataError, match="cannot be read as an Excel workbook"):
        read_recording(path)


def test_excel_without_its_package(tmp_path, without_package):
    without_package("openpyxl")
    (tmp_path / "a.xlsx").write_bytes(b"PK")
    with pytest.raises(DataError, match=r"Excel needs openpyxl, which the extra 'excel' installs"):
        read_recording(tmp_path / "a.xlsx")


OUTPUTS = [name for name, declared in CHANNELS.items() if declared.role == "output"]


@pytest.mark.parametrize("cell", ["", "nan", "N/A", "--"])
@pytest.mark.parametrize("empty", [["Mz"], ["Fx", "Mx"], []])
def test_an_output_without_a_value_is_stated(tmp_path, cell, empty):
    row = {"alpha": "0.1", "Fz": "900", **dict.fromkeys(OUTPUTS, "1.5"), **dict.fromkeys(empty, cell)}
    lines = [",".join(row), *[",".join(row.values())] * 3]
    (tmp_path / "a.csv").write_text("\n".join(lines), encoding="utf-8")
    recording = read_recording(tmp_path / "a.csv")
    assert recording.about.get("ignored", "") == (f"{', '.join(empty)} without a value" if empty else "")
    assert set(recording.measured()) == set(OUTPUTS) - set(empty)
