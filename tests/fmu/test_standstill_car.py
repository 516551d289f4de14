"""A car on a wheel with velocities as inputs: it holds on a slope, brakes to rest, starts, stands and slides."""

from __future__ import annotations

import numpy as np
import pytest

from .quarter_car import QuarterCar
from .test_standstill import LOAD, OK, wheel_radius

#: Steps, s, and whether the host uses the FMU's derivatives.
STEPS = ((1e-4, False), (1e-3, False), (2e-3, False), (5e-3, True), (1e-2, True), (2e-2, True))
COARSE = (STEPS[2], STEPS[-1])
CARS = {"mf61": (LOAD, 1.0), "first": (1100.0, 0.16), "rolling": (LOAD, 1.0)}
CARS |= {"fiala": (4000.0, 1.0), "brush": (1000.0, 0.2)}

#: One tire with every step, the others with the coarsest step of either coupling.
DRIVES = [("mf61", *step) for step in STEPS] + [(name, *step) for name in ("first", "rolling") for step in COARSE]


@pytest.fixture
def car(wheels, tires):
    def build(name, implicit, **more):
        load, inertia = CARS[name]
        host = wheels(name)
        host.set(Fz=load)
        radius = wheel_radius(host, tires[name])
        host.call("Reset")
        return QuarterCar(host, load, inertia, radius, implicit, **more)

    return build


def reversals(velocity, smallest):
    """Return how often a velocity changes sign while it is above a size."""
    return np.count_nonzero(np.diff(np.sign(velocity[np.abs(velocity) > smallest])))


@pytest.mark.parametrize(("name", "size", "implicit"), DRIVES)
def test_a_braked_wheel_holds_the_car_on_a_slope(car, name, size, implicit):
    held = car(name, implicit, slope=0.1).start()
    held.run(1.5, size, brake=1e4)
    _, V_x, _, _, Fx, _ = held.run(0.3, size, brake=1e4)
    assert abs(np.mean(V_x)) < 1e-7  # creep, m/s
    assert np.ptp(Fx) < 1e-3 * held.load
    assert Fx[-1] == pytest.approx(0.1 * held.load, rel=1e-3)


@pytest.mark.parametrize("size", [1e-3, 5e-3, 2e-2])
@pytest.mark.parametrize("name", CARS)
def test_it_holds_with_forces_of_the_last_step(wheels, name, size):
    """The weakest coupling: locked wheel, forces held over the step, inputs of its begin."""
    load, _ = CARS[name]
    host = wheels(name)
    host.initialize()
    host.set(V_x=0.0, V_y=0.0, omega=0.0, Fz=load)
    host.call("ExitInitializationMode")
    V_x, last = 0.0, []
    for k in range(round(3.0 / size)):
        host.set(V_x=V_x)
        V_x += size * (host.get("Fx")[0] / load - 0.1) * 9.81
        assert host.step(k * size, size) == OK
        last.append(V_x)
    assert np.abs(last[-10:]).max() < 1e-6


@pytest.mark.parametrize(("name", "size", "implicit"), DRIVES)
def test_it_brakes_to_rest_without_ringing(car, name, size, implicit):
    """The wheel locks, the car slides, stops, springs back, and comes to rest within three swings."""
    braked = car(name, implicit).start(V_x=2.5)
    _, V_x, _, omega, Fx, _ = braked.run(1.5, size, brake=1e4)
    stop = np.argmax(V_x <= 0.0)
    assert stop > 0
    assert omega[stop] == pytest.approx(0.0, abs=1e-9)
    assert Fx[:stop].min() < -0.8 * braked.load
    assert reversals(V_x, 1e-3) <= 3
    assert np.abs(V_x[-20:]).max() < 1e-4
    assert np.ptp(Fx[-20:]) < 1e-3 * braked.load


@pytest.mark.parametrize(("name", "size", "implicit"), DRIVES)
def test_launch_and_reverse(car, name, size, implicit):
    """Torque accelerates the car and the wheel as the masses require; the reversed torque turns it around."""
    driven = car(name, implicit).start()
    torque = 0.15 * driven.load * driven.radius
    expected = torque / driven.radius / (driven.load / 9.81 + driven.inertia / driven.radius**2)
    resisted = 0.02 * 9.81
    driven.run(0.2, size)
    _, forward, _, omega, _, _ = driven.run(1.2, size, drive=torque)
    assert forward[-1] == pytest.approx(1.2 * expected, abs=1.2 * resisted + 0.02 * expected + size * expected)
    assert omega[-1] * driven.radius == pytest.approx(forward[-1], rel=0.05, abs=0.02)
    _, back, _, omega, Fx, _ = driven.run(3.0, size, drive=-torque)
    assert back[-1] == pytest.approx(forward[-1] - 3.0 * expected, abs=4.2 * resisted + 0.05 * expected)
    assert reversals(back, 1e-3) == 1
    assert np.abs(np.diff(Fx[2 * len(Fx) // 3 :])).max() < 1e-3 * driven.load


@pytest.mark.parametrize(("size", "implicit"), COARSE)
def test_a_pushed_car_stands_and_slides_beyond_friction(car, size, implicit):
    pushed = car("mf61", implicit).start()
    pushed.run(1.5, size, brake=1e4, side=0.3 * LOAD)
    _, _, V_y, _, _, Fy = pushed.run(0.2, size, brake=1e4, side=0.3 * LOAD)
    assert np.abs(V_y).max() < 1e-5
    assert Fy[-1] == pytest.approx(-0.3 * LOAD, rel=1e-3)
    _, _, V_y, _, _, Fy = pushed.run(0.4, size, brake=1e4, side=1.5 * LOAD)
    assert V_y[-1] > 1.0
    assert np.abs(Fy[-5:]).max() <= 1.2 * LOAD
