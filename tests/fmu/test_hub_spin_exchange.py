"""FMUs in which the wheel spins, in Model Exchange: the spin is a state, and the brake locks and releases by events."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from .conftest import OK
from .solver import Solver

INERTIA = 0.8
FIXED = {"v_x": 8.0, "WHEEL_INERTIA": INERTIA, "omega": 33.0}


class Wheel(Solver):
    """A wheel on a carrier that moves straight on; `run` integrates up to a time, with events."""

    def start(self, **values):
        for name, value in {**FIXED, **values}.items():
            assert self.set(name, value) == OK
        super().start()
        self.update()
        assert self.call("enterContinuousTimeMode") == OK
        self.now = 0.0
        return self

    def apply(self, t, states):
        assert self.call("setTime", t) == OK
        assert self.set("r_x", FIXED["v_x"] * t) == OK
        for name, course in self.courses.items():
            assert self.set(name, course(t)) == OK
        assert self.set_states(*states) == OK

    def event(self, **values):
        assert self.call("enterEventMode") == OK
        for name, value in values.items():
            assert self.set(name, value) == OK
        changed = self.update()
        assert self.call("enterContinuousTimeMode") == OK
        return changed

    def run(self, end, **courses):
        """Return times and spins; at each event the FMU updates its discrete states."""
        self.courses, times, spins = courses, [], []

        def rates(t, states):
            self.apply(t, states)
            return self.rates()

        def crossing(t, states):
            self.apply(t, states)
            return self.get("brake_event")[0]

        crossing.terminal, self.events = True, 0
        while self.now < end:
            piece = solve_ivp(rates, (self.now, end), self.states(), "Radau", events=crossing, rtol=1e-7, atol=1e-9)
            times += piece.t.tolist()
            spins += piece.y[-1].tolist()
            self.now = float(piece.t[-1])
            self.apply(self.now, piece.y[:, -1])
            if piece.status == 1:  # hosts return behind the change of sign
                self.now += 1e-7
                self.apply(self.now, piece.y[:, -1] + 1e-7 * self.rates())
                self.event()
                self.events += 1
                assert self.events < 10, "chatter"
        return np.array(times), np.array(spins)


@pytest.fixture
def wheel(fmus, tmp_path, fmi):
    made = Wheel(fmus["first", fmi, "hub-torque"], tmp_path)
    yield made
    made.fmu.freeInstance()


def test_a_brake_locks_holds_and_releases(wheel):
    """The wheel stops, stands while the brake balances the moment of the tire, and turns again without the brake."""
    wheel.start(T_brake=300.0)
    times, spins = wheel.run(0.5)
    assert wheel.events == 1
    assert np.all(np.diff(spins[: np.argmin(spins)]) < 0.0)
    assert wheel.get("omega", "der(omega)").tolist() == [0.0, 0.0]
    assert times[np.argmax(spins < 1e-6)] < 0.3
    moment, torque, margin = wheel.get("M_y", "brake_torque", "brake_event")
    assert torque == -moment
    assert margin == pytest.approx(300.0 - abs(moment), rel=1e-12)
    assert moment > 10.0  # the road drives the wheel
    # The brake is let go: it slips where its largest torque no longer holds the wheel.
    start = wheel.now
    times, spins = wheel.run(0.9, T_brake=lambda t: 300.0 * (1.0 - (t - start) / 0.2) if t < start + 0.2 else 0.0)
    slipped = times[np.argmax(spins > 1e-9)] - start
    assert 0.2 * (1.0 - moment / 300.0) - 2e-3 < slipped < 0.2
    assert spins[-1] > 25.0


def test_co_simulation_converges_to_the_same_spin(wheel, hosts, fmi):
    """Its implicit steps are of first order."""
    wheel.start(T_drive=120.0)
    wheel.run(0.1)
    wheel.event(T_drive=0.0, T_brake=200.0)
    wheel.run(0.3)
    errors = []
    for steps in (300, 1200):
        host, size = hosts("first", fmi, "hub-torque"), 0.3 / steps
        assert host.set(**FIXED, T_drive=120.0) == OK
        host.start()
        for k in range(steps):
            assert host.set(r_x=FIXED["v_x"] * (k + 1) * size) == OK
            assert 3 * k != steps or host.set(T_drive=0.0, T_brake=200.0) == OK
            assert host.step(k * size, size) == OK
        errors.append(host.get("omega")[0] - wheel.get("omega")[0])
    assert abs(errors[0]) < 0.5
    assert errors[1] == pytest.approx(errors[0] / 4.0, rel=0.2)


@pytest.mark.parametrize("state", ["driven", "braked", "held"])
def test_the_rate_is_the_sum_of_torques_and_derivatives_are_exact(wheel, state):
    given = {
        "driven": {"T_drive": 40.0, "T_brake": 1.0},
        "braked": {"T_brake": 60.0},
        "held": {"T_brake": 900.0, "omega": 0.0},
    }[state]
    wheel.start(**given)
    drive, moment, brake, rate = wheel.get("T_drive", "M_y", "brake_torque", "der(omega)")
    assert rate * INERTIA == pytest.approx(drive + moment + brake, abs=1e-9)
    assert brake == {"driven": -1.0, "braked": -60.0, "held": -drive - moment}[state]
    states, names = wheel.states(), ("der(omega)", "brake_torque", "brake_event", "M_y", "Fz")
    for name in ("T_drive", "T_brake", "r_z", "v_x", "omega", "kappa_lagged", "road_mu"):
        values = []
        (before,) = wheel.get(name)
        step = 1e-6 * max(1.0, abs(before))
        for change in (step, -step):
            if name in ("omega", "kappa_lagged"):
                place = -1 if name == "omega" else 0
                moved = states.copy()
                moved[place] += change
                assert wheel.set_states(*moved) == OK
            else:
                assert wheel.set(name, before + change) == OK
            values.append(wheel.get(*names))
        assert wheel.set_states(*states) == OK
        assert name in ("omega", "kappa_lagged") or wheel.set(name, before) == OK
        unknowns, seed = [wheel.references[shown] for shown in names], [wheel.references[name]]
        slopes = wheel.fmu.getDirectionalDerivative(unknowns, seed, [1.0])
        np.testing.assert_allclose(slopes, (values[0] - values[1]) / (2.0 * step), rtol=1e-5, atol=1e-4)


def test_a_held_wheel_has_a_constant_spin_until_an_event(wheel):
    wheel.start(T_brake=900.0, omega=0.0)
    assert wheel.set("T_brake", 0.0) == OK
    assert wheel.get("brake_event")[0] < 0.0
    assert wheel.get("der(omega)").tolist() == [0.0]
    wheel.event()
    assert wheel.get("der(omega)")[0] > 1.0
    assert wheel.set("omega", 3.0) == OK  # as by SetContinuousStates
    assert wheel.get("omega").tolist() == [3.0]
