"""FMUs with hub inputs in which the wheel spins: torques, a brake that locks, and a car on one wheel."""

from __future__ import annotations

import numpy as np
import pytest

from .conftest import DISCARD, ERROR, OK
from .hub_car import GRAVITY, HubCar

MASS, INERTIA, DRIVE = 30.0, 0.1, 15.0


@pytest.fixture
def radius(tires):
    return tires["first"].values["UNLOADED_RADIUS"]


@pytest.fixture
def host(hosts):
    return hosts("first", 3, "hub-torque")


@pytest.fixture
def car(host, radius):
    """Return a function that starts a car on a level road, at rest in the air or on its wheel."""

    def start(speed=0.0, height=None, slope=0.0, **values):
        rest = radius - MASS * GRAVITY / host.get("VERTICAL_STIFFNESS")[0]
        given = {"omega": speed / radius, "VERTICAL_DAMPING": 500.0, "WHEEL_INERTIA": INERTIA, **values}
        return HubCar(host, MASS, slope).start(height or rest, (speed, 0.0, 0.0), **given)

    return start


def test_in_the_air_the_spin_is_the_integral_of_the_torques(host, radius):
    host.start(r_z=2.0 * radius, omega=10.0, WHEEL_INERTIA=INERTIA, T_drive=4.0)
    assert host.step(0.0, 0.25) == OK
    assert host.get("omega", "M_y", "Fz") == pytest.approx([10.0 + 4.0 * 0.25 / INERTIA, 0.0, 0.0], rel=1e-12)
    assert host.set(T_drive=0.0, T_brake=5.0) == OK
    assert host.step(0.25, 0.1) == OK
    assert host.get("omega", "brake_torque") == pytest.approx([10.0 + 0.5 / INERTIA, -5.0], rel=1e-12)
    assert host.set(T_drive=1.0) == OK
    assert host.step(0.35, 0.5) == OK
    assert host.step(0.85, 0.01) == OK
    assert host.get("omega", "brake_torque") == pytest.approx([0.0, -1.0], abs=1e-12)


def test_a_braked_car_holds_on_a_slope_of_20_percent(car):
    """For 100 s in steps of 10 ms; once it has settled, it moves less than 0.1 mm/s and its wheel not at all."""
    rows = car(slope=0.2, T_brake=500.0).run(100.0, 0.01, "omega", "brake_torque", "Fx", "R_l")
    x, v, omega, brake, force, loaded_radius = rows[0], rows[3], *rows[9:]
    settled = slice(300, None)
    assert np.abs(v[settled]).max() < 1e-4
    assert np.ptp(x[settled]) < 1e-5
    assert np.abs(x).max() < 0.02
    assert np.all(omega == 0.0)
    assert force[-1] == pytest.approx(MASS * GRAVITY * np.sin(np.arctan(0.2)), rel=1e-3)
    assert brake[-1] == pytest.approx(force[-1] * loaded_radius[-1], rel=0.02)  # but for the rolling resistance


def test_lock_up_from_speed_without_chatter(car, radius):
    """In steps of 5 ms: the spin falls to 0 and stays there, the car stops and stands."""
    rolling = car(speed=20.0)
    rows = rolling.run(3.0, 0.005, "omega", "Fx", T_brake=300.0)
    v, omega, force = rows[3], *rows[9:]
    locked = int(np.argmax(omega == 0.0))
    assert 0 < locked < 100
    assert np.all(np.diff(omega[: locked + 1]) < 0.0)
    assert np.all(omega[locked:] == 0.0)
    energy = 0.5 * MASS * v**2 + 0.5 * INERTIA * omega**2
    moving = v > 3.0  # the friction of a wheel close to standstill is another one
    assert np.all(np.diff(energy[moving]) < 0.0)
    sliding = slice(locked + 40, np.flatnonzero(moving)[-1])
    assert np.all(force[sliding] < 0.0)
    assert np.abs(np.diff(force[sliding])).max() < 0.02 * np.abs(force[sliding]).max()
    assert abs(rows[3, -1]) < 1e-3


@pytest.mark.parametrize("sense", [1.0, -1.0], ids=["forward", "reverse"])
def test_launch_without_chatter(car, radius, sense):
    """In steps of 5 ms: after the first 0.2 s the force is steady and accelerates car and wheel."""
    rows = car().run(1.5, 0.005, "omega", "Fx", "R_l", T_drive=sense * DRIVE)
    v, omega, force = rows[3], *rows[9:11]
    steady = slice(40, None)
    mean = force[steady].mean()
    assert np.ptp(force[steady]) < 0.1 * abs(mean)
    spun_up = INERTIA * (omega[-1] - omega[40]) / (1.5 - 0.005 * 41)
    # The car holds forces and the wheel holds velocities over a step: within 1.4 % at 5 ms.
    assert mean * rows[11, steady].mean() + spun_up == pytest.approx(sense * DRIVE, rel=0.02)
    assert v[-1] - v[40] == pytest.approx((1.5 - 0.005 * 41) * mean / MASS, rel=2e-3)
    assert omega[-1] * radius == pytest.approx(v[-1], rel=0.1)


def test_what_the_host_may_set(host):
    assert host.set(T_brake=-1.0) == DISCARD
    host.start()
    assert host.set(omega=1.0) == ERROR
