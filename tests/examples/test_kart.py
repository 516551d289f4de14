"""A kart on four tires with hub inputs: co-simulation, monolithic simulation, and the laws of its manoeuvres."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest


@pytest.fixture(scope="module")
def kart(example):
    return example("kart")


@pytest.fixture(scope="module")
def fmu(kart, compiler, tmp_path_factory):
    return kart.export(tmp_path_factory.mktemp("kart"))


@pytest.mark.slow
def test_the_error_is_of_first_order_in_the_step(kart, fmu):
    manoeuvre, times = kart.MANOEUVRES["brake-in-turn"], np.array([0.0, 1.0])
    exact = kart.monolithic(manoeuvre, times)
    coarse, fine = (kart.errors(kart.cosimulate(fmu, manoeuvre, step), exact) for step in (0.004, 0.002))
    assert fine < 0.6 * coarse
    assert fine < 2e-3


def test_the_lane_change_is_within_the_lanes(kart, fmu):
    """ISO 3888-1: widths of 1.1, 1.2 and 1.3 vehicle widths and 0.25 m."""
    rows = kart.cosimulate(fmu, kart.MANOEUVRES["lane-change"], 0.005)
    x, y = rows[:, 0], rows[:, 1]
    width = 1.3
    for begin, end, middle, factor in ((0.0, 15.0, 0.0, 1.1), (45.0, 70.0, 3.5, 1.2), (95.0, 110.0, 0.0, 1.3)):
        inside = (x >= begin) & (x <= end)
        assert inside.sum() > 50
        assert np.abs(y[inside] - middle).max() < 0.5 * (factor * width + 0.25 - width)


def test_a_parked_kart_stands(kart, fmu):
    manoeuvre = replace(kart.MANOEUVRES["park"], end=4.0)
    assert kart.parked(kart.cosimulate(fmu, manoeuvre, 0.005)) == 0
    free = replace(manoeuvre, end=1.0, brake=lambda t: np.zeros(4))
    assert kart.parked(kart.cosimulate(fmu, free, 0.005)) == 1


def test_the_launch_accelerates_by_the_torque(kart, fmu, example):
    """The sum of the torques on the wheels is that of the engine less the thrust on the slope at the loaded radius."""
    rows = kart.cosimulate(fmu, kart.MANOEUVRES["launch"], 0.005)
    gained = (rows[-1] - rows[100]) / (0.005 * (len(rows) - 101))
    body = example("kart_body")
    thrust = body.MASS * (gained[3] + 9.81 * np.sin(np.arctan(0.03)))
    assert kart.tire().values["UNLOADED_RADIUS"] == kart.RADIUS
    radius = kart.RADIUS - body.MASS * 9.81 / 4.0 / kart.PARAMETERS["VERTICAL_STIFFNESS"]
    spun_up = kart.PARAMETERS["WHEEL_INERTIA"] * gained[6:].sum()
    assert 2.0 * 25.0 - thrust * radius == pytest.approx(spun_up, abs=0.02 * 50.0)
