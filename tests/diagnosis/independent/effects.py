"""Effects of tires in forms that are not the library's: exponentials, powers, saturation, memory.

Each function takes a size and returns the effect: what changes, given tire and inputs. Size 1 is a typical tire.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping

import numpy as np

from .formulas import Effect, FloatArray, Inputs
from .tires import Specimen

Changes = Mapping[str, FloatArray | float]


def _effect(law: Callable[[float, Specimen, Inputs], Changes]) -> Callable[[float], Effect]:
    """Return the function that gives a law its size."""
    return lambda size: lambda tire, x: law(size, tire, x)


def _friction(factor: FloatArray) -> Changes:
    return {"friction_x": factor, "friction_y": factor}


def _stiffness(factor: FloatArray) -> Changes:
    return {"stiffness_x": factor, "stiffness_y": factor}


@_effect
def load_friction(size: float, tire: Specimen, x: Inputs) -> Changes:
    """Contact of rubber with asperities: friction is a power of the load."""
    return _friction((x["Fz"] / tire.load) ** (-0.13 * size))


@_effect
def load_stiffness(size: float, tire: Specimen, x: Inputs) -> Changes:
    """The contact length saturates: a rational function of the load."""
    return {"stiffness_y": (1.0 + 0.4 * size) / (1.0 + 0.4 * size * x["Fz"] / tire.load)}


@_effect
def load_curvature(size: float, tire: Specimen, x: Inputs) -> Changes:
    """The curvature factor changes with the logarithm of the load."""
    ratio = np.log(x["Fz"] / tire.load)
    return {"curvature_x": 0.6 * size * ratio, "curvature_y": -0.7 * size * ratio}


@_effect
def camber_thrust(size: float, tire: Specimen, x: Inputs) -> Changes:
    """The thrust saturates as an arctangent of the inclination."""
    return {"camber_thrust": 0.1 * size * x["Fz"] * np.arctan(10.0 * x["gamma"])}


@_effect
def camber_stiffness(size: float, tire: Specimen, x: Inputs) -> Changes:
    """The cornering stiffness decreases exponentially with the inclination."""
    return {"stiffness_y": np.exp(-1.4 * size * np.abs(x["gamma"]))}


@_effect
def camber_friction(size: float, tire: Specimen, x: Inputs) -> Changes:
    """Friction decreases with a power of the inclination between one and two."""
    return _friction(1.0 - 0.05 * size * np.abs(x["gamma"] / 0.07) ** 1.6)


@_effect
def pressure_stiffness(size: float, tire: Specimen, x: Inputs) -> Changes:
    """The slip stiffness is a power of the pressure."""
    ratio = x["p"] / tire.pressure
    return {"stiffness_x": ratio ** (-0.35 * size), "stiffness_y": ratio ** (0.4 * size)}


@_effect
def pressure_friction(size: float, tire: Specimen, x: Inputs) -> Changes:
    """Friction is a power of the pressure."""
    return _friction((x["p"] / tire.pressure) ** (-0.18 * size))


@_effect
def combined_Gxa(size: float, tire: Specimen, x: Inputs) -> Changes:
    """Slip angles reduce the longitudinal force, as a rational function."""
    slope = 9.0 * size / (1.0 + 5.0 * np.abs(x["kappa"]))
    return {"weight_x": (1.0 + (slope * np.tan(x["alpha"])) ** 2) ** -0.45}


@_effect
def combined_Gyk(size: float, tire: Specimen, x: Inputs) -> Changes:
    """Longitudinal slip reduces the side force, as a rational function."""
    slope = 9.0 * size / (1.0 + 5.0 * np.abs(np.tan(x["alpha"])))
    return {"weight_y": (1.0 + (slope * x["kappa"]) ** 2) ** -0.45}


@_effect
def kappa_sideforce_SVyk(size: float, tire: Specimen, x: Inputs) -> Changes:
    """Longitudinal slip generates a side force that saturates and vanishes at large slip angles."""
    shape = np.tanh(15.0 * x["kappa"]) / (1.0 + (9.0 * np.tan(x["alpha"])) ** 2)
    return {"kappa_side_force": 0.04 * size * tire.values["PDY1"] * x["Fz"] * shape}


@_effect
def plysteer(size: float, tire: Specimen, x: Inputs) -> Changes:
    """The plies steer the tread; less under load."""
    return {"shift": 0.003 * size * (x["Fz"] / tire.load) ** -0.2}


@_effect
def conicity(size: float, tire: Specimen, x: Inputs) -> Changes:
    """The cone pulls with a force that grows less than the load."""
    return {"side_force": 0.02 * size * tire.load * (x["Fz"] / tire.load) ** 0.8}


@_effect
def curvature_asym(size: float, tire: Specimen, x: Inputs) -> Changes:
    """The curvature factor changes smoothly from negative to positive slip."""
    return {"curvature_x": 0.25 * size * np.tanh(x["kappa"] / 0.02),
            "curvature_y": 0.3 * size * np.tanh(x["alpha"] / 0.02)}  # fmt: skip


@_effect
def temp_friction(size: float, tire: Specimen, x: Inputs) -> Changes:
    """Friction falls exponentially with the tread temperature."""
    return _friction(np.exp(-0.0035 * size * (x["T"] - 50.0)))


@_effect
def temp_stiffness(size: float, tire: Specimen, x: Inputs) -> Changes:
    """The modulus falls in a range of temperatures."""
    return _stiffness(1.0 - 0.14 * size * np.tanh((x["T"] - 55.0) / 30.0))


@_effect
def speed_friction(size: float, tire: Specimen, x: Inputs) -> Changes:
    """Friction is a power of the speed."""
    return _friction((x["V"] / tire.speed) ** (-0.09 * size))


@_effect
def wear_drift(size: float, tire: Specimen, x: Inputs) -> Changes:
    """Wear by the energy of sliding that saturates: less friction, a shallower and stiffer tread."""
    worn = 1.0 - np.exp(-1.6 * x["sliding"])
    return {"friction_x": 1.0 - 0.08 * size * worn, "friction_y": 1.0 - 0.08 * size * worn,
            "stiffness_x": 1.0 + 0.07 * size * worn, "stiffness_y": 1.0 + 0.07 * size * worn}  # fmt: skip


@_effect
def residual_torque_Mzr(size: float, tire: Specimen, x: Inputs) -> Changes:
    """A torque about zero slip with the width of a rational function."""
    width = 1.0 + (11.0 * np.tan(x["alpha"])) ** 2 + (8.0 * x["kappa"]) ** 2
    return {"torque": 0.007 * size * tire.radius * x["Fz"] * np.sqrt(x["Fz"] / tire.load) / width}


@_effect
def trail_load(size: float, tire: Specimen, x: Inputs) -> Changes:
    """The pneumatic trail is a power of the load, and so is its decay with slip."""
    ratio = x["Fz"] / tire.load
    return {"trail": ratio ** (-0.2 * size), "trail_slope": ratio ** (-0.22 * size)}


@_effect
def turn_slip(size: float, tire: Specimen, x: Inputs) -> Changes:
    """Spin takes friction, cornering stiffness and trail."""
    spin = tire.radius * np.abs(x["phit"])
    stiffness, trail = 1.0 / (1.0 + 4.0 * size * spin**2), 1.0 / (1.0 + 3.0 * size * spin)
    return {"friction_y": 1.0 / (1.0 + 0.35 * size * spin), "stiffness_y": stiffness, "trail": trail}


@_effect
def softening(size: float, tire: Specimen, x: Inputs) -> Changes:
    """Mullins effect: the largest slip so far softens the tread."""
    return _stiffness(1.0 - 0.16 * size * x["largest_slip"])


@_effect
def contact_heat(size: float, tire: Specimen, x: Inputs) -> Changes:
    """Friction falls while the contact is hot from recent sliding."""
    return _friction(1.0 - 0.12 * size * x["heat"])


@_effect
def lean_speed(size: float, tire: Specimen, x: Inputs) -> Changes:
    """A camber force that grows with speed."""
    return {"side_force": 0.06 * size * x["Fz"] * np.sin(9.0 * x["gamma"]) * (x["V"] / tire.speed - 1.0)}


#: Effects that change forces at once. Lags and further moments are `LAGS` and `MOMENTS`.
EFFECTS: Mapping[str, Callable[[float], Effect]] = {
    "load_friction": load_friction, "load_stiffness": load_stiffness, "load_curvature": load_curvature,
    "camber_thrust": camber_thrust, "camber_stiffness": camber_stiffness, "camber_friction": camber_friction,
    "pressure_stiffness": pressure_stiffness, "pressure_friction": pressure_friction, "combined_Gxa": combined_Gxa,
    "combined_Gyk": combined_Gyk, "kappa_sideforce_SVyk": kappa_sideforce_SVyk, "plysteer": plysteer,
    "conicity": conicity, "curvature_asym": curvature_asym, "temp_friction": temp_friction,
    "temp_stiffness": temp_stiffness, "speed_friction": speed_friction, "wear_drift": wear_drift,
    "residual_torque_Mzr": residual_torque_Mzr, "trail_load": trail_load, "turn_slip": turn_slip,
    "softening": softening, "contact_heat": contact_heat, "lean_speed": lean_speed,
}  # fmt: skip


def _lever(size: float, tire: Specimen, x: Inputs, force: Mapping[str, FloatArray]) -> FloatArray:
    """Return the torque of Fx: its lever arm grows with a side force that saturates."""
    arm = tire.radius * size * (0.014 + 0.02 * np.tanh(force["Fy"] / tire.load))
    return np.asarray(arm * force["Fx"])


def _overturning(size: float, tire: Specimen, x: Inputs, force: Mapping[str, FloatArray]) -> FloatArray:
    """Return Mx: shift of the load under inclination and side force, which saturates."""
    shift = 0.01 - 0.6 * np.sin(x["gamma"]) + 0.045 * np.tanh(1.2 * force["Fy"] / tire.load)
    return np.asarray(tire.radius * x["Fz"] * size * shift)


def _rolling(size: float, tire: Specimen, x: Inputs, force: Mapping[str, FloatArray]) -> FloatArray:
    """Return My, adapted SAE: hysteresis with a power of the load, and a part of the longitudinal force."""
    hysteresis = 0.011 * tire.load * (x["Fz"] / tire.load) ** 1.1
    return np.asarray(tire.radius * size * (hysteresis + 0.04 * force["Fx"]))


#: Effects on a moment that follow from the forces: channel and law.
MOMENTS: Mapping[str, tuple[str, Callable[[float, Specimen, Inputs, Mapping[str, FloatArray]], FloatArray]]] = {
    "Mz_from_Fx": ("Mz", _lever),
    "overturning_Mx": ("Mx", _overturning),
    "rolling_resistance_My": ("My", _rolling),
}
#: Effects that delay a slip: the slip, and the relaxation length in radii as a function of load over nominal load.
LAGS: Mapping[str, tuple[str, Callable[[float, FloatArray], FloatArray]]] = {
    "relax_lat": ("alpha", lambda size, load: 1.3 * size * (1.0 + 0.05 * (load - 1.0))),
    "relax_lon": ("kappa", lambda size, load: 0.5 * size * (1.0 + 0.05 * (load - 1.0))),
    "relax_load": ("alpha", lambda size, load: 1.2 * size * load**0.6),
}
