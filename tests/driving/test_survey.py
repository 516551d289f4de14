"""inspect of a log: columns, nearest channels, axes, and the section of a car file, with which the log is read."""

from __future__ import annotations

import json

import numpy as np
import pandas as pd
import pytest

from tirefmu.applications.driving.inputs.log import LOG_CHANNELS, read_log
from tirefmu.applications.driving.inputs.nearest_channel import nearest_channel
from tirefmu.applications.driving.inputs.survey import survey
from tirefmu.boundary.bounded_file import toml_file
from tirefmu.boundary.errors import DataError, TirefmuError
from tirefmu.commands.cli import main
from tirefmu.measurements import words_of
from tirefmu.measurements.files.columns.content import Column, Content

T = np.arange(0.0, 20.0, 0.05)
STEER = 0.4 * np.sin(T)
LOG = pd.DataFrame({"t": T, "steer": STEER, "speed": 15.0, "yaw_rate": 0.4 * STEER, "ax": 0.2, "ay": 6.0 * STEER})


def logger(rows: pd.DataFrame, **changes: object) -> pd.DataFrame:
    """Return a log under other names, in other units."""
    return pd.DataFrame({
        "Time": rows["t"], "Steered Angle [deg]": np.degrees(rows["steer"]), "Ground Speed [km/h]": 3.6 * rows["speed"],
        "Gyro Z [deg/s]": np.degrees(rows["yaw_rate"]), "G Force Long [G]": rows["ax"] / 9.80665,
        "G Force Lat [G]": rows["ay"] / 9.80665, **changes,
    })  # fmt: skip


DOWN = LOG.assign(**{name: -LOG[name] for name in ("steer", "yaw_rate", "ay")})
CASES = {
    "left": logger(LOG),
    "down": logger(DOWN, **{"G Force Vert [G]": -1.0}),
    "yaw rate to the right": logger(LOG.assign(yaw_rate=-LOG["yaw_rate"])),
    "steering to the right": logger(LOG.assign(steer=-LOG["steer"])),
    "exchanged": logger(LOG.assign(ax=LOG["ay"], ay=LOG["ax"])),
    "milliseconds": logger(LOG.assign(t=1e3 * LOG["t"])),
}


@pytest.mark.parametrize("case", CASES)
def test_the_proposed_section_reads_the_log(tmp_path, monkeypatch, case):
    monkeypatch.chdir(tmp_path)
    CASES[case].to_csv("log.csv", index=False)
    assert main(["inspect", "log.csv", "-o", "car.toml", "--json", "found.json", "--quiet"]) == 0
    proposal = json.loads((tmp_path / "found.json").read_text(encoding="utf-8"))["proposal"]
    columns = toml_file(tmp_path / "car.toml", TirefmuError)["columns"]
    assert columns == proposal
    log = read_log("log.csv", columns)
    for name in ("steer", "speed", "yaw_rate", "ax", "ay"):
        np.testing.assert_allclose(log.values(name), LOG[name], atol=1e-12)
        np.testing.assert_allclose(log.channels[name][0], T, atol=1e-9)
    assert main(["inspect", "log.csv", "-o", "car.toml", "--quiet"]) == 2  # the numbers of a car are not lost


#: The channels of LOG in other words, in units that numbers do not show.
WORDS = {
    "t": (["elapsed", "time"], "ms", 1e3), "steer": (["steering", "angle"], "deg", np.degrees(1.0)),
    "speed": (["ground", "speed"], "km/h", 3.6), "yaw_rate": (["angular", "velocity", "z"], "deg/s", np.degrees(1.0)),
    "ax": (["longitudinal", "accel"], "m/s2", 1.0), "ay": (["lateral", "accel"], "m/s2", 1.0),
}  # fmt: skip
SPELLED = {
    "snake": lambda words, unit: f"{'_'.join(words)}_{unit.replace('/', '_')}",
    "camel": lambda words, unit: f"{''.join(map(str.title, words))}_{unit.replace('/', 'p')}",
    "spaced": lambda words, unit: f"{' '.join(map(str.title, words))} ({unit})",
    "path": lambda words, unit: f"/car/state/{'/'.join(words)} [{unit}]",
    "dots": lambda words, unit: f"field.car.{'.'.join(words)}_{unit}",
    "exchanged": lambda words, unit: f"{'_'.join(words[::-1])}_{unit}",
    "behind": lambda words, unit: f"{'_'.join(words)}_{unit.replace('/', '_')}_filtered",
    "of a sensor": lambda words, unit: f"{''.join(map(str.title, words))}_{unit.replace('/', 'p')}_gps.raw",
    "longer": lambda words, unit: f"{'_'.join(words)}_sensors [{unit}]",
}


@pytest.mark.parametrize("spelling", SPELLED)
def test_a_name_counts_in_any_spelling_and_with_its_unit(tmp_path, monkeypatch, spelling):
    monkeypatch.chdir(tmp_path)
    spell = SPELLED[spelling]
    slow = LOG.assign(steer=0.01 * STEER, yaw_rate=0.01 * LOG["yaw_rate"], ay=0.01 * LOG["ay"])
    pd.DataFrame({spell(words, unit): slow[name] * factor for name, (words, unit, factor) in WORDS.items()}).to_csv(
        "log.csv", index=False
    )
    assert main(["inspect", "log.csv", "-o", "car.toml", "--quiet"]) == 0
    log = read_log("log.csv", toml_file(tmp_path / "car.toml", TirefmuError)["columns"])
    for name in WORDS:
        values = log.channels["steer"][0] if name == "t" else log.values(name)
        np.testing.assert_allclose(values, slow[name], rtol=1e-12, atol=1e-12)


@pytest.mark.parametrize(
    ("name", "channel"),
    [
        ("yawrate", "yaw_rate"),
        ("latacc", "ay"),
        ("Lateral G", "ay"),
        ("Lateral Gs", "ay"),
        ("Gforce Lat", "ay"),
        ("GLong", "ax"),
        ("GPS LatAcc", "ay"),
        ("LATERALG", "ay"),
        ("GPS Gyro", ""),  # the turn of the path
        ("AVz", "yaw_rate"),
        ("Gyroscope z", "yaw_rate"),
        ("Steer.WhlAng", "steer"),
        ("z_rate_of_rotation", "yaw_rate"),
        ("Time Stamp", "t"),
        ("front_left wheel speed", "omega_fl"),
        ("Corr Speed", "speed"),
        ("Car.ay", "ay"),
        ("Car.vx", "speed"),
        ("imu_gz", "yaw_rate"),
        ("wz", "yaw_rate"),
        ("mpu_ang_vel_z", "yaw_rate"),
        ("AngVel_Z", "yaw_rate"),
        ("Gyr_Z", "yaw_rate"),
        ("VehSpd", "speed"),
        ("ay_cg", "ay"),
        ("HandWheelAngle", "steer"),
        ("ay_filtered", "ay"),
        ("a_y_IMU", "ay"),
        ("accx_can", "ax"),
        ("acc_body_y", "ay"),
        ("vel_body_x", "speed"),
        ("twist/angular/z", "yaw_rate"),
        ("Car.WheelSpd_FL", "omega_fl"),
        ("Car.SideSlipAngle", "beta"),
        ("Angular rate Zv", "yaw_rate"),
        ("Acceleration Yv", "ay"),
        ("angvel_z", "yaw_rate"),
        ("accely", "ay"),
        ("gyroz", "yaw_rate"),
        ("wheel_fl_rps", "omega_fl"),
        ("Wheel RL [rpm]", "omega_rl"),
        ("w_rr_rad_s", "omega_rr"),
        ("WhlRPM_FR", "omega_fr"),
        ("FrontLeftWheelRPM", "omega_fl"),
        ("carState.wheelSpeeds.rl", "omega_rl"),
        ("LR_wheel_speed", "omega_rl"),
        ("Raddrehzahl vorne links", "omega_fl"),
        ("wheel_angular_velocity_left_rear", "omega_rl"),
    ],
)
def test_a_name_counts_joined_separated_and_in_another_order(name, channel):
    assert nearest_channel(Column(name, [])) == channel


@pytest.mark.parametrize("name", [
    "G(z)", "imu/orientation/x", "imu/x", "Car.x", "air_speed_x/y", "Steering Torque [Nm]", "yaw_moment",
    "Vhcl.FL.SideSlip", "RR_ay", "Car.CFL.vx", "Trailer.ay", "AngularVelocityY", "imu/angular_velocity/x",
    "Vertical Velocity", "wind_velocity", "steering_angle_target", "cmd_steering_angle", "vehicle_speed_limit",
    "GPS Speed Accuracy", "lateral_acceleration_variance", "ang_vel_x", "steering_velocity", "SteeringWheelSpeed",
    "steeringRateDeg", "steering_angle_velocity", "yaw_acceleration", "COG", "wheel_fl", "w_rr", "wheel_fl_torque",
    "wheel_speed_fl_kmh", "FL_wheel_speed_mph_filtered", "wheel_speed_rl [km/h]", "LF wheel speed [m/s]",
    "brake_fl_rpm_target",
])  # fmt: skip
def test_a_name_of_something_else_is_no_channel(name):
    assert nearest_channel(Column(name, [])) == ""


@pytest.mark.parametrize("change", ["{}_derivative", "{} Jerk", "d/dt {}_dot", "{}_power"])
def test_the_change_of_a_channel_is_none(change):
    """In the name of any alias, but of a heading, whose change is the yaw rate."""
    for channel in LOG_CHANNELS.values():
        for alias in (channel.name, *channel.aliases):
            other = nearest_channel(Column(change.format(alias), []))
            assert other in {"", "yaw_rate"} - {channel.name}


@pytest.mark.parametrize(
    "names", [("G Force Long", "G Force Lat"), ("Longitudinal Gs", "Lateral Gs"), ("LINEALG", "LATERALG")]
)
def test_a_name_in_g_declares_its_unit(tmp_path, monkeypatch, names):
    """Also of a gentle drive, whose numbers may be m/s^2."""
    monkeypatch.chdir(tmp_path)
    slow = LOG.assign(ax=0.1 * LOG["ax"], ay=0.1 * LOG["ay"])
    gentle = slow.assign(ax=slow["ax"] / 9.80665, ay=slow["ay"] / 9.80665)
    gentle.rename(columns=dict(zip(("ax", "ay"), names, strict=True))).to_csv("log.csv", index=False)
    assert main(["inspect", "log.csv", "-o", "car.toml", "--quiet"]) == 0
    log = read_log("log.csv", toml_file(tmp_path / "car.toml", TirefmuError)["columns"])
    for name in ("ax", "ay"):
        np.testing.assert_allclose(log.values(name), slow[name], atol=1e-12)


@pytest.mark.parametrize("down", [False, True], ids=["up", "down"])
@pytest.mark.parametrize(("size", "other"), [(1.0, 1.02), (1000.0, 1000.0), (9.80665, 9.5), (9.80665, 0.0)])
def test_the_vertical_acceleration_shows_the_unit_of_the_others(tmp_path, monkeypatch, size, other, down):
    """Also of a gentle drive. One without gravity shows nothing: SI is proposed."""
    monkeypatch.chdir(tmp_path)
    slow = LOG.assign(**{name: 0.1 * LOG[name] for name in ("steer", "yaw_rate", "ax", "ay")})
    turned = slow.assign(**{name: -slow[name] for name in ("steer", "yaw_rate", "ay")}) if down and other else slow
    log = turned.assign(
        ax=turned["ax"] / 9.80665 * size, ay=turned["ay"] / 9.80665 * size, az=-other if down else other
    )
    names = {"ax": "X_ACCELERATION", "ay": "Y_ACCELERATION", "az": "Z_ACCELERATION", "yaw_rate": "Z_ANGLE_RATE"}
    log.rename(columns=names).to_csv("log.csv", index=False)
    assert main(["inspect", "log.csv", "-o", "car.toml", "--quiet"]) == 0
    log = read_log("log.csv", toml_file(tmp_path / "car.toml", TirefmuError)["columns"])
    for name in ("ax", "ay", "steer", "yaw_rate"):
        np.testing.assert_allclose(log.values(name), slow[name], atol=1e-12)


def test_a_vertical_acceleration_of_another_sensor_shows_nothing(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    nptdms = pytest.importorskip("nptdms")
    groups = {"car": LOG.drop(columns="t"), "seat": pd.DataFrame({"az": np.full(len(T), 1.0)})}
    with nptdms.TdmsWriter("log.tdms") as writer:
        for group, table in groups.items():
            for name in table:
                cells = table[name].to_numpy()
                writer.write_segment([nptdms.ChannelObject(group, name, cells, {"wf_increment": 0.05})])
    assert main(["inspect", "log.tdms", "-o", "car.toml", "--quiet"]) == 0
    columns = toml_file(tmp_path / "car.toml", TirefmuError)["columns"]
    assert "[g]" not in columns.get("ay", "")


@pytest.mark.filterwarnings("error")
def test_a_column_without_a_number_is_proposed_for_no_channel(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    LOG.assign(ay=np.nan, heading=np.nan).rename(columns={"ay": "AccelY"}).to_csv("log.csv", index=False)
    assert main(["inspect", "log.csv"]) == 0
    out = capsys.readouterr().out
    assert 'ay = "AccelY"' not in out
    assert "needed for an estimate of the tires: ay" in out


def quaternion(heading, pitch, roll):
    """Return w, x, y, z of a rotation about z, then y, then x: the product of three."""
    (cz, cy, cx), (sz, sy, sx) = ([f(0.5 * angle) for angle in (heading, pitch, roll)] for f in (np.cos, np.sin))
    return {"w": cz * cy * cx + sz * sy * sx, "x": cz * cy * sx - sz * sy * cx,
            "y": cz * sy * cx + sz * cy * sx, "z": sz * cy * cx - cz * sy * sx}  # fmt: skip


@pytest.mark.parametrize("name", ["q_{}", "orientation.{}", "/odom/pose/orientation/{}", "Quat {} [1]", "q{}"])
@pytest.mark.parametrize("order", ["wxyz", "xyzw"])
def test_the_heading_of_a_quaternion_is_read(tmp_path, monkeypatch, name, order):
    """With the sign of q or -q, and rows before the sensor has a rotation."""
    monkeypatch.chdir(tmp_path)
    heading = 3.0 * np.sin(0.5 * T) + 0.4 * T
    parts = quaternion(heading, 0.1 * np.cos(T), 0.2 * np.sin(3.0 * T))
    sign = np.where(T < 1.0, 0.0, np.where(T < 9.0, -1.0, 1.0))
    pose = {"x": 15.0 * np.cos(T), "y": 15.0 * np.sin(T)}
    LOG.assign(**pose, **{name.format(part): sign * parts[part] for part in order}).to_csv("log.csv", index=False)
    assert main(["inspect", "log.csv", "-o", "car.toml", "--quiet"]) == 0
    log = read_log("log.csv", toml_file(tmp_path / "car.toml", TirefmuError)["columns"])
    t, read = log.channels["heading"]
    np.testing.assert_allclose(t, T[T >= 1.0])
    np.testing.assert_allclose(np.exp(1j * read), np.exp(1j * heading[T >= 1.0]), atol=1e-9)


@pytest.mark.parametrize("parts", [
    {"w": 1.0, "x": 0.0, "y": 0.0, "z": 0.0}, {"w": STEER, "x": STEER, "y": 0.3, "z": 0.5}, {"w": 0.0, "x": 1.0},
], ids=["never changes", "no rotation", "two"])  # fmt: skip
def test_four_columns_that_are_no_rotation_have_no_heading(tmp_path, monkeypatch, capsys, parts):
    monkeypatch.chdir(tmp_path)
    LOG.assign(**{f"q_{part}": cells for part, cells in parts.items()}).to_csv("log.csv", index=False)
    assert main(["inspect", "log.csv"]) == 0
    assert "heading" not in capsys.readouterr().out


def test_the_words_of_a_name_are_found_once():
    """Not for each of the hundred names that it is compared with: results of simulations have thousands."""
    columns = tuple(Column(f"car.body.part{i}.frame_a.r_{i}", STEER) for i in range(200))
    words_of.cache_clear()
    survey(Content((Column("t", T), *columns)), "log")
    assert words_of.cache_info().misses < 10 * len(columns)


@pytest.mark.parametrize("types", [[], ["C1"] * 6])
@pytest.mark.parametrize("units", [[], ["s", "rad", "m/s", "rad/s", "m/s^2", "m/s^2"]])
@pytest.mark.parametrize("above", [[], ["Created: 2026-11-29", "run, 5"]])
@pytest.mark.parametrize("quote", ["", '"'])
def test_names_behind_a_comment_mark_are_names(tmp_path, monkeypatch, types, units, above, quote):
    """As in exports of CarMaker and in files of numpy.savetxt."""
    monkeypatch.chdir(tmp_path)
    names = ["Time", "Driver.Steer.Ang", "Car.vx", "Car.YawRate", "Car.ax", "Car.ay"]
    head = [",".join(f"{quote}{cell}{quote}" for cell in row) for row in (names, types, units) if row]
    body = [
        ",".join(map(repr, row)) for row in LOG[["t", "steer", "speed", "yaw_rate", "ax", "ay"]].to_numpy().tolist()
    ]
    (tmp_path / "log.csv").write_text("\n".join([*(f"# {line}" for line in (*above, *head)), *body]), encoding="utf-8")
    assert main(["inspect", "log.csv", "-o", "car.toml", "--quiet"]) == 0
    log = read_log("log.csv", toml_file(tmp_path / "car.toml", TirefmuError)["columns"])
    for name in ("steer", "speed", "yaw_rate", "ax", "ay"):
        np.testing.assert_allclose(log.values(name), LOG[name], atol=1e-12)
        np.testing.assert_allclose(log.channels[name][0], T, atol=1e-9)


@pytest.mark.parametrize("name", ["G_Sensor_Front_Yaw_Rate", "wheel_speed_rl", "Gierrate"])
def test_a_channel_that_no_bench_has_makes_a_log(tmp_path, monkeypatch, capsys, name):
    monkeypatch.chdir(tmp_path)
    LOG[["t", "speed", "yaw_rate"]].rename(columns={"yaw_rate": name}).to_csv("log.csv", index=False)
    assert main(["inspect", "log.csv"]) == 0
    assert "the log of a drive" in capsys.readouterr().out


@pytest.mark.parametrize("stamp", [False, True])
def test_a_log_without_names_is_said_to_have_none(tmp_path, monkeypatch, capsys, stamp):
    monkeypatch.chdir(tmp_path)
    times = [f"2026_11_29_12_00_{t:06.3f}".replace(".", "_") for t in T] if stamp else T
    LOG.assign(t=times).to_csv("log.csv", index=False, header=False)
    assert main(["inspect", "log.csv"]) == 2
    assert "no names: write a row of names above it" in " ".join(capsys.readouterr().err.split())
    with pytest.raises(DataError, match=r"no channel t \(time\): its first row has numbers and no names"):
        read_log("log.csv")
    LOG[["steer"]].to_csv("log.csv", index=False, header=False)
    with pytest.raises(DataError, match="its first row has numbers and no names"):
        read_log("log.csv")


def test_a_comment_above_names_is_no_row_of_names(tmp_path):
    lines = [",".join(LOG), *(",".join(map(repr, row)) for row in LOG.to_numpy().tolist())]
    (tmp_path / "log.csv").write_text("\n".join(["# a,b,c,d,e,f", *lines]), encoding="utf-8")
    np.testing.assert_allclose(read_log(tmp_path / "log.csv").values("ay"), LOG["ay"], atol=1e-12)


def test_decimal_commas_of_a_log_are_stated(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    CASES["left"].to_csv("log.csv", index=False, sep=";", decimal=",")
    assert main(["inspect", "log.csv", "-o", "car.toml"]) == 0
    assert "# commas in numbers are read as decimal points" in capsys.readouterr().out
    log = read_log("log.csv", toml_file(tmp_path / "car.toml", TirefmuError)["columns"])
    np.testing.assert_allclose(log.values("ay"), LOG["ay"], atol=1e-12)


def test_the_log_of_a_simulated_car_has_forces_of_its_wheels(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    forces = {f"{name}_{wheel}": 0.0 * T for name in ("Fy", "Fz", "Alpha") for wheel in ("L1", "R1", "L2", "R2")}
    LOG.rename(columns={"steer": "Steer_SW", "yaw_rate": "AVz"}).assign(**forces).to_csv("log.csv", index=False)
    assert main(["inspect", "log.csv"]) == 0
    assert 'yaw_rate = "AVz"' in capsys.readouterr().out


def test_what_a_log_of_a_phone_lacks_is_stated_at_once(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    phone = LOG[["t", "speed", "ay"]].assign(latitude=31.0, longitude=121.0)
    phone.to_csv("log.csv", index=False)
    with pytest.raises(DataError) as refusal:
        read_log("log.csv")
    for text in ("no channel steer (", "no channel yaw_rate (", "or x, y and heading): it comes from a gyroscope"):
        assert text in str(refusal.value)
    assert "no channel ay" not in str(refusal.value)
    assert main(["inspect", "log.csv", "--json", "found.json"]) == 0
    assert "not there, and needed for an estimate of the tires: steer, yaw_rate" in capsys.readouterr().out
    # Without a channel of a drive but its speed, the positions show that it is no table of a bench.
    phone.rename(columns={"speed": "GPS Speed(km/h)"}).drop(columns="ay").to_csv("log.csv", index=False)
    assert main(["inspect", "log.csv"]) == 0
    assert "needed for an estimate of the tires: steer, yaw_rate, ay" in capsys.readouterr().out


def test_a_column_that_occurs_twice_is_proposed_with_its_source(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    head = [",".join([*LOG, "speed"]), "s,rad,m/s,rad/s,m/s2,m/s2,km/h", ",,gps,calc,calc,calc,obd"]
    lines = [",".join(map(repr, row)) for row in LOG.assign(other=54.0).to_numpy().tolist()]
    (tmp_path / "log.csv").write_text("\n".join([*head, *lines]), encoding="utf-8")
    assert main(["inspect", "log.csv", "-o", "car.toml", "--quiet"]) == 0
    columns = toml_file(tmp_path / "car.toml", TirefmuError)["columns"]
    assert columns == {"speed": "gps/speed"}
    np.testing.assert_allclose(read_log("log.csv", columns).values("speed"), 15.0)


def test_a_car_file_that_is_proposed_lacks_its_numbers(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    CASES["left"].to_csv("log.csv", index=False)
    assert main(["inspect", "log.csv", "-o", "car.toml"]) == 0
    assert main(["drive", "log.csv", "--vehicle", "car.toml", "--tire", "unicamp_small_tire", "-o", "answer"]) == 2
    assert "lacks" in capsys.readouterr().err


def test_a_table_of_a_bench_is_no_log(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    alpha = 0.1 * np.sin(T)
    pd.DataFrame({"t": T, "alpha": alpha, "Fz": 900.0, "Fy": -9e3 * np.tanh(alpha), "yaw_rate": 0.0, "ay": 0.0}).to_csv(
        "bench.csv", index=False
    )
    main(["inspect", "bench.csv"])
    assert "the log of a drive" not in capsys.readouterr().out


@pytest.mark.parametrize(
    ("columns", "wrong"),
    [("yaw_rate=Gyro Z,steer=-Steered Angle [deg]", ""), ("steer=Gyro Z [deg],yaw_rate=-Gyro Z [deg/s]", "sign")],
)
def test_what_the_user_names_is_proposed_as_named(tmp_path, monkeypatch, capsys, columns, wrong):
    monkeypatch.chdir(tmp_path)
    CASES["left"].to_csv("log.csv", index=False)
    assert main(["inspect", "log.csv", "--columns", columns, "--json", "found.json"]) == 0
    assert "the log of a drive" in capsys.readouterr().out
    found = json.loads((tmp_path / "found.json").read_text(encoding="utf-8"))
    for entry in columns.split(","):
        name, _, text = entry.partition("=")
        assert found["proposal"][name] == text
    assert any(wrong in note for note in found["notes"]) or not wrong


def test_a_column_that_a_log_lacks_is_named(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    CASES["left"].to_csv("log.csv", index=False)
    for columns in ("yaw_rate=Gyro Y", "yawrate=Gyro Z"):
        assert main(["inspect", "log.csv", "--columns", columns]) == 2
    assert main(["inspect", "log.csv", "--units", "yaw_rate=deg/s"]) == 2
    error = capsys.readouterr().err
    assert "no column 'Gyro Y' (yaw_rate): did you mean Gyro Z" in error
    assert "unknown channel 'yawrate': did you mean yaw_rate" in error


@pytest.mark.parametrize("speed", [54.0, None])
@pytest.mark.parametrize("spelling", ["{}_rps", "{} [rps]", "{} (RPS)", "imu/{}.rps"])
@pytest.mark.parametrize(("unit", "factor"), [("rad/s", 1.0), ("rev/s", 2.0 * np.pi)])
def test_a_unit_of_two_meanings_is_proposed_with_its_reason(
    tmp_path, monkeypatch, capsys, spelling, unit, factor, speed
):
    """rps: a gyroscope has radians, a wheel what makes a wheel of its speed; both are stated."""
    monkeypatch.chdir(tmp_path)
    rows = LOG.drop(columns=["speed", "yaw_rate"]).assign(
        **{spelling.format("yaw_rate"): LOG["yaw_rate"], spelling.format("wheel_speed_rl"): 50.0 / factor}
    )
    (rows if speed is None else rows.assign(**{"speed [km/h]": speed})).to_csv("log.csv", index=False)
    assert main(["inspect", "log.csv", "-o", "car.toml"]) == 0
    assert capsys.readouterr().out.count("is rad/s or rev/s: ") == 2
    columns = toml_file(tmp_path / "car.toml", TirefmuError)["columns"]
    assert columns["yaw_rate"].endswith("[rad/s]")
    assert columns["omega_rl"].endswith(f"[{unit if speed else 'rad/s'}]")
    if speed:
        log = read_log("log.csv", columns)
        np.testing.assert_allclose(log.values("yaw_rate"), LOG["yaw_rate"], atol=1e-12)
        np.testing.assert_allclose(log.values("omega_rl"), 50.0, atol=1e-12)


@pytest.mark.parametrize(("name", "stated"), [("wheel_speed_{}", True), ("wheel_speed_{} [rad/s]", False)])
@pytest.mark.parametrize(("unit", "factor", "radius"), [("km/h", 3.6, "0.278"), ("m/s", 1.0, "1")])
def test_spins_with_the_numbers_of_the_speed_are_stated(
    tmp_path, monkeypatch, capsys, name, stated, unit, factor, radius
):
    monkeypatch.chdir(tmp_path)
    spins = {name.format(wheel): factor * LOG["speed"] for wheel in ("front_left", "RR")}
    LOG.assign(**spins).to_csv("log.csv", index=False)
    assert main(["inspect", "log.csv"]) == 0
    note = f"omega_fl, omega_rr: wheels of {radius} m in rad/s, or speeds in {unit}"
    assert (note in " ".join(capsys.readouterr().out.split())) == stated


TURNING = LOG.assign(ay=15.0 * LOG["yaw_rate"] * (1.05 + 0.1 * np.sin(3.0 * T)))


@pytest.mark.parametrize(("speed", "v"), [("", 1.0), ("km/h", 3.6), ("mph", 1.0 / 0.44704)])
@pytest.mark.parametrize(("rate", "r"), [("", 1.0), ("deg/s", np.degrees(1.0))])
@pytest.mark.parametrize(("lateral", "a"), [("", 1.0), ("g", 1.0 / 9.80665)])
def test_units_with_which_a_car_turns_are_proposed(tmp_path, monkeypatch, capsys, speed, v, rate, r, lateral, a):
    """The lateral acceleration of a car is speed times yaw rate, whatever the car; a user's units are kept."""
    monkeypatch.chdir(tmp_path)
    TURNING.assign(speed=v * TURNING["speed"], yaw_rate=0.3 * r * TURNING["yaw_rate"], ay=0.3 * a * TURNING["ay"],
                   steer=0.1 * STEER).to_csv("log.csv", index=False)  # fmt: skip
    assert main(["inspect", "log.csv", "-o", "car.toml"]) == 0
    assert ("ay is speed times yaw rate with" in capsys.readouterr().out) == bool(speed or rate or lateral)
    log = read_log("log.csv", toml_file(tmp_path / "car.toml", TirefmuError)["columns"])
    for name, factor in (("speed", 1.0), ("yaw_rate", 0.3), ("ay", 0.3)):
        np.testing.assert_allclose(log.values(name), factor * TURNING[name], atol=1e-12)
    assert main(["inspect", "log.csv", "--columns", "speed=speed,yaw_rate=yaw_rate,ay=ay", "--quiet"]) == 0


def test_an_acceleration_of_something_else_is_stated(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    TURNING.assign(ay=0.1 * TURNING["ay"]).rename(columns={"ay": "ay [g]"}).to_csv("log.csv", index=False)
    assert main(["inspect", "log.csv"]) == 0
    assert "ay is 0.98 times" not in (out := " ".join(capsys.readouterr().out.split()))
    assert "another unit of one of them" not in out
    TURNING.assign(ay=0.65 * TURNING["ay"]).rename(columns={"ay": "ay [m/s^2]"}).to_csv("log.csv", index=False)
    assert main(["inspect", "log.csv"]) == 0
    assert "ay is 0.68 times speed times yaw rate: another unit" in " ".join(capsys.readouterr().out.split())


def test_zeros_that_only_contain_a_name_are_proposed_for_no_channel(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    LOG.drop(columns="yaw_rate").assign(local_angular_velocity_z_0=0.0).to_csv("log.csv", index=False)
    assert main(["inspect", "log.csv"]) == 0
    assert "yaw_rate =" not in capsys.readouterr().out


@pytest.mark.parametrize("columns", [{}, {"yaw_rate": "yaw_rate"}, {"yaw_rate": "yaw_rate [rps]"}])
@pytest.mark.parametrize("name", ["yaw_rate [rps]", "yaw_rate_rps"])
def test_a_unit_of_two_meanings_is_refused(name, columns):
    named = {channel: text.replace("yaw_rate", name.split(" ")[0]) for channel, text in columns.items()}
    with pytest.raises(DataError, match=r"yaw_rate.*rad/s.* or .*rev/s|no channel yaw_rate"):
        read_log(LOG.rename(columns={"yaw_rate": name}), named)
    np.testing.assert_allclose(
        read_log(LOG.rename(columns={"yaw_rate": name}), {"yaw_rate": f"{name.split(' ')[0]} [rad/s]"}).values(
            "yaw_rate"
        ),
        LOG["yaw_rate"],
    )


@pytest.mark.parametrize(
    ("change", "note"),
    [
        ({"t": T[::-1]}, "time decreases at sample 2"),
        ({"t": np.where(T < 5.0, T, T - 3.0)}, "time decreases at sample 101"),
        (
            {"steer": np.clip(3.0 * STEER, -1.0, 1.0)},
            "steer ends at exactly -1 and 1, as a share of the lock does: state",
        ),
        (
            {"steer": np.clip(300.0 * STEER, -100.0, 100.0)},
            "as a share of the lock does: divide it by 100 and state map",
        ),
        ({"ax": LOG["ay"]}, "ax, ay have the same numbers: copies of one"),
        ({"t": None}, "not there, and needed for an estimate of the tires: t"),
        ({"t": None, "ay": None}, "not there, and needed for an estimate of the tires: t, ay"),
    ],
)
def test_inspect_states_what_an_estimate_would_refuse(tmp_path, monkeypatch, capsys, change, note):
    monkeypatch.chdir(tmp_path)
    for rows, stated in ((LOG, False), (LOG.assign(**change).dropna(axis=1), True)):
        rows.to_csv("log.csv", index=False)
        assert main(["inspect", "log.csv"]) == 0
        assert (note in " ".join(capsys.readouterr().out.split())) == stated
