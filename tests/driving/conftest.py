"""One made drive with a known truth, and the car and the tire of its files."""

from __future__ import annotations

import sys
from pathlib import Path

import pytest

sys.path.insert(0, str(Path(__file__).parent))  # the independent program is not a package
import road

import tirefmu
from tirefmu.applications.driving.inputs.car import Car

#: Friction and cornering stiffness of the drive, relative to the tire of the file.
TRUE = {"LMUX": 0.8, "LMUY": 0.8, "LKX": 1.0, "LKY": 0.9}


@pytest.fixture(scope="session")
def log():
    truth = road.Truth({"front": TRUE, "rear": {**TRUE, "LMUY": 0.84, "LKY": 1.0}}, {"yaw_inertia": 1600.0}, 0.015)
    logs, _ = road.made_drives([truth], ["laps"], [True], seed=5, seconds=16.0)
    return logs[0]


@pytest.fixture(scope="session")
def car():
    return Car.from_content(road.car_content(), "car.toml")


@pytest.fixture(scope="session")
def tire():
    return road.file_tire()


@pytest.fixture(scope="session")
def answer(log, car, tire):
    return tirefmu.drive(log, vehicle=car, tire=tire)
