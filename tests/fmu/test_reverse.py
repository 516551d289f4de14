"""Laws of every model and every kind of inputs: backward the forces are reversed, sliding dissipates.

`test_sti.py` compares the library with the Standard Tyre Interface with the FMU with hub inputs, also in reverse.
"""

from __future__ import annotations

import contextlib
from dataclasses import replace

import numpy as np
import pytest

from tirefmu.fmu.simulation.simulate import loaded
from tirefmu.symbolic.models import MODELS

from ..relatives import slow_but, slow_relatives
from .conftest import OK, Host

#: Effects that make a force or a moment without slip, or distinguish the signs of a slip; coefficients of other ones.
SHIFTS = frozenset({
    "longitudinal_shift", "plysteer", "conicity", "curvature_asym", "kappa_sideforce_SVyk", "trail_shift",
    "trail_curvature", "residual_torque_Mzr", "Mz_from_Fx",
})  # fmt: skip
SHIFTING = ("RHX1", "RHY1", "RHY2", "RBY3", "PEY3")
KINDS = ("slip", "wheel", "hub", "hub-torque")
#: Velocity of the contact point, m/s, from walking pace down also near standstill; share of it across the wheel;
#: slip (omega R_0 - V_x) / V_x: locked, braked, driven, spinning.
SPEEDS = (0.004, 0.3, 1.7, 5.0, 10.0, 40.0)
ACROSS = (0.0, 0.03, 0.4)
SLIPS = (-1.0, -0.1, -0.05, 0.05, 0.3, 1.5)
MOTIONS = [(V_x, share * V_x, slip) for V_x in SPEEDS for share in ACROSS for slip in SLIPS]
with_speed = pytest.mark.parametrize(
    ("model", "inputs"),
    slow_but(
        [("mf61", "slip"), ("mf61", "hub"), ("brush", "wheel"), ("fiala", "slip")],
        [(name, kind) for name, model in MODELS.items()
         for kind in KINDS if kind != "slip" or "V" in {quantity.name for quantity in model.inputs}],
    ),
)  # fmt: skip


class Wheel:
    """An FMU of a tire, initialized again for each test, with or without the shifts of the tire."""

    def __init__(self, host, tire):
        self.host, self.tire, self.symbolic_model = host, tire, tire.symbolic_model

    def start(self, *, shifts):
        self.host.call("Reset")
        self.host.initialize()
        even = {name: 0.0 if name in SHIFTING else value for name, value in self.tire.values.items()}
        tire = self.tire if shifts else replace(self.tire, values=even, effects=self.tire.has - SHIFTS)
        values = dict(zip(self.symbolic_model.parameters, tire.parameters().tolist(), strict=True))
        assert self.host.set(**{name: values[name] for name in values if name in self.host.variables}) == OK
        return self

    def forces(self, V_x, V_y, slip):
        """Return Fx, Fy, Mz in steady state; a positive slip drives in the direction of travel."""
        spin = (1.0 + slip) * V_x / self.tire.values["UNLOADED_RADIUS"]
        reference = 1.0 if self.symbolic_model.motion.reverses else np.sign(V_x)
        given = {"V_x": V_x, "V_y": V_y, "v_x": V_x, "v_y": V_y, "omega": spin, "V": V_x}
        given |= {"kappa": reference * slip, "alpha": np.arctan(V_y / abs(V_x))}
        settable = (*self.host.inputs, *(["omega"] if "T_brake" in self.host.inputs else []))
        assert self.host.set(**{name: value for name, value in given.items() if name in settable}) == OK
        return self.host.get("Fx", "Fy", "Mz")

    def sliding(self, V_x, slip):
        """Return the sliding velocity V_x - omega R_e of the wheel that was moved last."""
        if "kappa" in self.host.inputs:
            return -slip * V_x
        radius = self.host.get("R_e")[0] if "R_e" in self.host.variables else self.tire.values["UNLOADED_RADIUS"]
        return V_x - (1.0 + slip) * V_x / self.tire.values["UNLOADED_RADIUS"] * radius


@pytest.fixture(scope="module")
def wheel_of(tires, fmus):
    """Return a function that returns the wheel of a model with a kind of inputs; each is loaded on first use."""
    built = {}
    with contextlib.ExitStack() as stack:

        def wheel(model, inputs, *, shifts=False):
            if (model, inputs) not in built:
                name = "first" if model == "mf96" else model
                host = Host(stack.enter_context(loaded(fmus[name, 3, inputs])))
                built[model, inputs] = Wheel(host, tires[name])
            return built[model, inputs].start(shifts=shifts)

        yield wheel


@with_speed
def test_backward_the_forces_are_mirrored(wheel_of, model, inputs):
    """Without shifts: across the wheel plane nothing changes; turned by half a turn, both forces are reversed."""
    wheel = wheel_of(model, inputs)
    near = {"rtol": 1e-9, "atol": 1e-9 * wheel.tire.nominal("Fz")}
    for V_x, V_y, slip in MOTIONS:
        Fx, Fy, Mz = wheel.forces(V_x, V_y, slip)
        assert abs(Fx) > 1e-3 * wheel.tire.nominal("Fz")
        mirrored, turned = wheel.forces(-V_x, V_y, slip), wheel.forces(-V_x, -V_y, slip)
        # Mz as in the model's own equations
        n = 3 if inputs != "slip" or wheel.symbolic_model.motion.reverses else 2
        np.testing.assert_allclose(mirrored[:n], [-Fx, Fy, -Mz][:n], **near, err_msg=f"{V_x, V_y, slip}")
        np.testing.assert_allclose(turned[:n], [-Fx, -Fy, Mz][:n], **near, err_msg=f"{V_x, V_y, slip}")


@pytest.mark.parametrize("inputs", slow_but(["hub"], KINDS[1:]))
@pytest.mark.parametrize("model", [name for name, model in MODELS.items() if not model.motion.reverses])
def test_shifts_are_mirrored_too_if_the_model_is_that_of_forward_rolling(wheel_of, model, inputs):
    """Above the speeds at which both directions are interpolated; other models have signs of their own."""
    wheel = wheel_of(model, inputs, shifts=True)
    for V_x, V_y, slip in MOTIONS[len(MOTIONS) // len(SPEEDS) :]:
        Fx, Fy, Mz = wheel.forces(V_x, V_y, slip)
        backward = wheel.forces(-V_x, V_y, slip)
        np.testing.assert_allclose(backward, [-Fx, Fy, -Mz], rtol=1e-9, atol=1e-9, err_msg=f"{V_x, V_y, slip}")


@pytest.mark.parametrize("inputs", KINDS)
@pytest.mark.parametrize("model", slow_relatives(MODELS))
def test_sliding_dissipates(wheel_of, model, inputs):
    wheel, draw = wheel_of(model, inputs), np.random.default_rng(5).uniform
    drawn = [(draw(0.0, 30.0), draw(-4.0, 4.0), draw(-2.0, 2.0)) for _ in range(60)]
    ways = (1.0, -1.0) if {"V", "V_x", "v_x"} & set(wheel.host.inputs) else (1.0,)
    for V_x, V_y, slip in [*MOTIONS, *drawn]:
        for way in ways:
            Fx, Fy, _ = wheel.forces(way * V_x, V_y, slip)
            assert Fx * wheel.sliding(way * V_x, slip) + Fy * V_y < 0.0, (way * V_x, V_y, slip)


@pytest.mark.parametrize("inputs", KINDS[1:])
@pytest.mark.parametrize("model", slow_relatives(MODELS))
def test_with_shifts_too_a_locked_wheel_is_braked(wheel_of, model, inputs):
    wheel = wheel_of(model, inputs, shifts=True)
    for V_x in (*SPEEDS, *(-speed for speed in SPEEDS)):
        assert wheel.forces(V_x, 0.0, -1.0)[0] * V_x < 0.0, V_x


@pytest.mark.parametrize("inputs", ["wheel", "hub"])
@pytest.mark.parametrize("model", slow_relatives(MODELS))
def test_derivatives_are_those_of_the_mirrored_forces(wheel_of, model, inputs):
    wheel = wheel_of(model, inputs, shifts=True)
    host, knowns = wheel.host, ("omega", *(("V_x", "V_y") if inputs == "wheel" else ("v_x", "v_y")))
    names = ("Fx", "Fy", "Mz", "friction_use", *(("M_z_global",) if inputs == "hub" else ()))
    wheel.forces(-12.0, 0.5, 0.07)
    for name in knowns:
        status, slopes = host.derivative(names, [name], [1.0])
        assert status == OK
        np.testing.assert_allclose(slopes, host.differences(names, name, 1e-5), rtol=1e-5, atol=1e-4)
