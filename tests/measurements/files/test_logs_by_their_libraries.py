"""Logs written by the libraries of their formats: 30 variants of each are read to the digit.

A variant draws the order and the groups of its channels, their rates, units, signs and types, and a gap.
"""

from __future__ import annotations

import struct
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
import pytest

from tirefmu.applications.driving.inputs.log import read_log
from tirefmu.boundary.errors import DataError
from tirefmu.measurements import read_recording

DEGREE = np.pi / 180.0
#: By channel: spellings of its unit, with the SI value of one unit.
UNITS = {
    "steer": {"rad": 1.0, "deg": DEGREE, "°": DEGREE, "mrad": 1e-3},
    "speed": {"m/s": 1.0, "km/h": 1.0 / 3.6, "mph": 0.44704, "kph": 1.0 / 3.6},
    "yaw_rate": {"rad/s": 1.0, "deg/s": DEGREE, "°/s": DEGREE, "dps": DEGREE},
    "ay": {"m/s²": 1.0, "m/s^2": 1.0, "g": 9.80665, "m/s/s": 1.0},
}
SEEDS = range(30)
#: Bags of ROS take most of the time: most of their variants are for the slow runs.
BAG_SEEDS = [seed if seed < 5 else pytest.param(seed, marks=pytest.mark.slow) for seed in SEEDS]
SECONDS = 6.0


@dataclass(frozen=True)
class Signal:
    """A channel of a log: `values` in its unit at `times`, s, in a group, under a name."""

    name: str
    channel: str
    group: int
    times: np.ndarray
    values: np.ndarray
    unit: str
    sign: float

    @property
    def si(self) -> np.ndarray:
        return self.sign * self.values * UNITS[self.channel][self.unit]


def truth(channel: str, t: np.ndarray) -> np.ndarray:
    steer = 0.1 * np.sin(2.0 * t)
    return {"steer": steer, "speed": 15.0 + 0.1 * t, "yaw_rate": 0.5 * steer, "ay": 7.0 * steer}[channel]


def drawn(random: np.random.Generator, units: bool = True) -> list[Signal]:
    """Return channels of a drive in one to three groups, each with its rate, its start and perhaps a gap."""
    groups = int(random.integers(1, 4))
    grids = []
    for _ in range(groups):
        rate = float(random.choice([20.0, 25.0, 50.0]))
        t = np.round(float(random.choice([0.0, 0.003])) + np.arange(int(SECONDS * rate)) / rate, 6)
        begin = float(random.uniform(1.0, 4.0))
        grids.append(t if random.random() < 0.5 else t[(t < begin) | (t > begin + 1.0)])
    signals = []
    for channel in random.permutation(list(UNITS)):
        name = str(random.choice([channel, channel.upper(), f"car_{channel}"]))
        unit = str(random.choice(list(UNITS[channel]))) if units else next(iter(UNITS[channel]))
        sign, group = float(random.choice([1.0, 1.0, -1.0])), int(random.integers(groups))
        values = sign * truth(channel, grids[group]) / UNITS[channel][unit]
        signals.append(Signal(name, str(channel), group, grids[group], values, unit, sign))
    return signals


def columns_of(signals: list[Signal], groups: str = "", stated: bool = False) -> dict[str, str]:
    """Return what a user writes: names, signs, and the units that the format cannot declare."""
    return {
        signal.channel: f"{'-' if signal.sign < 0.0 else ''}{groups.format(signal.group)}{signal.name}"
        + (f" [{signal.unit}]" if stated else "")
        for signal in signals
    }


def assert_read(path: Path, signals: list[Signal], columns: dict[str, str], resolution: float = 1e-9) -> None:
    log = read_log(path, columns)
    start = min(signal.times[0] for signal in signals)
    for signal in signals:
        t, values = log.channels[signal.channel]
        np.testing.assert_allclose(t, signal.times - start, atol=resolution)
        np.testing.assert_allclose(values, signal.si, rtol=1e-12, atol=1e-14)


@pytest.mark.parametrize("seed", SEEDS)
def test_mdf(tmp_path, seed):
    asammdf = pytest.importorskip("asammdf")
    random = np.random.default_rng(seed)
    signals = drawn(random)
    version = str(random.choice(["3.30", "4.10", "4.11"]))
    compression = int(random.integers(3)) if version > "4" else 0
    path = tmp_path / ("log.mf4" if version > "4" else str(random.choice(["log.mdf", "log.dat"])))
    with asammdf.MDF(version=version) as file:
        for group in range(3):
            members = [signal for signal in signals if signal.group == group]
            other = asammdf.Signal(np.arange(9) % 3, np.arange(9.0), name=f"state{group}", unit="")
            file.append([
                asammdf.Signal(signal.values, signal.times, name=signal.name, unit=signal.unit) for signal in members
            ] or [other])  # fmt: skip
        file.save(path, overwrite=True, compression=compression).replace(path)  # asammdf writes .mdf for .dat
    assert_read(path, signals, columns_of(signals))


def ulog_of(signals: list[Signal], types: dict[str, str], start: int) -> bytes:
    """Return a log of PX4 by its published definition: formats, subscriptions, and data in the order of time."""

    def message(kind: str, body: bytes) -> bytes:
        return struct.pack("<HB", len(body), ord(kind)) + body

    header, data = [], []
    for group in sorted({signal.group for signal in signals}):
        members = [signal for signal in signals if signal.group == group]
        fields = "".join(f"{types[signal.name]} {signal.name};" for signal in members)
        header.append(message("F", f"topic{group}:uint64_t timestamp;{fields}uint8_t[8] _padding0;".encode()))
        header.append(message("A", struct.pack("<BH", 0, group) + f"topic{group}".encode()))
        form = "<HQ" + "".join({"float": "f", "double": "d"}[types[signal.name]] for signal in members)
        for i, t in enumerate(members[0].times):
            stamp = start + round(1e6 * float(t))
            row = struct.pack(form, group, stamp, *(signal.values[i] for signal in members))
            data.append((stamp, message("D", row)))
    subscriptions = [text for text in header if text[2:3] == b"A"]
    formats = [text for text in header if text[2:3] == b"F"]
    data.sort(key=lambda pair: pair[0])
    body = [*formats, *subscriptions, *(text for _, text in data)]
    return b"ULog\x01\x12\x35\x01" + struct.pack("<Q", start) + b"".join(body)


@pytest.mark.parametrize("seed", SEEDS)
def test_px4(tmp_path, seed):
    pytest.importorskip("pyulog")
    random = np.random.default_rng(seed)
    signals = drawn(random)
    types = {signal.name: str(random.choice(["float", "double"])) for signal in signals}
    signals = [
        replace(signal, values=signal.values.astype("f4" if types[signal.name] == "float" else "f8").astype(float))
        for signal in signals
    ]
    path = tmp_path / "log.ulg"
    path.write_bytes(ulog_of(signals, types, int(random.integers(10**6, 10**10))))
    assert_read(path, signals, columns_of(signals, stated=True), 1e-6)


def imu_of(store, t: float, yaw_rate: float, ay: float):
    """Return a message of an inertial sensor with a stamp."""
    make = store.types
    vector, quaternion = make["geometry_msgs/msg/Vector3"], make["geometry_msgs/msg/Quaternion"]
    header = make["std_msgs/msg/Header"]
    given = {"seq": 0} if "seq" in header.__dataclass_fields__ else {}
    stamp = make["builtin_interfaces/msg/Time"](int(t), round(1e9 * (t - int(t))))
    return make["sensor_msgs/msg/Imu"](
        header=header(stamp=stamp, frame_id="imu", **given),
        orientation=quaternion(0.0, 0.0, 0.0, 1.0), orientation_covariance=np.zeros(9),
        angular_velocity=vector(0.0, 0.0, yaw_rate), angular_velocity_covariance=np.zeros(9),
        linear_acceleration=vector(0.0, ay, 9.81), linear_acceleration_covariance=np.zeros(9),
    )  # fmt: skip


def written_bag(folder: Path, kind: str, random: np.random.Generator) -> tuple[Path, list[Signal]]:
    """Write a drive as a bag; return what a user names as the log, and its channels."""
    from rosbags import rosbag1, rosbag2
    from rosbags.typesys import Stores, get_typestore

    store = get_typestore(Stores.ROS1_NOETIC if kind == "bag" else Stores.ROS2_HUMBLE)
    signals = drawn(random, units=False)
    grid = {signal.channel: signal for signal in signals}
    imu_times = grid["yaw_rate"].times
    grid["ay"] = replace(grid["ay"], times=imu_times, values=grid["ay"].sign * truth("ay", imu_times))
    number = store.types["std_msgs/msg/Float64"]
    start = 1_700_000_000 + int(random.integers(1000))
    messages = []
    for name in ("steer", "speed"):
        messages += [
            (t, f"/{name}", number(float(v))) for t, v in zip(grid[name].times, grid[name].values, strict=True)
        ]
    for i, t in enumerate(imu_times):
        values = float(grid["yaw_rate"].values[i]), float(grid["ay"].values[i])
        messages.append((t, "/imu/data", imu_of(store, start + t, *values)))
    if kind == "bag":
        writer = rosbag1.Writer(folder / "drive.bag")
        if random.random() < 0.5:
            writer.set_compression(writer.CompressionFormat.BZ2)
        serialize = store.serialize_ros1
    else:
        plugin = rosbag2.StoragePlugin.MCAP if kind == "mcap" else rosbag2.StoragePlugin.SQLITE3
        writer = rosbag2.Writer(folder / "drive", version=int(random.choice([8, 9])), storage_plugin=plugin)
        serialize = store.serialize_cdr
    with writer:
        types = {topic: message.__msgtype__ for _, topic, message in messages}
        connections = {topic: writer.add_connection(topic, types[topic], typestore=store) for topic in types}
        for t, topic, message in sorted(messages, key=lambda entry: entry[0]):
            stamp = start * 10**9 + round(1e9 * float(t))
            writer.write(connections[topic], stamp, serialize(message, message.__msgtype__))
    if kind == "bag":
        return folder / "drive.bag", list(grid.values())
    inside = next((folder / "drive").glob(f"*.{kind}"))
    return (folder / "drive" if random.random() < 0.5 else inside), list(grid.values())


@pytest.mark.parametrize("kind", ["bag", "db3", "mcap"])
@pytest.mark.parametrize("seed", BAG_SEEDS)
def test_bags(tmp_path, kind, seed):
    pytest.importorskip("rosbags")
    path, signals = written_bag(tmp_path, kind, np.random.default_rng(seed))
    names = {"steer": "steer/data", "speed": "speed/data", "yaw_rate": "imu/data/angular_velocity.z",
             "ay": "imu/data/linear_acceleration.y"}  # fmt: skip
    columns = {signal.channel: f"{'-' if signal.sign < 0.0 else ''}{names[signal.channel]}" for signal in signals}
    assert_read(path, signals, columns, 1e-6)


@pytest.mark.parametrize("seed", SEEDS)
def test_matlab(tmp_path, seed):
    from scipy.io import savemat

    random = np.random.default_rng(seed)
    rate = float(random.choice([20.0, 100.0]))
    t = np.arange(int(SECONDS * rate)) / rate
    t = t if random.random() < 0.5 else t[(t < 3.0) | (t > 4.0)]
    signals = [
        replace(signal, times=t, values=signal.sign * truth(signal.channel, t) / UNITS[signal.channel][signal.unit])
        for signal in drawn(random)
    ]
    shape = (-1, 1) if random.random() < 0.5 else (1, -1)
    clock = {"s": 1.0, "ms": 1e3}
    unit = str(random.choice(list(clock)))
    variables = {signal.name: signal.values.reshape(shape) for signal in signals}
    variables["time"] = (t * clock[unit]).reshape(shape)
    layout = str(random.choice(["vectors", "struct", "v4"]))
    if layout == "struct":
        variables = {"drive": variables}
    savemat(tmp_path / "log.mat", variables, format="4" if layout == "v4" else "5")
    columns = {**columns_of(signals, stated=True), "t": f"time [{unit}]"}
    assert_read(tmp_path / "log.mat", signals, columns)


@pytest.mark.parametrize("unit", ["bar", "furlong", "deg"])
def test_a_unit_of_another_quantity_is_refused_by_its_name(tmp_path, unit):
    asammdf = pytest.importorskip("asammdf")
    signals = drawn(np.random.default_rng(1))
    with asammdf.MDF(version="4.10") as file:
        for signal in signals:
            shown = unit if signal.channel == "ay" else signal.unit
            file.append([asammdf.Signal(signal.values, signal.times, name=signal.name, unit=shown)])
        file.save(tmp_path / "log.mf4")
    with pytest.raises(DataError, match=rf"log.mf4: column \S+: .*'{unit}'"):
        read_log(tmp_path / "log.mf4", columns_of(signals))


def test_a_bench_recording_of_different_rates_is_refused_with_the_remedy(tmp_path):
    asammdf = pytest.importorskip("asammdf")
    with asammdf.MDF(version="4.10") as file:
        for name, step in (("alpha", 0.01), ("Fz", 0.01), ("Fy", 0.02)):
            t = step * np.arange(100)
            file.append([asammdf.Signal(900.0 + t, t, name=name)])
        file.save(tmp_path / "run.mf4")
    with pytest.raises(DataError, match="at other times: export the channels with one time base"):
        read_recording(tmp_path / "run.mf4")
