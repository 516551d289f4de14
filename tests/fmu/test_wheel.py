"""Wheel inputs: slips from velocities, standstill, reverse, the locked and the spinning wheel."""

from __future__ import annotations

import numpy as np
import pandas as pd
import pytest
from fmpy.validation import validate_fmu

from tirefmu.boundary.errors import FmuError
from tirefmu.fmu import check

OK, DISCARD, ERROR = 0, 2, 3
NAMES = ("first", "mf52", "mf61", "rolling")


@pytest.fixture
def load(tires):
    return lambda name: tires[name].nominal("Fz")


def settled(host, time=0.0, size=30.0):
    """Step until the lag has decayed and return the forces."""
    assert host.step(time, size) == OK
    return host.get(*host.outputs)


@pytest.mark.parametrize("name", NAMES)
def test_it_is_valid(fmus, name, fmi):
    assert validate_fmu(str(fmus[name, fmi, "wheel"])) == []


@pytest.mark.parametrize("name", NAMES)
def test_at_speed_it_is_the_tire_at_the_reported_slips(wheels, tires, name):
    host = wheels(name).start()
    rng, time = np.random.default_rng(2), 0.0
    for _ in range(25):
        V_x, V_y = rng.uniform(2.0, 60.0), rng.uniform(-2.0, 2.0)
        omega, gamma = V_x / 0.3 * rng.uniform(0.8, 1.2), rng.uniform(-0.1, 0.1)
        assert host.set(V_x=V_x, V_y=V_y, omega=omega, gamma=gamma) == OK
        found = settled(host, time)
        kappa, alpha = host.get("kappa", "alpha")
        assert alpha == pytest.approx(np.arctan(V_y / V_x), rel=1e-14)
        point = {"kappa": kappa, "alpha": alpha, "gamma": gamma, "V": V_x}
        reported = {key: value for key, value in point.items() if key in tires[name].inputs}
        row = tires[name].evaluate(pd.DataFrame([reported])).iloc[0]
        expected = row[host.outputs].to_numpy()
        np.testing.assert_allclose(found, expected, rtol=1e-9, atol=1e-8)
        radius = row["R_e"] if "R_e" in row else tires[name].values["UNLOADED_RADIUS"]
        assert kappa == pytest.approx((omega * radius - V_x) / V_x, rel=1e-5, abs=1e-5)
        time += 30.0


@pytest.mark.parametrize("name", NAMES)
def test_it_rolls_freely_at_the_start(wheels, name):
    host = wheels(name).start()
    assert host.get("kappa")[0] == pytest.approx(0.0, abs=1e-6)
    assert host.get("V_y")[0] == 0.0


@pytest.mark.parametrize("name", NAMES)
@pytest.mark.parametrize("V_x", [0.0, -0.0, 1e-300, -1e-300, 1e-9, 0.004, -0.3, 0.999, -30.0, 80.0])
def test_forces_are_finite_and_within_friction(wheels, tires, load, name, V_x):
    """In any motion of the wheel, friction is limited to that of the formula."""
    host = wheels(name).start()
    peak = 2.5 * load(name)  # the golden tires reach 1.0 to 2.2
    time = 0.0
    for V_y in (0.0, -3.0, 0.02, 8.0):
        for omega in (0.0, 1e-6, 40.0, -40.0, 300.0):
            host.set(V_x=V_x, V_y=V_y, omega=omega)
            for size in (1e-3, 0.1, 10.0):
                assert host.step(time, size) == OK
                time += size
                found = host.get(*host.outputs, *host.extras)
                assert np.all(np.isfinite(found))
                assert np.hypot(found[0], found[1]) < np.sqrt(2.0) * peak


@pytest.mark.parametrize("name", NAMES)
def test_forces_oppose_sliding_both_ways(wheels, name):
    host, time = wheels(name).start(), 0.0
    for V_x in (20.0, -20.0, 3.0, -3.0, 0.2, -0.2, 0.0):
        for V_y in (1.5, -1.5):
            host.set(V_x=V_x, V_y=V_y, omega=V_x / 0.3)
            found = settled(host, time)
            assert found[1] * V_y < 0.0, (V_x, V_y)
            time += 30.0
        for omega in (V_x / 0.3 + 60.0, V_x / 0.3 - 60.0):
            host.set(V_x=V_x, V_y=0.0, omega=omega)
            found = settled(host, time)
            assert found[0] * (omega - V_x / 0.3) > 0.0, (V_x, omega)
            time += 30.0


def test_a_locked_wheel_has_slip_of_one(wheels):
    host = wheels("mf61").start()
    host.set(V_x=20.0, omega=0.0)
    assert host.get("kappa")[0] == -1.0
    host.set(V_x=-20.0)
    assert host.get("kappa")[0] == 1.0


@pytest.mark.parametrize("name", NAMES)
def test_forces_are_continuous_through_standstill(wheels, name):
    host = wheels(name).start()
    speeds = np.linspace(-1.5, 1.5, 1201)  # LOW_SPEED and the lowest speed are in this range
    found = []
    for V_x in speeds:
        host.set(V_x=V_x, V_y=0.05, omega=V_x / 0.3 + 0.2)
        found.append(host.get("Fx", "Fy"))
    jumps = np.abs(np.diff(np.array(found), axis=0)).max(axis=0)
    assert np.all(jumps < 0.15 * np.ptp(np.array(found), axis=0) + 0.02 * np.abs(found).max())


def test_a_standing_tire_is_a_spring_with_a_damper(wheels, tires):
    """A mass on a wheel at standstill, under a lateral force: it oscillates and comes to rest at another position."""
    host = wheels("rolling").start()
    load = tires["rolling"].nominal("Fz")
    host.set(V_x=0.0, omega=0.0, V_y=0.0)
    mass, push, velocity, position, size = load / 9.81, 0.3 * load, 0.0, 0.0, 1e-3
    track = []
    for k in range(6000):
        host.set(V_y=velocity)
        force = host.get("Fy")[0]
        velocity += size * (force + push) / mass
        position += size * velocity
        track.append((position, velocity, force))
        assert host.step(k * size, size) == OK
    position, velocity, force = np.array(track).T
    assert abs(velocity[-1]) < 1e-3 * np.abs(velocity).max()
    assert force[-1] == pytest.approx(-push, rel=1e-3)
    assert 0.001 < position[-1] < 0.1


def test_low_speed_damping_never_exceeds_friction(wheels, tires):
    host = wheels("rolling").start()
    table = pd.DataFrame({"kappa": [0.0], "alpha": [0.0]})
    row = tires["rolling"].evaluate(table, steady=True).iloc[0]
    for damping in (0.3, 100.0, 1e9):
        assert host.set(LOW_SPEED_DAMPING=damping) == OK
        host.set(V_x=0.0, V_y=4.0, omega=50.0)
        found = np.abs(host.get("Fx", "Fy"))
        limits = np.abs(row[["mu_x", "mu_y"]].to_numpy(dtype=float)) * tires["rolling"].nominal("Fz")
        assert np.all(found <= 1.05 * limits)
    assert host.set(LOW_SPEED_DAMPING=-1.0) == DISCARD
    assert host.set(LOW_SPEED=0.0) == DISCARD


def test_a_spinning_wheel_does_not_wind_up(wheels):
    host = wheels("rolling").start()
    host.set(V_x=0.0, omega=100.0)
    assert host.step(0.0, 100.0) == OK
    host.set(omega=0.0, Fz=4000.0)
    kappa = host.get("kappa_lagged")[0]
    assert 0.0 < kappa < 2.0
    host.set(omega=-3.0)
    assert host.step(100.0, 2.0) == OK
    assert host.get("Fx")[0] < 0.0


def test_the_step_size_does_not_matter(wheels):
    found = []
    for n in (1, 50):
        host, time = wheels("rolling").start(), 0.0
        rows = []
        for i in range(20):
            V_x = 3.0 * np.cos(0.4 * i) if i % 5 else 0.0
            host.set(V_x=V_x, V_y=0.3 * np.sin(i), omega=V_x / 0.3 + np.cos(2 * i))
            for _ in range(n):
                assert host.step(time, 0.05 / n) == OK
                time += 0.05 / n
            rows.append(host.get(*host.outputs))
        found.append(rows)
    np.testing.assert_allclose(found[1], found[0], rtol=1e-9, atol=1e-7)


def test_turn_rate_is_turn_slip(wheels, tires):
    host = wheels("mf61").start()
    host.set(V_x=10.0, psi_dot=0.7, omega=10.0 / 0.3)
    settled(host)
    kappa = host.get("kappa")[0]
    expected = tires["mf61"].forces(kappa=kappa, alpha=0.0, V=10.0, phit=0.07)
    assert host.get("Mz")[0] == pytest.approx(float(expected["Mz"]), rel=1e-9)


def test_check_needs_slips(fmus):
    with pytest.raises(FmuError, match="its inputs are the motion of the wheel"):
        check(fmus["mf61", 3, "wheel"], pd.DataFrame({"Fz": [4000.0], "alpha": [0.1], "Fy": [0.0]}))


def test_derivatives_are_differences(wheels):
    host = wheels("rolling", 3).start()
    host.set(V_x=12.0, V_y=0.4, omega=41.0)
    host.step(0.0, 0.02)
    for known, step in (("V_x", 1e-4), ("omega", 1e-4), ("Fz", 1e-1), ("kappa_lagged", None)):
        status, found = host.derivative(host.outputs, [known], [1.0])
        assert status == OK
        if step is None:
            assert found[0] != 0.0
            continue
        middle = host.get(known)[0]
        sides = []
        for side in (step, -step):
            host.set(**{known: middle + side})
            sides.append(host.get(*host.outputs))
        host.set(**{known: middle})
        np.testing.assert_allclose(found, (sides[0] - sides[1]) / (2 * step), rtol=1e-4, atol=1e-3)
