"""Effects with memory in forms that are not the library's: what the past of a program changes in the forces.

Each law integrates its memory over a program at the internal rate and returns the factors and terms of `Change`. Heat
and wear follow the sliding power of the forces that the law gets.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping

import numpy as np

from .formulas import FloatArray, Inputs
from .tires import Specimen

Forces = Mapping[str, FloatArray]
Changes = Mapping[str, FloatArray | float]
Law = Callable[[float, Specimen, Inputs, Forces], Changes]


def follow(t: FloatArray, target: FloatArray, rate: FloatArray) -> FloatArray:
    """Return a first-order lag by implicit midpoint steps, in equilibrium at the start."""
    h = 0.5 * np.diff(t)
    middle, half = 0.5 * (target[1:] + target[:-1]), 0.5 * h * (rate[1:] + rate[:-1])
    values, state = [float(target[0])], float(target[0])
    for wanted, a in zip(middle.tolist(), half.tolist(), strict=True):
        state += 2.0 * a / (1.0 + a) * (wanted - state)
        values.append(state)
    return np.asarray(values)


def bouc_wen(path: FloatArray, width: float, sharpness: float) -> FloatArray:
    """Return the hysteresis dz = (1 - |z|^n sgn(z ds)) ds/width along a path, shape (n,)."""
    steps = np.diff(path) / width
    values, z = [0.0], 0.0
    for step in steps.tolist():
        for _ in range(4):  # four steps of Euler
            along = 1.0 if z * step > 0.0 else -1.0
            z += 0.25 * step * (1.0 - along * abs(z) ** sharpness)
        values.append(z)
    return np.clip(np.asarray(values), -1.0, 1.0)


def sliding(tire: Specimen, x: Inputs, force: Forces) -> FloatArray:
    """Return the sliding power over nominal load, m/s."""
    power = np.abs(force["Fy"] * np.sin(x["alpha"])) + np.abs(force["Fx"] * x["kappa"])
    return np.asarray(power * x["V"] / tire.load)


def _friction(factor: FloatArray) -> Changes:
    return {"friction_x": factor, "friction_y": factor}


def _stiffness(factor: FloatArray) -> Changes:
    return {"stiffness_x": factor, "stiffness_y": factor}


def heat_friction(size: float, tire: Specimen, x: Inputs, force: Forces) -> Changes:
    """A surface heats a carcass; friction is a rational function of the temperature of the surface."""
    power = sliding(tire, x, force) * (x["Fz"] / tire.load) ** -0.3
    cooling = (x["V"] / tire.speed) ** 0.5
    surface = follow(x["t"], power / cooling, cooling / 2.5)
    carcass = follow(x["t"], surface, np.full(len(power), 1.0 / 18.0))
    return _friction(1.0 / (1.0 + 0.16 * size * (0.75 * surface + 0.25 * carcass)))


def heat_stiffness(size: float, tire: Specimen, x: Inputs, force: Forces) -> Changes:
    """The modulus falls with the temperature of the tread and saturates."""
    cooling = 0.6 + 0.4 * x["V"] / tire.speed
    heat = follow(x["t"], sliding(tire, x, force) / cooling, cooling / 6.0)
    return _stiffness(1.0 - 0.3 * size * np.tanh(heat / 1.2))


def slip_history(size: float, tire: Specimen, x: Inputs, force: Forces) -> Changes:
    """A Bouc-Wen element along the size of the slip that the contact has followed."""
    rate = np.abs(x["V"]) / (0.15 * tire.radius)
    slips = [follow(x["t"], one, rate) for one in (np.tan(x["alpha"]), x["kappa"])]
    z = bouc_wen(np.hypot(*slips), 0.025, 2.0)
    return {**_friction(1.0 + 0.04 * size * z), **_stiffness(1.0 + 0.05 * size * z)}


def hysteresis_force(size: float, tire: Specimen, x: Inputs, force: Forces) -> Changes:
    """Inner friction of the carcass: a Bouc-Wen element that grows less than the load."""
    z = bouc_wen(follow(x["t"], np.tan(x["alpha"]), np.abs(x["V"]) / (0.2 * tire.radius)), 0.015, 2.0)
    return {"side_force": 0.035 * size * tire.load * (x["Fz"] / tire.load) ** 0.8 * z}


def break_in(size: float, tire: Specimen, x: Inputs, force: Forces) -> Changes:
    """Friction of the new tread falls as a rational function of the work of sliding."""
    step = np.diff(x["t"], prepend=x["t"][0])
    work = np.cumsum(step * sliding(tire, x, force))
    return _friction(1.0 + 0.12 * size / (1.0 + work / 4.0) ** 1.5)


def load_lag(size: float, tire: Specimen, x: Inputs, force: Forces) -> Changes:
    """Two lags, one behind the other: the contact carries the load that it had some distance ago."""
    rate = np.abs(x["V"]) / (0.7 * tire.radius * size)
    late = follow(x["t"], follow(x["t"], x["Fz"], rate), rate)
    ratio = np.clip(late / np.maximum(x["Fz"], 1.0), 0.2, 3.0)
    return {"friction_y": ratio, "stiffness_y": ratio**0.8}


def turn_slip(size: float, tire: Specimen, x: Inputs, force: Forces) -> Changes:
    """Spin of a wheel plane that the bench turns, from the rate of the slip angle; phit is not recorded."""
    spin = tire.radius * np.abs(np.gradient(x["alpha"], x["t"])) / np.maximum(np.abs(x["V"]), 0.1)
    stiffness, trail = 1.0 / (1.0 + 4.0 * size * spin**2), 1.0 / (1.0 + 3.0 * size * spin)
    return {"friction_y": 1.0 / (1.0 + 0.35 * size * spin), "stiffness_y": stiffness, "trail": trail}


def load_lag_falling(size: float, tire: Specimen, x: Inputs, force: Forces) -> Changes:
    """The contact grows with the load at once, and leaves it late: three times the distance while the load falls."""
    late, values = float(x["Fz"][0]), [float(x["Fz"][0])]
    for way, load in zip((np.diff(x["t"]) * np.abs(x["V"][1:])).tolist(), x["Fz"][1:].tolist(), strict=True):
        length = tire.radius * size * (1.0 if load > late else 3.0)
        late = load + (late - load) * float(np.exp(-way / length))
        values.append(late)
    ratio = np.clip(np.asarray(values) / np.maximum(x["Fz"], 1.0), 0.2, 3.0)
    return {"friction_y": ratio**0.9, "stiffness_y": ratio**0.8}


def slip_history_lateral(size: float, tire: Specimen, x: Inputs, force: Forces) -> Changes:
    """Friction hysteresis of the lateral axis alone."""
    both = slip_history(size, tire, x, force)
    return {name: both[name] for name in ("friction_y", "stiffness_y")}


#: Laws by the name of the effect in the library.
LAWS: Mapping[str, Law] = {
    "heat_friction": heat_friction, "heat_stiffness": heat_stiffness, "slip_history": slip_history,
    "hysteresis_force": hysteresis_force, "break_in": break_in, "load_lag": load_lag,
}  # fmt: skip


def relaxed_slip(size: float, tire: Specimen, x: Inputs) -> FloatArray:
    """Return the slip angle that acts: the relaxation length falls with the slip that acts, as a hyperbolic cosine."""
    h, demand, speed = np.diff(x["t"]), np.tan(x["alpha"]), np.abs(x["V"])
    state, values = float(demand[0]), [float(demand[0])]
    for i in range(len(h)):
        length = 2.0 * size * tire.radius / np.cosh(min(abs(state) / 0.045, 30.0)) + 0.02 * tire.radius
        way = h[i] * speed[i] / length
        state = demand[i + 1] + (state - demand[i + 1]) * float(np.exp(-way))
        values.append(state)
    return np.arctan(np.asarray(values))


def carcass_slip(size: float, tire: Specimen, x: Inputs) -> FloatArray:
    """Return the slip angle at the contact, which moves sideways as a mass on a spring and a damper.

    The spring is loaded by a side force that saturates, so that the motion is not that of a linear oscillator.
    """
    ratio, frequency, damping, substeps = 1.2 * tire.radius * size, 45.0, 0.12, 4
    h, demand, speed = np.diff(x["t"]) / substeps, np.tan(x["alpha"]), np.maximum(np.abs(x["V"]), 0.5)
    saturation = 0.09  # slip at which the side force reaches 76 % of its largest value
    place, velocity, slips = ratio * saturation * float(np.tanh(demand[0] / saturation)), 0.0, [float(demand[0])]
    for i, step in enumerate(h.tolist()):
        for k in range(substeps):
            wanted = demand[i] + (demand[i + 1] - demand[i]) * (k + 0.5) / substeps
            # The midpoint rule for position over half a step, velocity over a whole one.
            middle = place + 0.5 * step * velocity
            slip = wanted - velocity / speed[i]
            force = ratio * saturation * float(np.tanh(slip / saturation))
            velocity += step * (frequency**2 * (force - middle) - 2.0 * damping * frequency * velocity)
            place = middle + 0.5 * step * velocity
        slips.append(float(demand[i + 1] - velocity / speed[i + 1]))
    return np.arctan(np.asarray(slips))


#: Laws by the name of the effect of which they are another kind: in one direction, or of one axis.
VARIANTS: Mapping[str, Law] = {"load_lag": load_lag_falling, "slip_history": slip_history_lateral}
#: Laws of the slip angle that acts, by the name of the effect in the library.
ACTING = {"relax_slip": relaxed_slip, "carcass_2nd_order": carcass_slip}
#: Laws that need a fast bench or a slow wheel.
FAST_LAWS: Mapping[str, Law] = {"turn_slip": turn_slip}
