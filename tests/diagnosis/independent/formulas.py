"""The core of MF6.1 in plain NumPy, and the places at which an effect of another form acts.

Pacejka, Tire and Vehicle Dynamics (2012), section 4.E, in adapted SAE (Fy > 0 for alpha > 0): slip tan(alpha),
inclination sin(gamma). Coefficients that a tire lacks are neutral.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, fields

import numpy as np
import numpy.typing as npt

from .tires import Specimen

FloatArray = npt.NDArray[np.float64]
Inputs = Mapping[str, FloatArray]

#: The book's constant against division by zero, and the slope of the residual torque.
EPSILON, RESIDUAL_SLOPE = 1e-6, 10.0


@dataclass
class Change:
    """What effects of another form change; factors are 1 and terms 0 without effects."""

    friction_x: FloatArray | float = 1.0
    friction_y: FloatArray | float = 1.0
    stiffness_x: FloatArray | float = 1.0
    stiffness_y: FloatArray | float = 1.0
    weight_x: FloatArray | float = 1.0
    weight_y: FloatArray | float = 1.0
    trail: FloatArray | float = 1.0
    trail_slope: FloatArray | float = 1.0
    #: Terms: curvature factors, shift of tan(alpha), side forces (N), torque (N m), lever arm (m).
    curvature_x: FloatArray | float = 0.0
    curvature_y: FloatArray | float = 0.0
    shift: FloatArray | float = 0.0
    camber_thrust: FloatArray | float = 0.0
    side_force: FloatArray | float = 0.0
    kappa_side_force: FloatArray | float = 0.0
    torque: FloatArray | float = 0.0

    def include(self, changes: Mapping[str, FloatArray | float]) -> None:
        """Include an effect: factors multiply, terms add."""
        neutral = {field.name: field.default for field in fields(self)}
        for name, value in changes.items():
            before = getattr(self, name)
            setattr(self, name, before * value if neutral[name] == 1.0 else before + value)


#: An effect of another form: what it changes at these inputs.
Effect = Callable[[Specimen, Inputs], Mapping[str, FloatArray | float]]
#: A tire with effects of another form: its forces at these inputs.
Core = Callable[[Specimen, Inputs, Sequence[Effect]], dict[str, FloatArray]]


def forces(tire: Specimen, x: Inputs, effects: Sequence[Effect] = ()) -> dict[str, FloatArray]:
    """Return Fx, Fy and Mz.

    Parameters
    ----------
    tire : Specimen
    x : mapping of str to ndarray, shape (n,)
        kappa, alpha, gamma, Fz, p, V and what the effects need, adapted SAE.
    effects : sequence of Effect
    """
    c = _Coefficients(tire.values)
    change, upright_change = (changed(tire, inputs, effects) for inputs in (x, {**x, "gamma": 0.0 * x["gamma"]}))
    kx, fx0 = _longitudinal(c, tire, x, change)
    side = _lateral(c, tire, x, x["gamma"], change)
    upright = _lateral(c, tire, x, 0.0 * x["gamma"], upright_change)
    slip, kappa = np.tan(x["alpha"]), x["kappa"]
    fx = fx0 * np.cos(c.RCX1_ * np.arctan(c.RBX1 * np.cos(np.arctan(c.RBX2 * kappa)) * slip)) * change.weight_x
    weight = np.cos(c.RCY1_ * np.arctan(c.RBY1 * np.cos(np.arctan(c.RBY2 * slip)) * kappa)) * change.weight_y
    fy = weight * side.force + change.kappa_side_force

    load, dfz = x["Fz"], x["Fz"] / tire.load - 1.0
    q = (kx / side.stiffness * kappa) ** 2
    turned = np.arctan(np.sqrt(np.tan(slip) ** 2 + q)) * np.sign(slip)
    trail = load * tire.radius / tire.load * (c.QDZ1 + c.QDZ2 * dfz) * change.trail
    trail = trail * np.cos(c.QCZ1 * np.arctan((c.QBZ1 + c.QBZ2 * dfz) * change.trail_slope * turned))
    speed = np.abs(x["V"])
    trail = trail * speed / (np.hypot(speed, speed * slip) + EPSILON)
    residual_slip = slip + side.shift + side.vertical / side.stiffness
    residual = load * tire.radius * (c.QDZ6 + c.QDZ7 * dfz) * np.cos(slip)
    residual_turned = np.arctan(np.sqrt(np.tan(residual_slip) ** 2 + q)) * np.sign(residual_slip)
    residual = residual * np.cos(np.arctan(RESIDUAL_SLOPE * residual_turned))
    lever = tire.radius * (c.SSZ1 + c.SSZ2 * fy / tire.load)
    mz = -trail * weight * upright.force + residual + lever * fx + change.torque
    return {"Fx": fx, "Fy": fy, "Mz": mz}


class _Coefficients:
    """Coefficients as attributes; one that the tire lacks is 0, a shape factor NAME_ that it lacks is 1."""

    def __init__(self, values: Mapping[str, float]) -> None:
        self.values = values

    def __getattr__(self, name: str) -> float:
        return self.values.get(name[:-1], 1.0) if name.endswith("_") else self.values.get(name, 0.0)


@dataclass
class _Side:
    force: FloatArray
    stiffness: FloatArray
    shift: FloatArray
    vertical: FloatArray


def changed(tire: Specimen, x: Inputs, effects: Sequence[Effect]) -> Change:
    """Return what effects change together at these inputs."""
    change = Change()
    for effect in effects:
        change.include(effect(tire, x))
    return change


def _of_speed(c: _Coefficients, tire: Specimen, x: Inputs) -> FloatArray:
    return np.asarray(1.0 + c.VMU1 * (np.abs(x["V"]) / tire.speed - 1.0))


def _curve(
    stiffness: FloatArray, shape: float, peak: FloatArray, curvature: FloatArray, slip: FloatArray
) -> FloatArray:
    """Return the Magic Formula, D sin(C atan(B x - E (B x - atan(B x)))), with B from the slope at zero slip."""
    argument = stiffness / (shape * peak + EPSILON) * slip
    return np.asarray(peak * np.sin(shape * np.arctan(argument - curvature * (argument - np.arctan(argument)))))


def _longitudinal(c: _Coefficients, tire: Specimen, x: Inputs, change: Change) -> tuple[FloatArray, FloatArray]:
    """Return slip stiffness and pure force."""
    load, dfz, dpi = x["Fz"], x["Fz"] / tire.load - 1.0, x["p"] / tire.pressure - 1.0
    friction = (c.PDX1 + c.PDX2 * dfz) * (1.0 + c.PPX3 * dpi) * (1.0 - c.PDX3 * x["gamma"] ** 2)
    friction = friction * _of_speed(c, tire, x) * change.friction_x
    stiffness = load * c.PKX1 * (1.0 + c.PPX1 * dpi) * change.stiffness_x
    curvature = c.PEX1 + c.PEX2 * dfz + change.curvature_x
    return stiffness, _curve(stiffness, c.PCX1, friction * load, curvature, x["kappa"])


def _lateral(c: _Coefficients, tire: Specimen, x: Inputs, gamma: FloatArray, change: Change) -> _Side:
    """Return pure side force, cornering stiffness, shift of the slip and vertical shift."""
    load, dfz, dpi, lean = x["Fz"], x["Fz"] / tire.load - 1.0, x["p"] / tire.pressure - 1.0, np.sin(gamma)
    per_load = np.sin(2.0 * np.arctan(load / tire.load / c.PKY2)) if c.PKY2 else load / tire.load
    stiffness = c.PKY1 * tire.load * per_load * (1.0 + c.PPY1 * dpi) * (1.0 - c.PKY3 * np.abs(lean))
    stiffness = stiffness * change.stiffness_y + EPSILON
    camber_force = load * c.PVY3 * lean
    thrust = load * c.PKY6 * lean + change.camber_thrust
    shift = c.PHY1 + (thrust - camber_force) / stiffness + change.shift
    vertical = load * c.PVY1 + camber_force + change.side_force
    friction = (c.PDY1 + c.PDY2 * dfz) * (1.0 + c.PPY3 * dpi) * (1.0 - c.PDY3 * lean**2)
    friction = friction * _of_speed(c, tire, x) * change.friction_y
    curvature = c.PEY1 + c.PEY2 * dfz + change.curvature_y
    force = _curve(stiffness - EPSILON, c.PCY1, friction * load, curvature, np.tan(x["alpha"]) + shift) + vertical
    return _Side(force, stiffness, shift, vertical)
