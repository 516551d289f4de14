"""FMUs with hub inputs in which the wheel spins: torques, a brake that locks, and a car on one wheel."""

from __future__ import annotations

import numpy as np
import pytest
from fmpy.validation import validate_fmu

from .hub_car import GRAVITY, HubCar

OK, DISCARD, ERROR = 0, 2, 3
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


def test_it_is_valid(fmus, fmi):
    assert validate_fmu(str(fmus["first", fmi, "hub-torque"])) == []


def test_in_the_air_the_spin_is_the_integral_of_the_torques(host, radius):
    host.initialize()
    assert host.set(r_z=2.0 * radius, omega=10.0, WHEEL_INERTIA=INERTIA, T_drive=4.0) == OK
    assert host.call("ExitInitializationMode") == OK
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


def test_landing_bounces_without_loss_but_for_the_damper(car, host, radius):
    height = 1.1 * radius
    for damping, shares in ((0.0, (0.99, 1.01)), (60.0, (0.1, 0.95))):
        assert host.call("Reset") == OK
        rows = car(height=height, VERTICAL_DAMPING=damping).run(0.6, 5e-4, "omega", "Fz")
        z, force, load = rows[2], rows[6:9], rows[10]
        air = z > radius
        assert np.all(load[air] == 0.0)
        assert damping > 0.0 or np.all(load[~air] > 0.0)
        assert np.all(force[:, 1:][:, air[:-1]] == 0.0)  # the force of a row belongs to the position before it
        landed = int(np.argmin(air))
        rebound = z[landed:].max() - radius
        assert shares[0] < rebound / (height - radius) < shares[1]


def test_the_load_of_a_car_at_rest_is_its_weight(car):
    rows = car(height=None).run(2.0, 0.005, "Fz", T_brake=100.0)
    assert rows[9, -1] == pytest.approx(MASS * GRAVITY, rel=1e-6)


def test_what_the_host_may_set(host):
    assert host.set(T_brake=-1.0) == DISCARD
    host.start()
    assert host.set(omega=1.0) == ERROR


def test_a_refused_step_changes_nothing(host):
    host.start()
    before = host.everything()
    assert host.set(road_nz=0.0, T_drive=50.0) == OK
    assert host.step(0.0, 0.01) == DISCARD
    assert host.set(road_nz=1.0, T_drive=0.0) == OK
    np.testing.assert_array_equal(host.everything(), before)
