"""The car file and the log: what is read, with which uncertainty, and one clear line for what cannot be used."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
import road
from scipy.io import savemat

from tirefmu.applications.driving.inputs.car import Car, read_car
from tirefmu.applications.driving.inputs.car_entries import ENTRIES, car_schema
from tirefmu.applications.driving.inputs.clock import clock_problem
from tirefmu.applications.driving.inputs.grid import forward_speed, gridded, with_delays
from tirefmu.applications.driving.inputs.log import read_log
from tirefmu.applications.driving.inputs.plausibility import check_log, check_wheel_speeds, exchanged_axles
from tirefmu.applications.driving.verdict import CarFinding, _deviation
from tirefmu.boundary.errors import DataError, TirefmuError
from tirefmu.commands.cli import main


def test_the_example_is_a_car_and_follows_the_schema(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    assert main(["drive", "--example", "--quiet"]) == 0
    car = read_car("car.toml")
    assert car.values == {name: entry.example for name, entry in ENTRIES.items()}
    assert car.uncertainties["mass"] == pytest.approx(33.0)
    schema = json.loads((tmp_path / "tirefmu-car.schema.json").read_text(encoding="utf-8"))
    assert schema == car_schema()
    Path("car.toml").write_text("[body]\nmass = 900.0\n", encoding="utf-8")
    assert main(["drive", "--example", "--quiet"]) == 2  # the numbers of the user remain
    assert "900" in Path("car.toml").read_text(encoding="utf-8")


def test_axle_masses_give_mass_and_position():
    content = road.car_content()
    del content["body"]["mass"], content["body"]["cg_to_front"]
    content["body"] |= {"front_mass": 750.0, "rear_mass": 500.0}
    car = Car.from_content(content, "car.toml")
    assert car.values["mass"] == 1250.0
    assert car.axle_loads == pytest.approx((750.0 * 9.80665, 500.0 * 9.80665))


@pytest.mark.parametrize(
    ("section", "key", "value", "message"),
    [
        ("body", "mas", 1.0, "did you mean mass?"),
        ("bodi", "mass", 1.0, "did you mean body?"),
        ("body", "mass", "heavy", "body.mass is 'heavy': expected a number"),
        ("body", "mass", -3.0, "body.mass is -3.0: expected a number of at least 0.1"),
        (
            "body",
            "mass",
            {"value": 1.0, "uncertainty": -1.0},
            "body.mass.uncertainty is -1.0: expected",
        ),
        ("body", "cg_to_front", 9.0, "negative"),
        ("wheels", "driven", "left", "unknown word 'left' in wheels.driven"),
        ("steering", "map", [[0.0, 1.0]], "steering.map is"),
        ("columns", "ay", 3, "columns.ay is 3: expected a text"),
    ],
)
def test_an_invalid_car_is_one_clear_line(section, key, value, message):
    content = road.car_content()
    content.setdefault(section, {})[key] = value
    with pytest.raises(TirefmuError) as refusal:
        Car.from_content(content, "car.toml")
    assert message in str(refusal.value)
    assert "car.toml" in str(refusal.value)


def test_every_format_is_the_same_log(tmp_path):
    t = np.arange(0.0, 10.0, 0.01)
    table = pd.DataFrame({"t": t, "steer": np.sin(t), "speed": 10.0 + 0 * t, "yaw_rate": np.sin(t), "ay": np.cos(t)})
    table.to_csv(tmp_path / "a.csv", index=False)
    savemat(tmp_path / "a.mat", {name: table[name].to_numpy() for name in table})
    logs = [read_log(table), read_log(tmp_path / "a.csv"), read_log(tmp_path / "a.mat")]
    if pytest.importorskip("pyarrow"):
        table.to_parquet(tmp_path / "a.parquet")
        logs.append(read_log(tmp_path / "a.parquet"))
    for log in logs[1:]:
        for name, (times, values) in logs[0].channels.items():
            np.testing.assert_allclose(log.channels[name], (times, values), rtol=1e-12)


def test_mdf_channels_have_their_own_times(tmp_path):
    asammdf = pytest.importorskip("asammdf", reason="the extra mdf is not installed")
    fast, slow = np.arange(0.0, 10.0, 0.01), np.arange(0.0, 10.0, 0.05)
    signals = [
        asammdf.Signal(np.degrees(np.sin(fast)), fast, name="steer", unit="deg"),
        asammdf.Signal(36.0 + 0 * slow, slow, name="speed", unit="km/h"),
        asammdf.Signal(np.sin(fast), fast, name="yaw_rate", unit="rad/s"),
        asammdf.Signal(np.cos(fast) / 9.80665, fast, name="ay", unit="g"),
    ]
    with asammdf.MDF() as file:
        for signal in signals:
            file.append([signal])
        file.save(tmp_path / "a.mf4")
    log = read_log(tmp_path / "a.mf4")
    assert len(log.values("speed")) == len(slow)
    np.testing.assert_allclose(log.values("speed"), 10.0)
    np.testing.assert_allclose(log.values("steer"), np.sin(fast), atol=1e-12)
    np.testing.assert_allclose(log.values("ay"), np.cos(fast), atol=1e-12)


def test_units_and_other_names(tmp_path):
    t = np.arange(0.0, 10.0, 0.01)
    table = pd.DataFrame({"time": t, "steer [deg]": np.degrees(np.sin(t)), "v (km/h)": 36.0 + 0 * t})
    table = table.assign(**{"yaw_rate [deg/s]": 1.0 + 0 * t, "ay": t})
    log = read_log(table, {"t": "time", "speed": "v"})
    np.testing.assert_allclose(log.values("steer"), np.sin(t), atol=1e-12)
    np.testing.assert_allclose(log.values("speed"), 10.0)
    np.testing.assert_allclose(log.values("yaw_rate"), np.radians(1.0))
    whole = read_log(table, {"t": "time", "speed": "v (km/h)", "steer": "steer [deg]"})
    np.testing.assert_array_equal(whole.values("steer"), log.values("steer"))
    np.testing.assert_array_equal(whole.values("speed"), log.values("speed"))
    other = table.rename(columns={"steer [deg]": "steering_wheel [deg]"})
    for header in ("steering_wheel", "steering_wheel [deg]"):
        named = read_log(other, {"t": "time", "speed": "v", "steer": header})
        np.testing.assert_array_equal(named.values("steer"), log.values("steer"))
    with pytest.raises(TirefmuError, match=r"no column 'vv' \(speed\)"):
        read_log(table, {"t": "time", "speed": "vv"})


def turning(change):
    """Return a log of a car that turns as it is steered; `change` of t, steering (rad at the wheels) and yaw rate."""
    t, speed = 0.01 * np.arange(4000), 15.0
    steer = 0.03 * np.sin(2 * np.pi * (0.1 * t + 0.014 * t**2))
    rate = 0.8 * speed * steer / road.CAR["wheelbase"]
    steer, rate = change(t, steer, rate)
    table = {"t": t, "steer": road.CAR["ratio"] * steer, "speed": speed, "yaw_rate": rate, "ay": speed * rate}
    return read_log(pd.DataFrame(table))


@pytest.mark.parametrize("noise", [0.0, 1e-4])
@pytest.mark.parametrize("lag", [0.0, 0.05])
def test_a_delayed_steering_has_the_same_errors_at_every_delay(noise, lag, car):
    rng = np.random.default_rng(8)
    recorded = turning(lambda t, steer, rate: (steer + noise * rng.standard_normal(len(t)), rate))
    grid = gridded(recorded, car, forward_speed(recorded, car))
    late = {**car.values, "lag": lag}
    fine = 1e-3 * np.arange(40001)
    state, true = 0.0, 0.03 * np.sin(2 * np.pi * (0.1 * fine + 0.014 * fine**2))
    if lag:
        kept = np.exp(-1e-3 / lag)
        held = (true + np.concatenate([true[:1], true[:-1]])) / 2
        true = np.array([state := value + (state - value) * kept for value in held])
    whole = np.concatenate([[0.0], np.cumsum(true[1:] + true[:-1]) / 2e3])
    errors = []
    for delay in 1e-3 * np.arange(10):  # within a sample
        delayed = with_delays(grid, recorded, car, {**late, "delay": delay})
        ends = grid.t - delay + np.array([[-0.5], [0.5]]) * grid.step
        mean = np.diff(np.interp(ends, fine, whole), axis=0)[0] / grid.step
        errors.append((delayed.steer.mean(axis=0) - mean)[40:-40])
        later = with_delays(grid, recorded, car, {**late, "delay": delay + 1e-5})
        assert (later.steer - delayed.steer) / 1e-5 == pytest.approx(delayed.steer_slopes[:2], abs=2e-3)
    sizes = np.std(errors, axis=1)
    if noise:
        assert sizes.max() < 0.6 * noise  # the mean of 2.5 samples has 0.63
        assert np.ptp(sizes) < 0.1 * sizes.mean()
    else:
        assert sizes.max() < 1e-3 * np.std(true)
        assert np.ptp(sizes) < 2e-5 * np.std(true)


def sliding(t, steer, rate):
    """Return steering and yaw rate of a driver who counter-steers in three turns of four."""
    slides = (t % 8.0 > 2.0) & (np.abs(steer) > 0.02)
    return np.where(slides, -6.0 * steer, steer), np.where(slides, 1.5 * rate, rate)


OWN = {
    "sliding": sliding,
    "an offset": lambda t, steer, rate: (steer + 0.06, rate),
    "a delay": lambda t, steer, rate: (np.interp(t + 0.3, t, steer), rate),
}


def checked(log, car):
    speed = forward_speed(log, car)
    grid = gridded(log, car, speed)
    check_log(log, car, grid, np.interp(grid.t, *speed))


@pytest.mark.parametrize("change", OWN.values(), ids=OWN)
def test_what_the_estimate_explains_of_the_steering_is_no_refusal(change, car):
    checked(turning(change), car)


@pytest.mark.parametrize("offset", [0.0, 1.0])
def test_ay_of_a_circle_at_one_speed_follows_it_whatever_its_noise(offset, car):
    t = 0.01 * np.arange(4000)
    for seed in range(4):
        noise = 0.1 * np.random.default_rng(seed).standard_normal((2, len(t)))
        motion = {"steer": 0.6, "speed": 15.0, "yaw_rate": 0.2 + noise[0], "ay": 3.0 + offset + noise[1]}
        checked(read_log(pd.DataFrame({"t": t, **motion})), car)
        with pytest.raises(DataError, match="ay and yaw rate have opposite signs"):
            checked(read_log(pd.DataFrame({"t": t, **motion, "ay": -motion["ay"]})), car)


def test_ax_on_hills_at_a_nearly_constant_speed_is_no_other_sign(car):
    """An accelerometer measures the force, which climbs while the car loses speed."""
    driven = turning(lambda t, steer, rate: (steer, rate))
    t = driven.channels["steer"][0]
    table = pd.DataFrame({name: values for name, (_, values) in driven.channels.items()} | {"t": t})
    hill = np.sin(2 * np.pi * t / 20.0)
    climbing = table.assign(speed=15.0 + 0.5 * np.cos(2 * np.pi * t / 20.0), ax=0.6 * hill)
    checked(read_log(climbing), car)
    with pytest.raises(DataError, match="rate of the speed have opposite signs"):
        checked(read_log(climbing.assign(speed=15.0 + 2.0 * np.cos(2 * np.pi * t / 20.0))), car)


@pytest.mark.parametrize("angle", [0.3, 1.7])
def test_a_circle_at_rising_speed_explains_itself_and_a_slalom_with_held_steering_does_not(angle, car):
    t = 0.01 * np.arange(4000)
    speed = 5.0 + 0.3 * t
    rates = speed * angle / road.CAR["ratio"] / road.CAR["wheelbase"], 0.3 * np.sin(t)
    circle, slalom = (
        read_log(pd.DataFrame({"t": t, "steer": angle, "speed": speed, "yaw_rate": rate, "ay": speed * rate}))
        for rate in rates
    )
    checked(circle, car)
    with pytest.raises(DataError, match="steer hardly changes"):
        checked(slalom, car)


def test_braking_that_is_faster_than_the_steering_shortens_the_intervals(car):
    t = 0.01 * np.arange(2000)
    steer = 0.3 * np.sin(0.5 * t)
    braking = np.where(t % 4.0 < 1.0, -6.0, 2.0)
    noise = 0.1 * np.random.default_rng(3).standard_normal((2, len(t)))
    steps = []
    for ax in (noise[0], braking + noise[0]):
        ay = 15.0**2 * steer / car.values["ratio"] / 2.5
        motion = {"speed": 15.0, "yaw_rate": ay / 15.0, "ax": ax, "ay": ay + noise[1]}
        recorded = read_log(pd.DataFrame({"t": t, "steer": steer, **motion}))
        steps.append(gridded(recorded, car, forward_speed(recorded, car)).step)
    assert steps[0] == 0.1  # noise is no motion
    assert steps[1] < 0.1


@pytest.mark.parametrize("change", OWN.values(), ids=OWN)
@pytest.mark.parametrize("late", [-1900, 1300])
def test_the_log_of_another_drive_is_refused(change, late, car):
    def other(t, steer, rate):
        steer, rate = change(t, steer, rate)
        return np.roll(steer, late), rate

    with pytest.raises(DataError, match="the steering does not explain the yaw rate"):
        checked(turning(other), car)


def exchanged(log, car):
    speed = forward_speed(log, car)
    grid = gridded(log, car, speed)
    return exchanged_axles(grid, np.interp(grid.t, *speed), car)


def with_wheels(log, inner, larger=0.0):
    """Return a log with the spins of wheels, of which the inner one slips, and a left one has a larger radius."""
    t, rate = log.channels["yaw_rate"]
    half = {"f": road.CAR["track_front"] / 2, "r": road.CAR["track_rear"] / 2}
    tight = np.where(np.abs(rate) > 0.7 * np.abs(rate).max(), np.sign(rate), 0.0)
    rims = {f"omega_{end}{side}": (1.0 - larger * (side == "l")) * (15.0 + sign * (half[end] * rate - inner * tight))
            for end in "fr" for side, sign in zip("lr", (-1, 1), strict=True)}  # fmt: skip
    table = pd.DataFrame({name: values for name, (_, values) in log.channels.items()} | {"t": t})
    return table.assign(**{name: speed / road.CAR["radius_front"] for name, speed in rims.items()})


@pytest.mark.parametrize("axle", ["front", "rear"])
@pytest.mark.parametrize("slip", [0.0, 0.6])
def test_exchanged_wheel_speeds_are_exchanged_again_and_right_ones_are_not(car, axle, slip):
    """The inner wheel of a driven axle spins in tight turns."""
    table = with_wheels(turning(lambda t, steer, rate: (steer, rate)), slip)
    assert exchanged(read_log(table), car) == ()
    left, right = (f"omega_{axle[0]}{side}" for side in "lr")
    other = read_log(table.rename(columns={left: right, right: left}))
    assert exchanged(other, car) == (axle,)
    again = other.with_exchanged((axle,))
    assert again.exchanged == (axle,)
    for name, (_, values) in read_log(table).channels.items():
        np.testing.assert_array_equal(again.values(name), values)


def test_wheel_speeds_with_the_numbers_of_kmh_are_refused_until_their_unit_is_stated(car):
    """In rad/s they would be those of wheels of 0.278 m, 8 % from a common radius: a slip of all wheels."""
    table = with_wheels(turning(lambda t, steer, rate: (steer, rate)), 0.0)
    spins = [name for name in table if name.startswith("omega")]
    peripheral = table.assign(**{name: 3.6 * road.CAR["radius_front"] * table[name] for name in spins})
    radii = {"radius_front": 0.3, "radius_rear": 0.3}
    larger = replace(car, values={**car.values, **radii})
    with pytest.raises(DataError, match=r"numbers of the speed in km/h; in rad/s they would be 1\.08 times"):
        check_wheel_speeds(read_log(peripheral), larger)
    check_wheel_speeds(read_log(peripheral.rename(columns={name: f"{name} [rad/s]" for name in spins})), larger)
    check_wheel_speeds(read_log(peripheral), replace(car, values={**car.values, **dict.fromkeys(radii, 1.0 / 3.6)}))
    for radius in (0.25, 0.3, 0.33):
        same = table.assign(**{name: table[name] * road.CAR["radius_front"] / radius for name in spins})
        check_wheel_speeds(read_log(same), replace(car, values={**car.values, **dict.fromkeys(radii, radius)}))


@pytest.mark.parametrize("larger", [-0.03, 0.03])
def test_another_radius_is_no_other_side(car, larger):
    """Also if the car turns to one side only."""
    log = turning(lambda t, steer, rate: (np.abs(steer) + 0.02, np.abs(rate) + 0.1))
    assert exchanged(read_log(with_wheels(log, 0.0, larger)), car) == ()


def test_a_log_with_axes_to_the_right_has_the_other_sides(car):
    table = with_wheels(turning(lambda t, steer, rate: (steer, rate)), 0.0)
    mirrored = table.assign(**{name: -table[name] for name in ("steer", "yaw_rate", "ay")})
    assert exchanged(read_log(mirrored), car) == ("front", "rear")


def test_steering_that_ends_at_one_on_both_sides_is_no_angle_until_it_is_stated(car):
    """As simulators log it, whose drivers turn to the lock."""
    lock = 0.02
    driven = turning(lambda t, steer, rate: (np.clip(steer, -lock, lock) / lock / road.CAR["ratio"], rate))
    t = driven.channels["steer"][0]
    table = pd.DataFrame({name: values for name, (_, values) in driven.channels.items()} | {"t": t})
    in_rad = replace(car, values={**car.values, "ratio": 1.0 / lock})
    for rows in (table, table.assign(**{name: -table[name] for name in ("steer", "yaw_rate", "ay")})):
        with pytest.raises(DataError, match=r"steer ends at exactly -1 and 1, .* state map = \[\[-1, -LOCK\]"):
            checked(read_log(rows), in_rad)
        checked(read_log(rows), replace(car, steering_map=np.array([[-1.0, -lock], [1.0, lock]])))
        checked(read_log(rows.rename(columns={"steer": "steer [rad]"})), in_rad)
        for steer in (np.clip(rows["steer"], -0.98, 1.0), 0.99 * rows["steer"], rows["steer"] + 0.01):
            checked(read_log(rows.assign(steer=steer)), in_rad)


def test_a_wrong_sign_is_named_also_where_a_delay_would_explain_it(car):
    def mirrored(t, steer, rate):
        wave = np.sin(2 * np.pi * 1.5 * t)
        return -0.03 * wave, 0.1 * wave

    with pytest.raises(DataError, match="opposite signs"):
        checked(turning(mirrored), car)


@pytest.mark.parametrize("rate", [10.0, 100.0, 400.0])
def test_a_short_clock_in_seconds_is_one_and_one_in_minutes_is_named(rate):
    short, minute = np.arange(0.0, 4.5, 1 / rate), np.arange(0.0, 60.0, 1 / rate)
    assert clock_problem(short, "t") == ""
    assert clock_problem(minute, "t") == ""
    assert "in min" in clock_problem(minute / 60.0, "t")


@pytest.mark.parametrize("name", ENTRIES)
def test_a_value_of_the_car_has_its_unit_and_a_ratio_none(name):
    unit = "" if ENTRIES[name].unit == "1" else f" {ENTRIES[name].unit}"
    assert f"2.5 instead of 1{unit}, 3.0 standard" in _deviation(CarFinding(name, 2.5, 1.0, 3.0, 0.99))
