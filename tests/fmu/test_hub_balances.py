"""Momentum and energy of a mass on one spinning wheel: free rolling, sliding until it rolls, and bouncing."""

from __future__ import annotations

import numpy as np
import pytest

from .hub_car import GRAVITY, HubCar

MASS, INERTIA, STEP = 30.0, 0.4, 5e-4
LIGHT = 4.0  # kg, on a tire that has the assumed damping only


@pytest.fixture
def car(hosts, tires):
    host = hosts("first", 3, "hub-torque")
    radius = tires["first"].values["UNLOADED_RADIUS"]
    rest = radius - MASS * GRAVITY / host.get("VERTICAL_STIFFNESS")[0]

    def start(speed, spin, height=rest, **values):
        given = {"omega": spin, "WHEEL_INERTIA": INERTIA, "VERTICAL_DAMPING": 300.0, **values}
        return HubCar(host, MASS).start(height, (speed, 0.0, 0.0), **given)

    return start


@pytest.mark.parametrize(("speed", "slip"), [(20.0, -0.5), (20.0, 0.5), (-10.0, -0.5), (80.0, -0.1)])
def test_a_sliding_wheel_keeps_its_angular_momentum_until_it_rolls(car, tires, speed, slip):
    """About the line of contact nothing turns wheel and mass: J omega + R_l m v is constant.

    The model has no rolling resistance. At the end the wheel rolls with the speed, and has lost the energy, that the
    momentum determines. On the way the carcass stores a part of the energy and returns it.
    """
    radius = tires["first"].values["UNLOADED_RADIUS"]
    sliding = car(speed, (1.0 + slip) * speed / radius)
    v, omega, R_l, load = sliding.run(2.0, STEP, "omega", "R_l", "Fz")[[3, 9, 10, 11]]
    # The force at the end of a step of the wheel moves the mass in the next one.
    momentum = INERTIA * omega[:-1] + MASS * R_l[:-1] * v[1:]
    assert np.ptp(momentum) < 1e-6 * np.abs(momentum).max()
    energy = 0.5 * INERTIA * omega**2 + 0.5 * MASS * v**2
    assert np.all(energy <= energy[0])
    rolls = momentum[0] / (INERTIA / radius + MASS * R_l[-1])
    assert v[-1] == pytest.approx(rolls, rel=2e-3)
    assert omega[-1] * radius == pytest.approx(v[-1], rel=5e-3)
    before = 0.5 * MASS * speed**2 + 0.5 * INERTIA * ((1.0 + slip) * speed / radius) ** 2
    lost = before - 0.5 * (MASS + INERTIA / radius**2) * rolls**2
    assert before - energy[-1] == pytest.approx(lost, rel=0.05)
    assert load == pytest.approx(MASS * GRAVITY, rel=1e-6)


def test_a_freely_rolling_wheel_keeps_its_energy(car, tires):
    radius = tires["first"].values["UNLOADED_RADIUS"]
    rolling = car(20.0, 20.0 / radius)
    rolling.run(1.0, STEP)  # until it has no slip force
    v, omega = rolling.run(2.0, STEP, "omega")[[3, 9]]
    energy = 0.5 * INERTIA * omega**2 + 0.5 * MASS * v**2
    assert np.ptp(energy) < 1e-6 * energy[0]
    assert np.ptp(rolling.run(0.2, STEP, "kappa")[9]) < 1e-6


def test_a_bouncing_wheel_loses_the_work_of_its_damper(car, tires):
    """From the height at which it is let go to that of the first rebound."""
    radius, damping = tires["first"].values["UNLOADED_RADIUS"], 60.0
    bouncing = car(0.0, 0.0, height=1.15 * radius, VERTICAL_DAMPING=damping)
    z, rate, load = bouncing.run(0.6, 1e-4, "Fz")[[2, 5, 9]]
    landed = int(np.argmax(z < radius))
    top = landed + int(np.argmax(z[landed:]))
    touching = load > 0.0
    work = damping * np.sum(rate[: top + 1] ** 2 * touching[: top + 1]) * 1e-4
    lost = MASS * GRAVITY * (z[0] - z[top]) + 0.5 * MASS * (rate[0] ** 2 - rate[top] ** 2)
    assert z[top] > radius
    assert lost > 0.05 * MASS * GRAVITY * (z[0] - radius)
    assert lost == pytest.approx(work, rel=0.02)
    # Its momentum changes by the impulse of load and weight.
    impulse = 1e-4 * (load[landed : top + 1].sum() - MASS * GRAVITY * (top + 1 - landed))
    assert MASS * (rate[top] - rate[landed]) == pytest.approx(impulse, rel=1e-2, abs=0.01)


def test_a_tire_whose_file_has_no_damping_comes_to_rest(tires, hosts):
    """The model has a coefficient of damping, which is 0 if it is not stated; the FMU assumes 50 N s/m."""
    host = hosts("fiala", 3, "hub")
    radius = tires["fiala"].values["UNLOADED_RADIUS"]
    z = HubCar(host, LIGHT).start(1.01 * radius).run(2.0, 1e-4)[2]
    assert host.get("VERTICAL_DAMPING")[0] == 50.0
    assert np.ptp(z[-1000:]) < 1e-3 * np.ptp(z[:10000])
