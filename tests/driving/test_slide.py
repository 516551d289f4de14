"""A car that slides with a driver who steers against it: its motion is not stable, and its tires are found."""

from __future__ import annotations

import numpy as np
import pytest
import road

import tirefmu
from tirefmu.applications.driving.inputs.car import Car
from tirefmu.applications.driving.trust import left_out

ONES = {"LMUX": 1.0, "LMUY": 1.0, "LKX": 1.0, "LKY": 1.0}
GRIP = 0.6
TRUTH = road.Truth({"front": ONES, "rear": {**ONES, "LMUX": GRIP, "LMUY": GRIP}}, {})


class CounterSteered(road.Road):
    """All wheels drive, and the driver steers to where the car moves."""

    def __init__(self):
        super().__init__([TRUTH])
        self.steered = []

    def rates(self, state, wheel, torque):
        wheel = wheel + 1.4 * np.arctan2(state[1], state[0]) - 0.15 * state[2]
        self.steered.append(wheel * self.car["ratio"])
        return super().rates(state, wheel, np.broadcast_to(torque.mean(axis=0), torque.shape))


@pytest.fixture(scope="module")
def sliding(tire):
    t = road.STEP * np.arange(round(16.0 / road.STEP))
    turn = 4.0 * np.tanh(4.0 * np.sin(2.0 * np.pi * t / 7.0)) * np.where(t < 10.5, 0.3, 1.0)
    drive = CounterSteered()
    rows = drive.run(turn[:, None], np.full((len(t), 1), 14.0))
    assert np.degrees(np.abs(np.arctan2(rows["vy"], rows["vx"]))).max() > 15.0
    (log,) = road.logs(rows, np.array(drive.steered[::4]), [TRUTH], np.random.default_rng(1))
    content = road.car_content()
    content["wheels"]["driven"] = "all"
    return tirefmu.drive(log, vehicle=Car.from_content(content, "car"), tire=tire)


def test_the_friction_of_an_axle_that_slides_is_found(sliding):
    assert [(finding.axle, finding.effect) for finding in sliding.verdict.tires] == [("rear", "friction is lower")]
    assert sliding.factors["rear"]["LMUY"].low < GRIP < sliding.factors["rear"]["LMUY"].high


def test_right_tires_predict_a_motion_that_is_not_stable(sliding, monkeypatch):
    parts = left_out.parts_of(sliding.grid, sliding.estimate, sliding.unknowns, sliding.car)

    def errors():
        given, new = (float(np.sqrt(of_part.mean())) for of_part, _ in parts.errors(sliding.tires, fixed))
        return given, new

    fixed = [sliding.unknowns.factors, ()]
    given, new = errors()
    assert new < 0.1 * given
    monkeypatch.setattr(left_out, "MEMORY", np.inf)
    assert errors()[1] > 5.0 * new  # a small error of the start has grown
