"""Tables with the rows of several cars are refused with the column that shows them, those of one car are read."""

from __future__ import annotations

import numpy as np
import pandas as pd
import pytest

from tirefmu.applications.driving.inputs.log import read_log
from tirefmu.boundary.errors import DataError
from tirefmu.commands.cli import main

T = np.arange(0.0, 20.0, 0.05)
RANDOM = np.random.default_rng(5)


def car(number: int, late: float = 0.0) -> pd.DataFrame:
    steer = 0.4 * (1.0 + 0.3 * number) * np.sin(T + number) + RANDOM.normal(0.0, 0.004, len(T))
    return pd.DataFrame(
        {"t": T + late, "steer": steer, "speed": 15.0 + 0.3 * number + 0.1 * np.sin(T), "yaw_rate": 0.4 * steer,
         "ay": 6.0 * steer}
    )  # fmt: skip


def by_time(cars: list[pd.DataFrame]) -> pd.DataFrame:
    return pd.concat(cars).sort_values("t", kind="stable", ignore_index=True)


NAMES = {"numbers": (7, 13, 22), "floats": (1.0, 2.0, 3.0), "names": ("GR86-7", "GR86-13", "ego"), "flags": (0, 1)}
ARRANGED = {
    "one after another": lambda cars: pd.concat(cars, ignore_index=True),
    "at equal times": by_time,
    "with a clock each": lambda cars: by_time([rows.assign(t=rows["t"] + 0.013 * i) for i, rows in enumerate(cars)]),
    "with lost packets": lambda cars: by_time([rows[RANDOM.random(len(rows)) > 0.1] for rows in cars]),
    "one for a while": lambda cars: by_time([cars[0], *(rows[rows["t"].between(5.0, 9.0)] for rows in cars[1:])]),
}  # fmt: skip


@pytest.mark.parametrize("layout", ["rows", "row for each value"])
@pytest.mark.parametrize("arranged", ARRANGED)
@pytest.mark.parametrize("names", NAMES)
def test_rows_of_several_cars_are_refused_with_their_column(tmp_path, names, arranged, layout):
    cars = [car(i).assign(vehicle=name) for i, name in enumerate(NAMES[names])]
    table = ARRANGED[arranged](cars)
    if layout != "rows":
        table = table.melt(["t", "vehicle"], var_name="signal_name").sort_values("t", kind="stable")
    table.to_csv(tmp_path / "log.csv", index=False)
    with pytest.raises(DataError, match=r"column vehicle: .* (has times of its own|in rows of one signal): save "):
        read_log(tmp_path / "log.csv")


ONE = car(1)
OF_ONE = {
    "lap": T // 7.0, "gear": (T // 3.0) % 4, "counter": np.arange(len(T)) % 16, "parity": np.arange(len(T)) % 2,
    "braking": (ONE["ay"].diff() > 0.0).astype(int), "ay in whole m/s^2": ONE["ay"].round(), "sign": np.sign(ONE["ay"]),
    "source": RANDOM.integers(0, 2, len(T)), "brake once": (np.abs(T - 9.0) < 0.5).astype(int), "second": T // 1.0,
    "state": np.where(T < 10.0, "warm up", "lap"), "message": np.where(np.arange(len(T)) % 2, "imu", "gps"),
}  # fmt: skip


@pytest.mark.parametrize("column", OF_ONE)
@pytest.mark.parametrize("noise", [0.0, 1.0])
def test_a_column_of_a_single_car_divides_nothing(column, noise):
    rows = ONE.assign(**{name: ONE[name] + RANDOM.normal(0.0, noise, len(T)) for name in ("ay", "speed")})
    np.testing.assert_array_equal(read_log(rows.assign(**{column: OF_ONE[column]})).values("ay"), rows["ay"])


def test_a_clock_that_begins_again_for_each_lap_is_named_by_it():
    with pytest.raises(DataError, match=r"column lap: each of '0, 1, 2' has times of its own"):
        read_log(ONE.assign(t=T % 7.0, lap=(T // 7.0).astype(int)))
    with pytest.raises(DataError, match="time decreases at sample 141"):
        read_log(ONE.assign(t=T % 7.0))


def test_inspect_states_them(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    by_time([car(i, 0.013 * i).assign(vehicle=i) for i in (1, 2)]).to_csv("log.csv", index=False)
    assert main(["inspect", "log.csv"]) == 0
    assert "# column vehicle: each of '1, 2' has times of its own: save the rows of one" in capsys.readouterr().out
