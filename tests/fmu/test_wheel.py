"""Wheel inputs: slips from velocities, standstill, reverse, the locked and the spinning wheel."""

from __future__ import annotations

import numpy as np
import pandas as pd
import pytest

from tirefmu.boundary.errors import FmuError
from tirefmu.fmu import check

from .conftest import DISCARD, OK

NAMES = ("first", "mf52", "mf61", "rolling")


def settled(host, time=0.0, size=30.0):
    """Step until the lag has decayed and return the forces."""
    assert host.step(time, size) == OK
    return host.get(*host.outputs)


@pytest.mark.parametrize("name", [*NAMES, "fiala", "brush"])
def test_at_speed_it_is_the_tire_at_the_reported_slips(wheels, tires, name):
    host = wheels(name).start()
    rng, time = np.random.default_rng(2), 0.0
    for _ in range(25):
        V_x, V_y = rng.uniform(4.0, 60.0), rng.uniform(-2.0, 2.0)  # above the limit of friction
        omega, gamma = V_x / 0.3 * rng.uniform(0.8, 1.2), rng.uniform(-0.1, 0.1)
        inclined = {"gamma": gamma} if "gamma" in host.inputs else {}
        assert host.set(V_x=V_x, V_y=V_y, omega=omega, **inclined) == OK
        forces = settled(host, time)
        kappa, alpha = host.get("kappa", "alpha")
        assert alpha == pytest.approx(np.arctan(V_y / V_x), rel=1e-14)
        point = {"kappa": kappa, "alpha": alpha, "gamma": gamma, "V": V_x}
        reported = {key: value for key, value in point.items() if key in tires[name].inputs}
        row = tires[name].evaluate(pd.DataFrame([reported])).iloc[0]
        expected = row[host.outputs].to_numpy()
        np.testing.assert_allclose(forces, expected, rtol=1e-9, atol=1e-8)
        radius = row["R_e"] if "R_e" in row else tires[name].values["UNLOADED_RADIUS"]
        assert kappa == pytest.approx((omega * radius - V_x) / V_x, rel=1e-5, abs=1e-5)
        time += 30.0


@pytest.mark.parametrize("name", NAMES)
def test_it_rolls_freely_at_the_start(wheels, name):
    host = wheels(name).start()
    assert host.get("kappa")[0] == pytest.approx(0.0, abs=1e-6)
    assert host.get("V_y")[0] == 0.0


@pytest.mark.parametrize("name", NAMES)
def test_forces_are_continuous_through_standstill(wheels, name):
    host = wheels(name).start()
    speeds = np.linspace(-1.5, 1.5, 1201)  # LOW_SPEED and the lowest speed are in this range
    forces = np.array([host.forces(V_x=V_x, V_y=0.05, omega=V_x / 0.3 + 0.2)[:2] for V_x in speeds])
    jumps = np.abs(np.diff(forces, axis=0)).max(axis=0)
    assert np.all(jumps < 0.15 * np.ptp(forces, axis=0) + 0.02 * np.abs(forces).max())


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
        forces = np.abs(host.get("Fx", "Fy"))
        limits = np.abs(row[["mu_x", "mu_y"]].to_numpy(dtype=float)) * tires["rolling"].nominal("Fz")
        assert np.all(forces <= 1.05 * limits)
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
    runs = []
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
        runs.append(rows)
    np.testing.assert_allclose(runs[1], runs[0], rtol=1e-9, atol=1e-7)


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
