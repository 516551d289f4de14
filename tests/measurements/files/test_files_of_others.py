"""Files as benches and loggers write them: 30 variants of each format are read to the digit, whatever its dialect."""

from __future__ import annotations

import struct
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from tirefmu.applications.driving.inputs.log import read_log
from tirefmu.boundary.errors import DataError, TirefmuError
from tirefmu.measurements import read_recording
from tirefmu.measurements.files.columns.cells import numbers
from tirefmu.measurements.files.columns.content import row_number

#: By channel of a bench: spellings of its unit with the number of units in one SI unit.
BENCH = {
    "t": {"s": 1.0, "ms": 1e3, "us": 1e6, "min": 1.0 / 60.0},
    "alpha": {"rad": 1.0, "deg": 180.0 / np.pi, "°": 180.0 / np.pi},
    "Fz": {"N": 1.0, "kN": 1e-3, "lbf": 1.0 / 4.4482216152605, "kgf": 1.0 / 9.80665},
    "p": {"Pa": 1.0, "kPa": 1e-3, "mbar": 1e-2, "hPa": 1e-2, "psi": 1.0 / 6894.757293168361},
    "Fy": {"N": 1.0, "daN": 0.1},
    "Mz": {"N m": 1.0, "N·m": 1.0, "ft-lb": 1.0 / 1.3558179483314003},
}
DRIVE = {
    "t": {"s": 1.0, "ms": 1e3},
    "steer": {"rad": 1.0, "deg": 180.0 / np.pi, "°": 180.0 / np.pi},
    "speed": {"m/s": 1.0, "km/h": 3.6, "MPH": 1.0 / 0.44704, "kph": 3.6},
    "yaw_rate": {"rad/s": 1.0, "deg/sec": 180.0 / np.pi, "°/s": 180.0 / np.pi, "deg per s": 180.0 / np.pi},
    "ay": {"m/s²": 1.0, "m/s^2": 1.0, "G": 1.0 / 9.80665, "m/s/s": 1.0},
}
SEEDS = range(30)


def bench_rows() -> pd.DataFrame:
    t = 0.02 * np.arange(60)
    alpha = 0.1 * np.sin(4.0 * t)
    return pd.DataFrame(
        {"t": t, "alpha": alpha, "Fz": 900.0 + 0.0 * t, "p": 83e3, "Fy": -9e3 * alpha, "Mz": 90.0 * alpha}
    )


def drive_rows() -> pd.DataFrame:
    t = 0.05 * np.arange(130)
    steer = 0.1 * np.sin(2.0 * t)
    return pd.DataFrame({"t": t, "steer": steer, "speed": 15.0, "yaw_rate": 0.5 * steer, "ay": 7.0 * steer})


def drawn(rows: pd.DataFrame, units: dict[str, dict[str, float]], random: np.random.Generator):
    """Return the numbers of a file, their units by column, and the columns of the channels with another sign."""
    order = [str(name) for name in random.permutation(list(rows))]
    chosen = {name: str(random.choice(list(units[name]))) for name in order}
    turned = [name for name in order if name != "t" and random.random() < 0.3]
    table = pd.DataFrame({
        name: rows[name] * units[name][chosen[name]] * (-1.0 if name in turned else 1.0) for name in order
    })  # fmt: skip
    return table, chosen, {name: f"-{name}" for name in turned}


def sheet(table: pd.DataFrame, units: dict[str, str], random: np.random.Generator) -> list[list[object]]:
    """Return the rows of a sheet: perhaps a title, names with units, or units below them."""
    title = [["Run 12, session 2"]] if random.random() < 0.5 else []
    if random.random() < 0.5:
        head = [[f"{name} [{units[name]}]" for name in table]]
    else:
        head = [list(table), [units[name] for name in table]]
    return [*title, *head, *table.to_numpy().tolist()]


def as_csv(path: Path, table, units, random) -> None:
    separator = str(random.choice([",", ";", "\t"]))
    lines = [
        separator.join(map(repr if isinstance(row[0], float) else str, row)) for row in sheet(table, units, random)
    ]
    lines = [line.replace("'", "") for line in lines]
    if random.random() < 0.3:
        lines.insert(len(lines) - len(table), "")
    path.write_text("\n".join(lines) + "\n", encoding="utf-8")


def as_excel(path: Path, table, units, random) -> None:
    book = pytest.importorskip("openpyxl").Workbook()
    pages = [book.active, book.create_sheet("data")]
    first = int(random.integers(2))
    pages[1 - first].append(["remarks"])
    pages[1 - first].sheet_state = str(random.choice(["visible", "hidden"]))
    for row in sheet(table, units, random):
        pages[first].append(row)
    book.active = first
    book.save(path)


def as_parquet(path: Path, table, units, random) -> None:
    pa = pytest.importorskip("pyarrow")
    named = random.random() < 0.5
    table = table if named else table.rename(columns={name: f"{name} ({units[name]})" for name in table})
    if random.random() < 0.5:
        table = table.set_index(next(iter(table)))
    arrow = pa.Table.from_pandas(table)
    fields = [field.with_metadata({"unit": units[field.name]}) if named else field for field in arrow.schema]
    pytest.importorskip("pyarrow.parquet").write_table(
        arrow.cast(pa.schema(fields, metadata=arrow.schema.metadata)), path
    )


def as_tydex(path: Path, table, units, random) -> None:
    names = {"t": "RUNTIME", "alpha": "SLIPANGL", "Fz": "FZW", "p": "INFLPRES", "Fy": "FYW", "Mz": "MZW"}
    axes = {} if random.random() < 0.5 else {"FZW": "FZH", "FYW": "FYH"}
    lines = ["**HEADER", "RELEASE   1.3", "**MEASURCHANNELS"]
    lines += [f"{axes.get(names[n], names[n]):10}{'measured':30}{units[n]:10}{'1':>10}{'0':>10}" for n in table]
    lines += [f"**MEASURDATA {len(table)}" if random.random() < 0.5 else "**MEASURDATA"]
    touching = random.random() < 0.5
    lines += ["".join(f"{v:>10.4f}"[:10] if touching else f" {v!r}" for v in row) for row in table.to_numpy().tolist()]
    path.write_text("\n".join([*lines, "**END"]), encoding="latin-1")


@pytest.mark.parametrize("seed", SEEDS)
@pytest.mark.parametrize(
    ("suffix", "write"), [("csv", as_csv), ("xlsx", as_excel), ("parquet", as_parquet), ("tdx", as_tydex)]
)
def test_a_bench_file_is_read_to_the_digit(tmp_path, suffix, write, seed):
    random = np.random.default_rng(seed)
    table, units, columns = drawn(bench_rows(), BENCH, random)
    write(tmp_path / f"run.{suffix}", table, units, random)
    read = read_recording(tmp_path / f"run.{suffix}", columns=columns).table
    expected = bench_rows()
    for name in expected:
        size = max(np.abs(table[name]))
        tolerance = 1e-12 if suffix != "tdx" else 1e-3 / min(size, 1.0)  # ten characters have few digits
        np.testing.assert_allclose(
            read[name], expected[name], rtol=tolerance, atol=tolerance * expected[name].abs().max()
        )


def log_csv(path: Path, table, units, random) -> None:
    as_csv(path, table, units, random)


def log_logger(path: Path, table, units, random) -> None:
    """Write a file as MoTeC i2 and AiM do: quoted information, names, units, numbers of any country."""
    mark = str(random.choice([".", ","]))
    kind = str(random.choice(["MoTeC", "AiM"]))
    lines = [f'"Format","{kind} CSV File"', '"Venue","track",,,"Session","2"', '"Duration","6.0","s"', ""]
    lines += [",".join(f'"{name}"' for name in table), ",".join(f'"{units[name]}"' for name in table)]
    lines += [""] * int(random.integers(3))
    lines += [",".join(f'"{value!r}"'.replace(".", mark) for value in row) for row in table.to_numpy().tolist()]
    path.write_text("\n".join(lines) + "\n", encoding="utf-8")


def log_racecapture(path: Path, table, units, random) -> None:
    head = ",".join(f'"{name}"|"{units[name]}"|0|0|{int(random.integers(1, 50))}' for name in table)
    rows = [",".join(map(repr, row)) for row in table.to_numpy().tolist()]
    path.write_text("\n".join([head, *rows]) + "\n", encoding="utf-8")


def log_vbo(path: Path, table, units, random) -> None:
    of_day = table["t"] / DRIVE["t"][units["t"]] + 86398.0  # the drive passes midnight
    of_day %= 86400.0
    clock = 1e4 * (of_day // 3600.0) + 100.0 * (of_day % 3600.0 // 60.0) + of_day % 60.0
    names = [name for name in table if name != "t"]
    lines = ["File created", "[header]", "time", *names, "[channel units]", *(units[name] for name in names)]
    lines += ["[column names]", " ".join(["time", *names]), "[data]"]
    values = table[names].to_numpy().tolist()
    lines += [" ".join([f"{t:016.9f}", *map(repr, row)]) for t, row in zip(clock, values, strict=True)]
    path.write_text("\n".join(lines) + "\n", encoding="latin-1")


def log_tdms(path: Path, table, units, random) -> None:
    nptdms = pytest.importorskip("nptdms")
    own = random.random() < 0.5
    step = {"wf_increment": 0.05, "wf_start_offset": 0.0, "wf_samples": len(table)} if own else {}
    channels = [
        nptdms.ChannelObject("run", name, table[name].to_numpy(), {"unit_string": units[name], **step})
        for name in table
        if not (own and name == "t")
    ]
    with nptdms.TdmsWriter(path) as writer:
        writer.write_segment(channels)


@pytest.mark.parametrize("seed", SEEDS)
@pytest.mark.parametrize(
    ("suffix", "write"),
    [("csv", log_csv), ("csv", log_logger), ("csv", log_racecapture), ("vbo", log_vbo), ("tdms", log_tdms)],
)
def test_a_log_is_read_to_the_digit(tmp_path, suffix, write, seed):
    random = np.random.default_rng(seed)
    table, units, columns = drawn(drive_rows(), DRIVE, random)
    write(tmp_path / f"log.{suffix}", table, units, random)
    log = read_log(tmp_path / f"log.{suffix}", columns)
    expected = drive_rows()
    for name in ("steer", "speed", "yaw_rate", "ay"):
        t, values = log.channels[name]
        np.testing.assert_allclose(t, expected["t"], rtol=1e-9, atol=1e-6)
        np.testing.assert_allclose(values, expected[name], rtol=1e-12, atol=1e-12)


def mdf_of(path: Path, *groups) -> None:
    asammdf = pytest.importorskip("asammdf", reason="the extra mdf is not installed")
    with asammdf.MDF(version="4.10") as file:
        for group in groups:
            file.append([asammdf.Signal(timestamps=t, **signal) for t, signal in group])
        file.save(path, overwrite=True)


def test_what_a_logger_marks_as_invalid_is_no_sample(tmp_path):
    rows = drive_rows()
    t = rows["t"].to_numpy()
    invalid = np.arange(len(t)) // 20 == 2
    signals = [(t, {"samples": rows[name].to_numpy(), "name": name}) for name in rows if name != "t"]
    signals[2][1]["invalidation_bits"] = invalid
    mdf_of(tmp_path / "a.mf4", signals)
    log = read_log(tmp_path / "a.mf4")
    assert [len(log.values(name)) for name in ("steer", "yaw_rate")] == [130, 110]


def test_channels_of_one_name_are_refused_until_one_is_chosen(tmp_path):
    rows = drive_rows()
    t = rows["t"].to_numpy()
    signals = [(t, {"samples": rows[name].to_numpy(), "name": name}) for name in rows if name != "t"]
    mdf_of(tmp_path / "a.mf4", signals, [(t, {"samples": 2.0 * rows["yaw_rate"].to_numpy(), "name": "yaw_rate"})])
    with pytest.raises(DataError, match=r"'yaw_rate' occurs 2 times: name one: --columns 'yaw_rate=.*/yaw_rate'"):
        read_log(tmp_path / "a.mf4")
    log = read_log(tmp_path / "a.mf4", {"yaw_rate": "group 2/yaw_rate"})
    np.testing.assert_allclose(log.values("yaw_rate"), 2.0 * rows["yaw_rate"])


def test_px4_has_axes_forward_right_down(tmp_path):
    pytest.importorskip("pyulog")
    from tirefmu.applications.driving.inputs.survey import survey
    from tirefmu.measurements.files.reading import read_content

    text = b"imu:uint64_t timestamp;float[3] gyro_rad;float[3] accelerometer_m_s2;"
    parts = [struct.pack("<HB", len(text), ord("F")) + text, struct.pack("<HBBH", 6, ord("A"), 0, 0) + b"imu"]
    for i in range(100):
        turn = 0.3 * np.sin(0.1 * i)
        body = struct.pack("<HQ6f", 0, 10**8 + 10**4 * i, 0, 0, turn, 0, 9.0 * turn, -9.81)
        parts.append(struct.pack("<HB", len(body), ord("D")) + body)
    (tmp_path / "a.ulg").write_bytes(b"ULog\x01\x12\x35\x01" + struct.pack("<Q", 0) + b"".join(parts))
    found = survey(read_content(tmp_path / "a.ulg"), "a.ulg")
    assert found.proposal["yaw_rate"] == "-imu/gyro_rad[2]"
    assert found.proposal["ay"] == "-imu/accelerometer_m_s2[1]"
    assert found.columns[0].rate == pytest.approx(100.0)


def test_a_bag_of_ros_has_numbers_by_topic(tmp_path):
    rosbag2 = pytest.importorskip("rosbags.rosbag2")
    from rosbags.typesys import Stores, get_typestore

    from tirefmu.measurements.files.reading import read_content

    store = get_typestore(Stores.ROS2_HUMBLE)
    vector, twist = (store.types[f"geometry_msgs/msg/{name}"] for name in ("Vector3", "Twist"))
    with rosbag2.Writer(tmp_path / "bag", version=9) as writer:
        connection = writer.add_connection("/cmd", twist.__msgtype__, typestore=store)
        for i in range(5):
            message = twist(linear=vector(1.0 * i, 0.0, 0.0), angular=vector(0.0, 0.0, 0.1 * i))
            writer.write(connection, 10**18 + i * 10**7, store.serialize_cdr(message, twist.__msgtype__))
    columns = {column.header: column for column in read_content(next((tmp_path / "bag").glob("*.db3"))).columns}
    np.testing.assert_allclose(columns["angular.z"].cells, 0.1 * np.arange(5))
    np.testing.assert_allclose(columns["angular.z"].times, 0.01 * np.arange(5), atol=1e-9)
    assert columns["angular.z"].group == "cmd"


@pytest.mark.parametrize(
    ("cells", "seconds"),
    [
        (["00:01.5", "00:02.0"], [1.5, 2.0]),
        (["23:59:59.5", "00:00:00.5"], [86399.5, 86400.5]),
        (["0 days 00:00:01", "0 days 00:00:01.250000"], [1.0, 1.25]),
        (["2024-05-01T10:00:00.000", "2024-05-01T10:00:00.010"], [0.0, 0.01]),
        (pd.to_timedelta([10, 20], unit="ms"), [0.01, 0.02]),
        (pd.to_datetime([10**18, 10**18 + 10**7], unit="ns", utc=True), [0.0, 0.01]),
    ],
)
def test_times_of_every_kind_are_seconds(cells, seconds):
    values, are_seconds = numbers(cells, "a", "column t", row_number, clock=True)
    assert are_seconds
    assert values == pytest.approx(seconds, abs=1e-9)


def test_nanoseconds_since_1970_keep_their_digits():
    values, _ = numbers(
        np.array([1_700_000_000_000_000_000, 1_700_000_000_000_000_100]), "a", "t", row_number, clock=True
    )
    assert values.tolist() == [0.0, 100.0]


def test_the_status_of_a_logger_is_a_missing_value(tmp_path):
    (tmp_path / "a.csv").write_text("alpha,Fz,Fy\n0.1,900,-800\n0.1,900,No Data\n0.1,900,N/A\n", encoding="utf-8")
    assert read_recording(tmp_path / "a.csv").table["Fy"].isna().tolist() == [False, True, True]


@pytest.mark.parametrize("header", ["steering_wheel [deg]", "wheel (deg)", "angle"])
def test_a_unit_is_that_of_the_user_otherwise_of_the_header(header):
    rows = drive_rows()
    table = rows.drop(columns="steer").assign(**{header: np.degrees(rows["steer"])})
    plain = header.partition(" ")[0]
    for wanted in {header, f"{plain} [deg]"} - {"angle"}:
        log = read_log(table, {"steer": wanted})
        np.testing.assert_allclose(log.values("steer"), rows["steer"])
    turned = read_log(table.assign(**{header: rows["steer"]}), {"steer": f"-{plain} [rad]"})
    np.testing.assert_allclose(turned.values("steer"), -rows["steer"])


@pytest.mark.parametrize(
    "header", ["wheel_deg", "Steered Angle deg", "wheel; deg", "wheel:Degrees", "SteerDeg", "wheel °"]
)
def test_a_unit_in_the_name_of_a_header_is_not_ignored(header):
    rows = drive_rows().rename(columns={"steer": header})
    with pytest.raises(TirefmuError, match=r"the unit in its name is not read: state it: --columns 'steer=.* \["):
        read_log(rows, {"steer": header})
    for unit, factor in (("deg", np.pi / 180.0), ("rad", 1.0)):
        log = read_log(rows, {"steer": f"{header} [{unit}]"})
        np.testing.assert_allclose(log.values("steer"), factor * rows[header])
    for word in ("wheel_rad", "angle_front", "steer_in"):
        read_log(rows.rename(columns={header: word}), {"steer": word})


@pytest.mark.parametrize(("factor", "unit"), [(1e3, "ms"), (1e6, "us"), (1e9, "ns"), (1.0 / 3600.0, "h")])
def test_a_clock_in_another_unit_is_named_before_any_work(factor, unit):
    rows = drive_rows().rename(columns={"t": "timestamp"})
    rows["timestamp"] *= factor
    with pytest.raises(TirefmuError, match=rf"in (\w+ or )*{unit}.*--columns 't=timestamp \["):
        read_log(rows, {"t": "timestamp"})
    assert len(read_log(rows, {"t": f"timestamp [{unit}]"}).values("ay")) == len(rows)
