"""Files as other programs save them: encodings, separators, places of units, blank rows, clocks, nested structs."""

from __future__ import annotations

import re

import numpy as np
import pandas as pd
import pytest
from scipy.io import savemat

from tirefmu.applications.driving.inputs.log import read_log
from tirefmu.boundary.errors import DataError
from tirefmu.measurements import read_recording
from tirefmu.measurements.files import native_reader
from tirefmu.measurements.files.columns.cells import numbers
from tirefmu.measurements.files.columns.content import name_and_unit
from tirefmu.measurements.files.reading import read_content

T = np.arange(200) * 0.05
STEER = 0.1 * np.sin(2.0 * T)
LOG = pd.DataFrame({"t": T, "steer": STEER, "speed": 15.0, "yaw_rate": 0.5 * STEER, "ay": 7.0 * STEER})


def rows(table: pd.DataFrame, separator: str = ",") -> list[str]:
    return [separator.join(map(repr, row)) for row in table.to_numpy().tolist()]


def assert_is_the_log(log) -> None:
    for name in ("steer", "speed", "yaw_rate", "ay"):
        t, values = log.channels[name]
        np.testing.assert_allclose(t, T, atol=1e-9)
        np.testing.assert_allclose(values, LOG[name], rtol=1e-12, atol=1e-12)


@pytest.mark.parametrize("encoding", ["utf-8", "utf-8-sig", "latin-1", "cp1252", "utf-16"])
@pytest.mark.parametrize("blank", ["", ",,,,", '"","","","",""'])
def test_a_text_of_any_encoding_with_blank_rows(tmp_path, encoding, blank):
    table = LOG.assign(steer=np.degrees(LOG["steer"]), yaw_rate=np.degrees(LOG["yaw_rate"]))
    lines = ['"Format","MoTeC CSV File"', "", ",".join(table), "s,°,m/s,°/s,m/s²", blank, *rows(table)]
    (tmp_path / "a.csv").write_bytes("\n".join(lines).encode(encoding))
    assert_is_the_log(read_log(tmp_path / "a.csv"))


PATTERNS = ["{0} [{1}]", "{0} ({1})", "{0} {{{1}}}", "[{1}] {0}", "CAN1 [{1}] {0}", "{0}/{1}", "{0} / {1}", "{0}/({1})",
            "{0} / [{1}]", "{0}, {1}", "{0} in {1}"]  # fmt: skip


@pytest.mark.parametrize("pattern", PATTERNS)
@pytest.mark.parametrize("separator", [",", ";", "\t"])
def test_a_unit_is_found_wherever_a_header_has_it(tmp_path, pattern, separator):
    headers = {name: pattern.format(name, unit) for name, unit in (("speed", "km/h"), ("steer", "deg"))}
    table = LOG.assign(speed=3.6 * LOG["speed"], steer=np.degrees(LOG["steer"])).rename(columns=headers)
    columns = headers if pattern.startswith("CAN1") else None
    assert_is_the_log(read_log(table, columns))
    assert_is_the_log(read_log(table, headers))
    stated = {name: f"{header} [{unit}]" for (name, header), unit in zip(headers.items(), ("m/s", "rad"), strict=True)}
    assert_is_the_log(read_log(LOG.rename(columns=headers), stated))
    path = tmp_path / "a.csv"
    names = separator.join(f'"{name}"' for name in table)
    for comma in (False, True) if separator != "," else (False,):
        lines = [line.replace(".", ",") if comma else line for line in rows(table, separator)]
        path.write_text("\n".join([names, *lines]), encoding="utf-8")
        assert_is_the_log(read_log(path, columns))


NOT_UNITS = ["Fz/Fx", "run2/FZ", "/imu/g", "a/b/N", "Force/2", "kappa/1", "gyro[2]", "lap, pit", "v_km/h", "Yaw deg/s",
             "YawDeg/s", "km/h"]  # fmt: skip


@pytest.mark.parametrize("header", NOT_UNITS)
def test_what_is_behind_a_slash_is_no_unit(header):
    assert name_and_unit(header) == (header, None)


@pytest.mark.parametrize("units", [True, False])
@pytest.mark.parametrize("kind", ["parquet", "xlsx", "csv", "table"])
def test_a_table_with_several_rows_of_names(tmp_path, kind, units):
    table = LOG.assign(speed=3.6 * LOG["speed"])
    labels = [(name, {"t": "s", "speed": "km/h"}.get(name, "")) if units else ("car", name) for name in table]
    table.columns = pd.MultiIndex.from_tuples(labels)
    path = tmp_path / f"a.{kind}"
    if kind == "parquet":
        pytest.importorskip("pyarrow")
        table.to_parquet(path)
    elif kind == "xlsx":
        pytest.importorskip("openpyxl")
        table.to_excel(path)
    elif kind == "csv":
        table.to_csv(path, index=False)
    log = read_log(table if kind == "table" else path, None if units else {"speed": "speed [km/h]"})
    assert_is_the_log(log)


@pytest.mark.parametrize("fields", [("Time", "Value", "Units"), ("time", "data", "unit"), ("t", "Values", "Unit")])
@pytest.mark.parametrize("outer", ["", "run"])
@pytest.mark.parametrize("rates", [1, 2])
def test_structs_of_one_quantity_have_its_name_and_unit(tmp_path, fields, outer, rates):
    time, value, unit = fields
    channels = {}
    for number, (name, spelled, scale) in enumerate(
        [("steer", "deg", np.degrees(1.0)), ("speed", "km/h", 3.6), ("yaw_rate", "rad/s", 1.0), ("ay", "m/s^2", 1.0)]
    ):
        step = 1 + number % rates
        channels[name] = {time: T[::step], value: scale * LOG[name].to_numpy()[::step], unit: spelled}
    savemat(tmp_path / "a.mat", {outer: channels} if outer else channels)
    log = read_log(tmp_path / "a.mat")
    for number, name in enumerate(channels):
        t, values = log.channels[name]
        np.testing.assert_allclose(t, T[:: 1 + number % rates], atol=1e-9)
        np.testing.assert_allclose(values, LOG[name][:: 1 + number % rates], rtol=1e-12, atol=1e-12)


def test_a_struct_of_several_quantities_has_the_names_of_its_fields(tmp_path):
    savemat(tmp_path / "a.mat", {"data": {name: LOG[name].to_numpy() for name in LOG} | {"unit": "deg"}})
    assert_is_the_log(read_log(tmp_path / "a.mat"))


NAMES, UNITS_OF_LOG = list(LOG), ["ms", "deg", "km/h", "deg/s", "m/s^2"]
TEXTS = ["clock", "wheel", "forward", "turning", "to the left"]
HEADS = {
    "names, units": [NAMES, UNITS_OF_LOG],
    "units, names": [UNITS_OF_LOG, NAMES],
    "names, units, texts": [NAMES, UNITS_OF_LOG, TEXTS],
    "names, units, types": [NAMES, UNITS_OF_LOG, ["float"] * 5],
    "names, types, units": [NAMES, ["double"] * 4 + ["single"], UNITS_OF_LOG],
    "texts, names, units": [TEXTS, NAMES, UNITS_OF_LOG],
    "title, names, units, texts": [["run 1", "", "", "", ""], NAMES, UNITS_OF_LOG, TEXTS],
}


#: The first row of a DataFrame is that of its names.
OF_KINDS = [
    (head, kind) for head in HEADS for kind in ("csv", "xlsx", "table") if kind != "table" or head[:5] == "names"
]


@pytest.mark.parametrize(("head", "kind"), OF_KINDS)
def test_units_are_found_in_any_order_of_the_rows_of_a_head(tmp_path, head, kind):
    scaled = LOG.assign(t=1e3 * LOG["t"], speed=3.6 * LOG["speed"])
    scaled[["steer", "yaw_rate"]] = np.degrees(LOG[["steer", "yaw_rate"]])
    sheet = pd.DataFrame([*HEADS[head], *scaled.map(repr).to_numpy().tolist()])
    path = tmp_path / f"a.{kind}"
    if kind == "csv":
        sheet.to_csv(path, index=False, header=False)
    elif kind == "xlsx":
        pytest.importorskip("openpyxl")
        sheet.replace("", None).to_excel(path, index=False, header=False)
    else:
        sheet = sheet.rename(columns=dict(enumerate(sheet.iloc[0]))).iloc[1:].reset_index(drop=True)
    assert_is_the_log(read_log(sheet if kind == "table" else path))


@pytest.mark.parametrize("kind", ["csv", "xlsx"])
def test_headings_above_the_names_distinguish_columns_of_one_name(tmp_path, kind):
    names = ["t", "speed", "steer", "speed", "yaw_rate", "ay"]
    above = ["", "GPS", "", "Wheels", "", ""]
    table = [LOG["t"], LOG["speed"], LOG["steer"], 2.0 * LOG["speed"], LOG["yaw_rate"], LOG["ay"]]
    sheet = pd.DataFrame([above, names, *np.transpose(table).tolist()])
    path = tmp_path / f"a.{kind}"
    if kind == "csv":
        sheet.to_csv(path, index=False, header=False)
    else:
        pytest.importorskip("openpyxl")
        sheet.replace("", None).to_excel(path, index=False, header=False)
    with pytest.raises(DataError, match=r"'speed' occurs 2 times.*'speed=GPS/speed' or 'speed=Wheels/speed'"):
        read_log(path)
    assert_is_the_log(read_log(path, {"speed": "GPS/speed"}))


@pytest.mark.parametrize("kind", ["xlsx", "parquet", "table"])
@pytest.mark.parametrize("comma", [True, False])
@pytest.mark.parametrize("units", [True, False])
def test_a_table_of_texts_may_have_decimal_commas_and_a_row_of_units(tmp_path, kind, comma, units):
    texts = LOG.assign(speed=3.6 * LOG["speed"]).map(repr)
    if comma:
        texts = texts.map(lambda number: number.replace(".", ","))
    if units:
        row = pd.DataFrame([["s", "rad", "km/h", "rad/s", "m/s^2"]], columns=list(LOG))
        texts = pd.concat([row, texts], ignore_index=True)
    path = tmp_path / f"a.{kind}"

    def read(table):
        if kind == "xlsx":
            pytest.importorskip("openpyxl")
            table.to_excel(path, index=False)
        elif kind == "parquet":
            pytest.importorskip("pyarrow")
            table.to_parquet(path)
        return read_log(table if kind == "table" else path, None if units else {"speed": "speed [km/h]"})

    assert_is_the_log(read(texts))
    if comma:
        many = pd.concat([texts, *[texts.iloc[1:]] * 2], ignore_index=True)  # behind the rows that decide
        many.loc[len(many) - 1, "ay"] = "1.234"
        with pytest.raises(DataError, match=r"row \d+: column ay: '1\.234' has a point, other numbers have decimal"):
            read(many)
        texts.loc[len(texts) - 1, "ay"] = "x"
    else:
        texts.loc[len(texts) - 1, "ay"] = "1,5"
    with pytest.raises(DataError, match=rf"row {len(texts) + (kind == 'xlsx')}: column ay: .* is not a number"):
        read(texts)


def test_numbers_and_texts_with_decimal_commas_in_one_sheet(tmp_path):
    pytest.importorskip("openpyxl")
    texts = LOG.map(lambda number: repr(number).replace(".", ","))
    texts["speed"] = LOG["speed"]
    texts.to_excel(tmp_path / "a.xlsx", index=False)
    assert_is_the_log(read_log(tmp_path / "a.xlsx"))
    assert "decimals" in read_content(tmp_path / "a.xlsx").about


@pytest.mark.parametrize("number", ["1 102,5", "1'102.5", "1\u2019102,5", "12\u00a0102", "1\u202f102.5", "1.102,5"])
def test_marks_between_thousands_are_named(tmp_path, number):
    lines = ["t;steer;speed;yaw_rate;ay", *(f"{i};0;{number};0;0" for i in range(30))]
    (tmp_path / "a.csv").write_text("\n".join(lines), encoding="utf-8")
    with pytest.raises(DataError, match=r"line 2: column speed: .* is not a number: export it without marks between"):
        read_log(tmp_path / "a.csv")


BENCH = pd.DataFrame({"ET": T, "SA": np.degrees(STEER), "IA": 0.0, "P": 12.0, "FZ": -200.0, "FY": 1500.0 * STEER})
UNITS = ["sec", "deg", "deg", "psi", "lb", "lb"]


@pytest.mark.parametrize("separator", ["\t", " ", ",", ";", ", "])
@pytest.mark.parametrize("quoted", [False, True])
@pytest.mark.parametrize("encoding", ["utf-8", "utf-16"])
def test_a_bench_file_that_another_program_saved(tmp_path, separator, quoted, encoding):
    cells = [list(BENCH), UNITS, *([repr(cell) for cell in row] for row in BENCH.to_numpy().tolist())]
    text = "\n".join(separator.join(f'"{cell}"' if quoted else cell for cell in row) for row in cells)
    (tmp_path / "run.dat").write_bytes(f'"Round 8"\r\n{text}\n'.encode(encoding))
    recording = read_recording(tmp_path / "run.dat")
    assert recording.signs == "sae"
    np.testing.assert_allclose(recording.table["Fz"], -200.0 * 4.4482216152605)
    np.testing.assert_allclose(recording.table["alpha"], STEER, atol=1e-12)


def bench_file(folder, separator, units=True):
    cells = [list(BENCH), *([UNITS] if units else []), *([f"{cell:.6f}" for cell in row] for row in BENCH.to_numpy())]
    path = folder / "A1run1.dat"
    path.write_text("Round 8\n" + "\n".join(map(separator.join, cells)), encoding="utf-8")
    return path


def tydex_file(folder, fields=False):
    numbers = BENCH.assign(FY=-BENCH["FY"], FZ=-BENCH["FZ"])[["ET", "SA", "FZ", "FY"]].to_numpy()
    rows = ["".join(f"{cell:10.4f}" if fields else f" {cell:.6f}" for cell in row) for row in numbers]
    channels = [
        f"{name:10}{name:30}{unit:10}1.0       0.0       0.0"
        for name, unit in (("RUNTIME", "s"), ("SLIPANGL", "deg"), ("FZW", "lb"), ("FYW", "lb"))
    ]
    constants = ["INCLANGL  camber                        deg       0.0", "INFLPRES  pressure   psi  12.0"]
    parts = ["**HEADER", "**CONSTANTS", *constants, "**MEASURCHANNELS", *channels, "**MEASURDATA", *rows, "**END"]
    (folder / "run.tdx").write_text("\n".join(parts), encoding="utf-8")
    return folder / "run.tdx"


def vbo_file(folder):
    names = ["time", "velocity", "Latacc"]
    lines = [f"1000{second:06.3f} 036.000 {g:+.4f}" for second, g in zip(T, STEER, strict=True)]
    parts = ["[header]", "time", "velocity kmh", "Lat accel g", "[column names]", " ".join(names), "[data]", *lines]
    (folder / "run.vbo").write_text("\n".join(parts), encoding="utf-8")
    return folder / "run.vbo"


FILES = {
    "bench, blanks": lambda folder: bench_file(folder, " "),
    "bench, tabs": lambda folder: bench_file(folder, "\t"),
    "bench, semicolons": lambda folder: bench_file(folder, ";"),
    "bench without units": lambda folder: bench_file(folder, " ", units=False),
    "tydex": tydex_file,
    "tydex in fields": lambda folder: tydex_file(folder, fields=True),
    "vbox": vbo_file,
}


def numbers_of(path):
    content = read_content(path)
    return {column.header: numbers(column.cells, "", "", content.location)[0] for column in content.columns}


@pytest.mark.parametrize("kind", FILES)
def test_a_file_of_any_text_format_may_have_decimal_commas(tmp_path, kind):
    path = FILES[kind](tmp_path)
    expected, text = numbers_of(path), path.read_text(encoding="utf-8")
    assert "decimals" not in read_content(path).about
    path.write_text(text.replace(".", ","), encoding="utf-8")
    assert read_content(path).about["decimals"] == "commas in numbers are read as decimal points"
    for name, values in numbers_of(path).items():
        np.testing.assert_array_equal(values, expected.pop(name))
    assert not expected


SPELLINGS = {
    "minus sign": lambda number: number.replace("-", "\u2212"),
    "Fortran": lambda number: f"{number}D+00",
    "Fortran, decimal commas": lambda number: f"{number.replace('.', ',')}d0",
    "minus sign, decimal commas": lambda number: number.replace("-", "\u2212").replace(".", ","),
}


@pytest.mark.parametrize("spelling", SPELLINGS)
@pytest.mark.parametrize("kind", sorted(FILES.keys() - {"tydex in fields"}))  # whose numbers would be too long
def test_numbers_in_the_spelling_of_other_programs(tmp_path, kind, spelling):
    path = FILES[kind](tmp_path)
    expected, text = numbers_of(path), path.read_text(encoding="utf-8")
    written = re.sub(r"[-+]?\d+\.\d+", lambda number: SPELLINGS[spelling](number[0]), text)
    path.write_text(written, encoding="utf-8")
    for name, values in numbers_of(path).items():
        np.testing.assert_array_equal(values, expected.pop(name))
    assert not expected


@pytest.mark.parametrize("kind", FILES)
def test_a_point_among_decimal_commas_is_refused(tmp_path, kind):
    path = FILES[kind](tmp_path)
    head, _, last = path.read_text(encoding="utf-8").replace(".", ",").removesuffix("\n**END").rpartition("\n")
    path.write_text(f"{head}\n{last.replace(',', '.')}\n", encoding="utf-8")
    with pytest.raises(DataError, match=r"line \d+: column \w+: '.+' has a point, other numbers have decimal commas"):
        read_content(path)


def test_a_comma_that_may_separate_thousands_is_refused_in_a_bench_file(tmp_path):
    path = bench_file(tmp_path, " ")
    head = path.read_text(encoding="utf-8").splitlines()[:3]
    path.write_text("\n".join([*head, *(f"{row} 1 0 12 -2,000 -1" for row in range(60))]), encoding="utf-8")
    with pytest.raises(DataError, match=r"line 4: channel FZ: '-2,000' is not a number: a decimal comma\?"):
        read_recording(path)


@pytest.mark.parametrize("separator", [";", "\t"])
@pytest.mark.parametrize("above", [[], ["Messung 1"], ["Messung 1;Tag 2", "", "Rate;20;Hz"]])
@pytest.mark.parametrize("units", [True, False])
def test_decimal_commas(tmp_path, separator, above, units):
    head = [*above, separator.join(LOG), *([separator.join(["s", "rad", "m/s", "rad/s", "m/s^2"])] if units else [])]
    text = "\n".join([*head, *(line.replace(".", ",") for line in rows(LOG, separator))])
    (tmp_path / "a.csv").write_text(text, encoding="utf-8")
    assert_is_the_log(read_log(tmp_path / "a.csv"))


def test_a_comma_that_may_separate_thousands_is_no_decimal_one(tmp_path):
    lines = ["t;steer;speed;yaw_rate;ay", *(f"{i};0;{line};0;0" for i, line in enumerate(["1,234", "2,500"] * 30))]
    (tmp_path / "a.csv").write_text("\n".join(lines), encoding="utf-8")
    with pytest.raises(DataError, match=r"line 2: column speed: '1,234' is not a number"):
        read_log(tmp_path / "a.csv")
    for number in ("1.234,5", "1,234.5"):
        marked = [lines[0], *(f"{i},1;0;{number};0;0" for i in range(60))]
        (tmp_path / "a.csv").write_text("\n".join(marked), encoding="utf-8")
        with pytest.raises(DataError, match=f"line 2: column speed: '{number}' is not a number: export it without"):
            read_log(tmp_path / "a.csv")
    # Behind the rows that decide, too: a point among decimal commas may separate thousands.
    many = ["t;steer;speed;yaw_rate;ay", *(f"{i};0,1;1,5;0,1;0,1" for i in range(600)), "600;0,1;1.234;0,1;0,1"]
    (tmp_path / "a.csv").write_text("\n".join(many), encoding="utf-8")
    with pytest.raises(DataError, match=r"line 602: column speed: '1\.234' has a point, other numbers have decimal"):
        read_log(tmp_path / "a.csv")


@pytest.mark.parametrize(
    ("sources", "chosen"),
    [
        (["", "100: gps", "100: gps", "calc", "calc", "200: can"], ["100: gps", "200: can"]),
        (["", "gps", "", "", "", ""], ["gps", "column 6"]),
        (["x", "x", "x", "x", "x", "x"], ["column 2", "column 6"]),
    ],
)
def test_a_row_of_sources_below_the_units_is_no_row_of_names(tmp_path, sources, chosen):
    names, units = (
        ["t", "speed", "steer", "yaw_rate", "ay", "speed"],
        ["unix time", "m/s", "rad", "rad/s", "m/s2", "km/h"],
    )
    table = LOG[["t", "speed", "steer", "yaw_rate", "ay"]].assign(other=3.6 * LOG["speed"])
    head = ["Created by a logger", "Format,3", "", ",".join(names), ",".join(units), ",".join(sources)]
    (tmp_path / "a.csv").write_text("\n".join([*head, *rows(table)]), encoding="utf-8")
    with pytest.raises(
        DataError, match=f"'speed' occurs 2 times.*'speed={chosen[0]}/speed' or 'speed={chosen[1]}/speed'"
    ):
        read_log(tmp_path / "a.csv")
    pytest.importorskip("openpyxl")
    sheet = [names, units, [source or None for source in sources], *table.to_numpy().tolist()]
    pd.DataFrame(sheet).to_excel(tmp_path / "a.xlsx", index=False, header=False)
    for group in chosen:
        for file in ("a.csv", "a.xlsx"):
            assert_is_the_log(read_log(tmp_path / file, {"speed": f"{group}/speed"}))


def test_a_row_of_names_below_a_title_with_a_unit_has_the_names(tmp_path):
    lines = ["a;b;c;d;e", "track;m;Hz;20;x".replace("20", "b"), ";".join(LOG), *rows(LOG, ";")]
    (tmp_path / "a.csv").write_text("\n".join(lines), encoding="utf-8")
    assert_is_the_log(read_log(tmp_path / "a.csv"))


def test_the_header_of_a_vbox_log_has_units_at_its_ends(tmp_path):
    names, titles = ["time", "velocity", "Latacc", "Longacc"], ["time", "velocity kmh", "Lat accel g", "Long accel g"]
    lines = [f"10{int(t // 60):02d}{t % 60:05.2f} 036.0 +0.5 -0.25" for t in T]
    parts = ["[header]", *titles, "[channel units]", "[column names]", " ".join(names), "[data]", *lines]
    (tmp_path / "a.vbo").write_text("\n".join(parts), encoding="utf-8")
    units = {column.header: column.unit for column in read_content(tmp_path / "a.vbo").columns}
    assert units == {"time": "s", "velocity": "kmh", "Latacc": "g", "Longacc": "g"}


@pytest.mark.parametrize("start", [0.0, 3600.0])
def test_seconds_in_single_precision_are_a_clock(start):
    t = np.arange(60_000) * 0.01
    steer = 0.1 * np.sin(t)
    table = pd.DataFrame({"t": (start + t).astype("f4"), "steer": steer, "speed": 9.0, "yaw_rate": steer, "ay": steer})
    np.testing.assert_allclose(read_log(table).channels["steer"][0], t, atol=5e-4)
    with pytest.raises(
        DataError, match="times in single precision, or rounded: export them with more digits or from 0"
    ):
        read_log(table.assign(t=(1.7e9 + t).astype("f4")))


@pytest.mark.parametrize("step", [-0.5, -1e-3])
def test_a_clock_that_begins_again_is_named(step):
    table = LOG.assign(t=np.where(T < 5.0, T, T + step - 0.05))
    with pytest.raises(DataError, match=r"time decreases at sample 101: 4\.95 to .* s: cut the log there"):
        read_log(table)


def test_structs_of_matlab_have_their_own_times(tmp_path):
    from scipy.io import savemat

    slow = T[::2]
    imu = {"time": T, "yaw_rate": LOG["yaw_rate"].to_numpy(), "ay": LOG["ay"].to_numpy()}
    ecu = {"time": slow, "steer": 0.1 * np.sin(2.0 * slow), "speed": np.full(len(slow), 15.0)}
    savemat(tmp_path / "a.mat", {"car": {"imu": imu, "ecu": ecu}})
    log = read_log(tmp_path / "a.mat")
    np.testing.assert_allclose(log.channels["steer"][0], slow)
    np.testing.assert_allclose(log.channels["ay"][0], T)
    np.testing.assert_allclose(log.values("yaw_rate"), LOG["yaw_rate"])
    assert not log.ignored
    log = read_log(tmp_path / "a.mat", {"yaw_rate": "-car.imu/yaw_rate"})
    np.testing.assert_allclose(log.values("yaw_rate"), -LOG["yaw_rate"])


def tdms_of(path, groups, waveform):
    """Write groups whose first sample is at a date; waveforms, or with a channel of dates."""
    nptdms = pytest.importorskip("nptdms")
    with nptdms.TdmsWriter(path) as writer:
        for group, (dates, channels) in groups.items():
            start = {"wf_increment": 0.05, "wf_start_offset": 0.0, "wf_start_time": dates[0]} if waveform else {}
            members = channels if waveform else {"clock": dates, **channels}
            writer.write_segment([nptdms.ChannelObject(group, name, cells, start) for name, cells in members.items()])


@pytest.mark.parametrize("late", [-7.25, 0.4, 3600.0])
@pytest.mark.parametrize("kind", ["waveforms", "dates", "timetables", "structs"])
def test_groups_with_dates_keep_their_distance_in_time(tmp_path, monkeypatch, kind, late):
    path = tmp_path / ("a.tdms" if kind in ("waveforms", "dates") else "a.mat")
    groups = {}
    for group, start, names in (("imu", 0.0, ("yaw_rate", "ay")), ("ecu", late, ("steer", "speed"))):
        dates = np.datetime64("2026-11-01T12:00:00.700", "ns") + (1e9 * (start + T)).astype("timedelta64[ns]")
        groups[group] = dates, {name: LOG[name].to_numpy() for name in names}
    if path.suffix == ".tdms":
        tdms_of(path, groups, kind == "waveforms")
    else:
        path.write_bytes(b"MATLAB")
        tables = {
            group: pd.DataFrame(channels, pd.DatetimeIndex(dates, name="Time"))
            for group, (dates, channels) in groups.items()
        }
        logged = [
            (name, {"value": cells, "time": dates})
            for dates, channels in groups.values()
            for name, cells in channels.items()
        ]
        content = tables if kind == "timetables" else {"car": as_struct(dict(logged))}
        monkeypatch.setattr(native_reader, "load", lambda *_: content)
    log = read_log(path)
    np.testing.assert_allclose(log.channels["yaw_rate"][0], T - min(late, 0.0), atol=1e-6)
    np.testing.assert_allclose(log.channels["steer"][0], T + max(late, 0.0), atol=1e-6)


def as_struct(fields):
    """Return a struct of MATLAB as its reader does."""
    struct = np.empty((1, 1), dtype=[(name, object) for name in fields])
    for name, value in fields.items():
        struct[0, 0][name] = as_struct(value) if isinstance(value, dict) else value
    return struct


@pytest.mark.parametrize(
    ("whole", "part", "size", "name"),
    [
        ("header.stamp.secs", "header.stamp.nsecs", 1e9, "header.stamp"), ("sec", "nanosec", 1e9, "time"),
        ("imu/stamp_sec", "imu/stamp_nsec", 1e9, "imu/stamp"), ("Seconds", "MicroSeconds", 1e6, "time"),
        ("tv_sec", "tv_usec", 1e6, "tv"), ("stamp sec", "stamp msec", 1e3, "stamp"),
        ("S", "ns", 1e9, "time"), ("gps_s", "gps_ms", 1e3, "gps"), ("Stamp (s)", "Stamp (us)", 1e6, "Stamp"),
    ],
)  # fmt: skip
@pytest.mark.parametrize("begin", [0.0, 1764000000.85])
def test_seconds_and_their_fractions_are_one_time(tmp_path, whole, part, size, name, begin):
    steps = np.round(T / 0.05).astype(int) + round(begin / 0.05)
    table = LOG.drop(columns="t").assign(**{whole: steps // 20, part: np.round(steps % 20 * 0.05 * size).astype(int)})
    table.to_csv(tmp_path / "a.csv", index=False)
    log = read_log(tmp_path / "a.csv", {"t": name})
    np.testing.assert_allclose(log.channels["ay"][0], T, atol=1e-9)


@pytest.mark.parametrize("names", [("secs", "nsecs"), ("secs", "laps"), ("time", "secs", "nsecs"), ("s", "ns")])
def test_columns_that_are_no_pair_stay_as_they_are(tmp_path, names):
    """Nanoseconds since the begin are no fractions; a column of times beside a pair is the time."""
    whole, part = np.floor(T), 1e9 * (T % 1.0 if "time" in names else T)
    cells = {"s": whole, "ns": part, "secs": whole, "nsecs": part, "laps": 1.0, "time": T}
    LOG.drop(columns="t").assign(**{name: cells[name] for name in names}).to_csv(tmp_path / "a.csv", index=False)
    headers = [column.header for column in read_content(tmp_path / "a.csv").columns]
    assert headers == [*LOG.columns[1:], *names]


LONG = {
    "telemetry": ("timestamp", "signal_name", "value", ""), "influx": ("_time", "_field", "_value", ""),
    "races": ("time", "telemetry_name", "telemetry_value", ""), "units": ("Time", "Channel", "Value", "Unit"),
}  # fmt: skip


def melted(rows, kind, units):
    """Return a long table of a log: a row for each value, the signals of one time in any order."""
    time, name, value, unit = LONG[kind]
    long = rows.melt("t", var_name=name, value_name=value).rename(columns={"t": time})
    long = long.sample(frac=1.0, random_state=3).sort_values(time, kind="stable")
    return long.assign(**{unit: long[name].map(units)}) if unit else long


@pytest.mark.parametrize("kind", LONG)
@pytest.mark.parametrize("suffix", ["csv", "parquet"])
def test_a_row_for_each_value_is_a_column_for_each_signal(tmp_path, kind, suffix):
    units = {"steer": "deg", "speed": "km/h", "yaw_rate": "deg/s", "ay": "g"} if kind == "units" else {}
    factors = {"steer": np.degrees(1.0), "speed": 3.6, "yaw_rate": np.degrees(1.0), "ay": 1.0 / 9.80665}
    rows = LOG.assign(**{name: LOG[name] * factors[name] for name in units})
    table = melted(rows, kind, units).assign(id=7, device="ecu")
    table.to_csv(tmp_path / "a.csv", index=False) if suffix == "csv" else table.to_parquet(tmp_path / "a.parquet")
    log = read_log(tmp_path / f"a.{suffix}", {"t": LONG[kind][0]})
    for name in ("steer", "speed", "yaw_rate", "ay"):
        np.testing.assert_allclose(log.channels[name][0], T, atol=1e-9)
        np.testing.assert_allclose(log.values(name), LOG[name], atol=1e-12)


def test_a_long_table_of_two_cars_is_refused(tmp_path):
    cars = [melted(LOG, "races", {}).assign(vehicle_id=car) for car in ("GR86-7", "GR86-13")]
    pd.concat(cars).sort_values("time", kind="stable").to_csv(tmp_path / "a.csv", index=False)
    with pytest.raises(DataError, match="column vehicle_id: 'GR86-7, GR86-13' in rows of one signal: save a table"):
        read_log(tmp_path / "a.csv")


def test_a_long_table_with_a_value_that_is_no_number_is_refused_with_its_line(tmp_path):
    table = melted(LOG, "telemetry", {}).astype({"value": object})
    table.iloc[40, 2] = "1.5x"
    table.to_csv(tmp_path / "a.csv", index=False)
    with pytest.raises(DataError, match=r"a\.csv: line 42: column value: '1\.5x' is not a number"):
        read_log(tmp_path / "a.csv")


@pytest.mark.parametrize("names", [("name", "value"), ("sensor", "speed")])
def test_a_table_with_texts_is_no_long_table(tmp_path, names):
    """Names of one row each, and texts beside channels."""
    words = [f"row {i}" for i in range(len(T))]
    LOG.drop(columns="speed").assign(**{names[0]: words, names[1]: 15.0}).to_csv(tmp_path / "a.csv", index=False)
    headers = [column.header for column in read_content(tmp_path / "a.csv").columns]
    assert headers == ["t", "steer", "yaw_rate", "ay", *names]


def test_a_waveform_whose_start_was_never_set_begins_at_zero(tmp_path):
    dates = np.array(["1904-01-01"], dtype="datetime64[us]")
    tdms_of(tmp_path / "a.tdms", {"run": (dates, {name: LOG[name].to_numpy() for name in LOG if name != "t"})}, True)
    np.testing.assert_allclose(read_log(tmp_path / "a.tdms").channels["ay"][0], T, atol=1e-9)


@pytest.mark.parametrize("names", [("heading",), ("x", "y"), ("x", "heading"), ("x", "y", "heading")])
def test_a_part_of_a_pose_is_not_read(names):
    """Every VBOX log has a heading, and none has positions in m."""
    log = read_log(LOG.assign(**dict.fromkeys(names, 0.1 * T)))
    assert set(names) & set(log.channels) == (set(names) if len(names) == 3 else set())
    assert all(name in log.ignored for name in names) == (len(names) < 3)


def test_a_matrix_is_named_as_not_read(tmp_path):
    savemat(tmp_path / "a.mat", {"slip_and_force": np.ones((50, 2))})
    with pytest.raises(DataError, match=r"it has no columns of numbers \(not read: variables slip_and_force\)"):
        read_recording(tmp_path / "a.mat")


def test_what_a_log_has_instead_is_named(tmp_path):
    from scipy.io import savemat

    savemat(tmp_path / "a.mat", {"log": [{"steer": STEER}, {"steer": STEER}]})
    with pytest.raises(DataError, match=r"no channel t .*\(not read: variables log\)"):
        read_log(tmp_path / "a.mat")


def modelica_result(path, variables, transposed, padding):
    """Write a result as Modelica tools do; `variables`: name, description, matrix and signed place of each."""

    def letters(texts):
        rows = [text.ljust(max(map(len, texts)), "~") for text in texts]
        return np.array(["".join(column) for column in zip(*rows, strict=True)] if transposed else rows)

    def turned(matrix):
        return matrix.T if transposed else matrix

    table = np.column_stack([LOG["t"], LOG["steer"], LOG["speed"], -LOG["yaw_rate"], LOG["ay"]])
    kind = "binTrans" if transposed else "binNormal"
    names, descriptions, *places = zip(*variables, strict=True)
    parts = {
        "Aclass": np.array([text.ljust(11) for text in ("Atrajectory", "1.1", "", kind)]), "name": letters(names),
        "description": letters(descriptions), "dataInfo": turned(np.array(places, dtype=np.int32).T),
        "data_1": turned(np.array([[0.0, 1500.0], [20.0, 1500.0]])), "data_2": turned(table),
    }  # fmt: skip
    savemat(path, parts, format="4")
    texts, name, tables = path.read_bytes().partition(b"dataInfo")
    path.write_bytes(texts.replace(b"~", padding) + name + tables)


VARIABLES = [
    ("time", "Time in [s]", 0, 1), ("steer", "Angle [rad|deg]", 2, 2), ("m", "Mass [kg]", 1, 2),
    ("speed", "of the center [m/s|km/h]", 2, 3), ("yaw_rate", "w[3] of the body [rad/s]", 2, -4), ("ay", "", 2, 5),
    ("gear.w", "alias [rad/s]", 2, 4),
]  # fmt: skip


@pytest.mark.parametrize("padding", [b" ", b"\0"])
@pytest.mark.parametrize("transposed", [True, False])
def test_a_result_of_a_modelica_tool_is_a_log(tmp_path, transposed, padding):
    modelica_result(tmp_path / "car_res.mat", VARIABLES, transposed, padding)
    assert_is_the_log(read_log(tmp_path / "car_res.mat"))
    content = read_content(tmp_path / "car_res.mat")
    assert content.ignored == ("1 parameters",)
    alias = next(column for column in content.columns if column.header == "gear.w")
    np.testing.assert_array_equal(alias.cells, -LOG["yaw_rate"])
    assert alias.unit == "rad/s"


@pytest.mark.parametrize("wrong", [("x", "", 2, 9), ("x", "", 2, -40)])
def test_a_result_whose_tables_lack_a_variable_is_refused(tmp_path, wrong):
    modelica_result(tmp_path / "a.mat", [*VARIABLES, wrong], True, b" ")
    with pytest.raises(DataError, match="names and tables of this result of a Modelica tool do not fit"):
        read_content(tmp_path / "a.mat")
