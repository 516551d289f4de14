"""Four tires and a vehicle: laws of mechanics, and convergence of the co-simulation to the monolithic one."""

from __future__ import annotations

import numpy as np
import pytest
from fmpy.validation import validate_fmu

from tirefmu.fmu.packaging.binaries import host_platform


@pytest.fixture(scope="module")
def vehicle(example):
    return example("vehicle")


@pytest.fixture(scope="module")
def printed(vehicle, tmp_path_factory):
    """Return the printed equations."""
    return vehicle.load(vehicle.write_equations(tmp_path_factory.mktemp("printed")))


@pytest.fixture(scope="module")
def fmus(vehicle, compiler, tmp_path_factory):
    if host_platform() not in ("x86_64-linux", "x86_64-windows"):
        pytest.skip("pythonfmu has no binary for this machine")
    return vehicle.export(tmp_path_factory.mktemp("vehicle"))


def any_state(printed):
    draw = np.random.default_rng(4)
    state = np.array([15.0, *draw.uniform(-0.1, 0.1, 6), *(15.0 / printed.RADIUS * draw.uniform(0.9, 1.1, 4))])
    return state, (0.06, 40.0, 30.0), draw.uniform(-800.0, 800.0, 12)


def test_loads_carry_the_weight(vehicle, printed):
    state, controls, _ = any_state(printed)
    values = vehicle.equations.PARAMETERS
    loads = np.reshape(printed.slips(state, controls), (4, 4))[:, 3]
    assert loads.sum() == pytest.approx(values["m"] * values["g"], rel=1e-12)


def test_straight_rolling_has_no_slip(printed):
    state = [12.0, *[0.0] * 6, *[12.0 / printed.RADIUS] * 4]
    slips = np.reshape(printed.slips(state, (0.0, 0.0, 0.0)), (4, 4))
    assert slips[:, :3] == pytest.approx(0.0, abs=1e-15)


def test_momentum_changes_by_the_forces(vehicle, printed):
    """Linear and angular momentum of the body with straight wheels."""
    state, _, forces = any_state(printed)
    values, rates = vehicle.equations.PARAMETERS, np.array(printed.derivatives(state, (0.0, 0.0, 0.0), forces))
    Fx, Fy, Mz = np.reshape(forces, (4, 3)).T
    along, across = rates[0] - state[2] * state[1], rates[1] + state[2] * state[0]
    assert values["m"] * along == pytest.approx(Fx.sum())
    assert values["m"] * across == pytest.approx(Fy.sum())
    x = np.array([values["l_f"]] * 2 + [-values["l_r"]] * 2)
    y = np.array([values["w_f"], -values["w_f"], values["w_r"], -values["w_r"]]) / 2
    assert values["I_z"] * rates[2] == pytest.approx((x * Fy - y * Fx + Mz).sum())


def test_steady_load_transfer_is_that_of_the_moments(vehicle, printed):
    """In a steady turn the moment of the loads balances that of the side force at the height of the body."""
    values = vehicle.equations.PARAMETERS
    side = 2000.0
    roll = values["h"] * side / (values["c_f"] + values["c_r"])
    state = [15.0, 0.0, 0.0, roll, 0.0, 0.0, 0.0, *[60.0] * 4]
    loads = np.reshape(printed.slips(state, (0.0, 0.0, 0.0)), (4, 4))[:, 3]
    y = np.array([values["w_f"], -values["w_f"], values["w_r"], -values["w_r"]]) / 2
    assert -(loads * y).sum() == pytest.approx(values["h"] * side)
    forces = np.zeros(12)
    forces[1::3] = side / 4
    assert printed.derivatives(state, (0.0, 0.0, 0.0), forces)[4] == pytest.approx(0.0, abs=1e-9)


def test_left_and_right_are_symmetric(printed):
    state, (steer, *brakes), forces = any_state(printed)
    swapped = [1, 0, 3, 2]
    mirror = np.array([1.0, -1.0, -1.0, -1.0, -1.0, 1.0, 1.0])
    other = np.concatenate([mirror * state[:7], state[7:][swapped]])
    turned = (np.reshape(forces, (4, 3)) * [1.0, -1.0, -1.0])[swapped].ravel()
    first, second = (np.array(printed.derivatives(*given)) for given in (
        (state, (steer, *brakes), forces), (other, (-steer, *brakes), turned)
    ))  # fmt: skip
    assert second[:7] == pytest.approx(mirror * first[:7], abs=1e-9)
    assert second[7:] == pytest.approx(first[7:][swapped], abs=1e-9)


def test_the_vehicles_fmu_is_valid(fmus):
    assert validate_fmu(str(fmus[1])) == []


@pytest.mark.slow
@pytest.mark.parametrize("manoeuvre", ["step-steer", "brake-in-turn"])
def test_cosimulation_converges_at_first_order(vehicle, fmus, manoeuvre):
    controls, steps = vehicle.MANOEUVRES[manoeuvre], (0.002, 0.001)
    exact = vehicle.monolithic(controls, np.arange(0.0, vehicle.END + 1e-9, steps[-1]))
    # Every compared state changes in every manoeuvre.
    assert (np.abs(exact).max(axis=0) > 1e-4).all()
    worst = []
    for step in steps:
        _, found = vehicle.cosimulate(*fmus, controls, step)
        worst.append(vehicle.errors(found, exact[:: round(step / steps[-1])]).max())
    assert worst[-1] < 0.01
    assert worst[0] / worst[1] == pytest.approx(2.0, abs=0.2)


def test_unknown_manoeuvre(vehicle, monkeypatch, capsys):
    monkeypatch.setattr("sys.argv", ["vehicle.py", "loop"])
    assert vehicle.main() == 2
    assert "step-steer" in capsys.readouterr().err
