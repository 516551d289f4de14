"""Laws of the two-track vehicle: statics, mirror symmetry, agreement with the independent program."""

from __future__ import annotations

import numpy as np
import pytest
import road

from tirefmu.applications.driving.interval import _apart
from tirefmu.tires.code.modules import two_track

BODY = (1250.0, 1700.0, 1.2, 1.3, 1.5, 1.48, 0.52, 0.56, 0.0, 0.0, 0.0)
DOWNFORCE = {"downforce_front": 2.0, "downforce_rear": 3.0}


def wheels(vx=15.0, vy=0.0, r=0.0, ax=0.0, vy_dot=0.0, r_dot=0.0, steer=0.0, lag=(0.0, 0.0), heave=0.0, body=BODY):
    return np.array(two_track.wheels(vx, vy, r, ax, vy_dot, r_dot, *lag, heave, steer, 0.0, *body)).reshape(3, 4)


def test_loads_are_the_weight_and_straight_running_has_no_slip():
    alpha, speed, load = wheels()
    assert load.sum() == pytest.approx(1250.0 * 9.80665)
    assert not alpha.any()
    np.testing.assert_allclose(speed, 15.0)
    assert wheels(ax=3.0)[2].sum() == pytest.approx(load.sum())  # a transfer creates no load


def test_a_body_that_is_accelerated_up_presses_all_wheels_on_the_road():
    turn = {"r": 0.3, "ax": 2.0}
    np.testing.assert_allclose(wheels(**turn, heave=1.0)[2] - wheels(**turn)[2], wheels()[2] / 9.80665)


def test_downforce_presses_both_wheels_of_an_axle_on_the_road():
    pressed = wheels(vx=20.0, r=0.3, body=(*BODY[:-2], *DOWNFORCE.values()))[2]
    np.testing.assert_allclose(pressed - wheels(vx=20.0, r=0.3)[2], [400.0, 400.0, 600.0, 600.0])


def test_a_mirrored_motion_has_mirrored_wheels():
    one = wheels(vy=-0.3, r=0.4, vy_dot=0.2, r_dot=0.5, steer=0.05)
    other = wheels(vy=0.3, r=-0.4, vy_dot=-0.2, r_dot=-0.5, steer=-0.05)
    swapped = one[:, [1, 0, 3, 2]]
    np.testing.assert_allclose(other, swapped * np.array([[-1.0], [1.0], [1.0]]))


def test_balance_vanishes_for_the_rates_that_the_forces_cause():
    forces = np.array([200.0, 150.0, -300.0, -250.0, 900.0, 1400.0, 800.0, 1300.0])
    motion, steer = (14.0, -0.2, 0.35), 0.04
    turned = steer, 0.002
    rates = two_track.accelerations(*motion, *turned, *BODY, *forces)
    np.testing.assert_allclose(two_track.balance(*motion, *rates, *turned, *BODY, *forces)[4:], 0.0, atol=1e-9)


def test_loads_follow_the_accelerations_behind_which_they_lag():
    motion = {"vx": 15.0, "r": 0.3, "ax": 2.0}
    np.testing.assert_allclose(wheels(**motion, lag=(-2.0, -4.5))[2], wheels()[2])  # no transfer has begun


def test_compliance_turns_the_wheels_towards_understeer():
    motion = 15.0, 0.0, 0.3, 0.0, 0.0, 0.0
    front, rear, inclination = two_track.turned(*motion, 0.0, 0.0, 0.05, 1e-3, 2e-3, 3e-3)
    np.testing.assert_allclose([front, rear, inclination], [0.05 - 4.5e-3, 9e-3, 13.5e-3])


def test_the_roll_that_an_accelerometer_feels_lags_as_the_load_does():
    motion, sensor = (15.0, 0.0, 0.3, 0.0, 0.0, 0.0), (0.0, 0.0, 0.01, 0.0)
    upright = two_track.sensor(*motion, 0.0, -4.5, *sensor)[1]
    assert upright == pytest.approx(4.5)
    assert two_track.sensor(*motion, 0.0, 0.0, *sensor)[1] == pytest.approx(4.5 + 9.80665 * 0.045)


def test_a_wheel_at_its_limit_transmits_less_than_the_other_one():
    stiffness = 30000.0, 90000.0
    # Both wheels are linear, and their slips say that the forces differ by 300 N: brakes are more equal than that.
    assert abs(_apart(2000.0, 0.0, [0.0283, 0.0128], [850.0, 1150.0], stiffness)) < 0.5 * 150.0
    # The unloaded wheel spins at its limit: the other one has the rest of the pull, whatever its own slip says.
    apart = _apart(4800.0, 0.0, [0.11, 0.03], [1900.0, 2600.0], stiffness)
    assert -500.0 < apart < -0.6 * 500.0
    assert _apart(4800.0, 0.0, [0.03, 0.11], [2600.0, 1900.0], stiffness[::-1]) == pytest.approx(-apart)
    assert _apart(0.0, 0.0, [0.001, -0.001], [30.0, -90.0], stiffness) == pytest.approx(0.0, abs=1e-6)
    # A wheel that is released from near its limit spins up: the road turns it, and no torque is unequal.
    assert _apart(0.0, -80.0, [0.001, -0.001], [30.0, -90.0], stiffness) == pytest.approx(-80.0, abs=1.0)


@pytest.mark.parametrize("air", [{}, DOWNFORCE])
def test_slips_and_loads_are_those_of_the_independent_program(air):
    same = {axle: dict.fromkeys(("LMUX", "LMUY", "LKX", "LKY"), 1.0) for axle in ("front", "rear")}
    seen = {}

    def tire(kappa, alpha, Fz, V, factors):
        seen.update(alpha=alpha[:, 0], Fz=Fz[:, 0])
        return road.tire_forces(kappa, alpha, Fz, V, factors)

    program = road.Road([road.Truth(same, air)], tire)
    state = np.array([14.0, -0.2, 0.35, *[14.0 / 0.3] * 4])[:, None]
    program.rolled = np.zeros((2, 1))
    for _ in range(12):  # until the loads follow from the accelerations that they cause
        rates, program.rolled, _ = program.rates(state, np.array([0.04]), np.zeros((4, 1)))
    body = (*BODY[:-2], *air.values()) if air else BODY
    alpha, _, load = wheels(14.0, -0.2, 0.35, *rates[:3, 0], 0.04, body=body)
    np.testing.assert_allclose(alpha, seen["alpha"], atol=1e-12)
    np.testing.assert_allclose(load, seen["Fz"], rtol=1e-4)
