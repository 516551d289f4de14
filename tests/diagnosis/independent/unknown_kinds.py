"""The laws of the suite of unknown effects: the library has none of the twenty, and they differ from each other.

Each is an interaction, or acts on a quantity on which no effect of the library with these variables acts. Everything
else is as in the second suite.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping

import numpy as np

from .formulas import Effect, FloatArray, Inputs
from .tires import Specimen

Changes = Mapping[str, FloatArray | float]


def _warmth(x: Inputs) -> FloatArray:
    return (x["T"] - 50.0) / 20.0


def _lean(x: Inputs) -> FloatArray:
    return np.abs(x["gamma"]) / 0.07


def _slip(x: Inputs) -> FloatArray:
    return np.hypot(np.tan(x["alpha"]), x["kappa"])


def _friction(factor: FloatArray) -> Changes:
    return {"friction_x": factor, "friction_y": factor}


def _stiffness(factor: FloatArray) -> Changes:
    return {"stiffness_x": factor, "stiffness_y": factor}


Law = Callable[[float, Specimen, Inputs], Changes]

#: Laws by name with their variables. Size 1 changes a force or moment by about 5 to 10 % where it is large.
LAWS: Mapping[str, tuple[str, Law]] = {
    "temperature_trail": ("T", lambda size, tire, x: {"trail": np.exp(-0.16 * size * _warmth(x))}),
    "speed_trail": ("V", lambda size, tire, x: {"trail": (x["V"] / tire.speed) ** (-0.25 * size)}),
    "speed_stiffness": ("V", lambda size, tire, x: _stiffness((x["V"] / tire.speed) ** (0.15 * size))),
    "sliding_speed_friction": (
        "alpha kappa V",
        lambda size, tire, x: _friction(1.0 / (1.0 + 0.6 * size * _slip(x) * x["V"] / tire.speed)),
    ),
    "pressure_and_temperature_friction": (
        "p T",
        lambda size, tire, x: _friction(np.exp(0.45 * size * (x["p"] / tire.pressure - 1.0) * _warmth(x))),
    ),
    "lean_and_load_friction": (
        "gamma Fz",
        lambda size, tire, x: _friction(1.0 - 0.12 * size * _lean(x) * (x["Fz"] / tire.load - 0.7)),
    ),
    "lean_and_pressure_stiffness": (
        "gamma p",
        lambda size, tire, x: _stiffness(np.exp(0.8 * size * _lean(x) * (x["p"] / tire.pressure - 1.0))),
    ),
    "temperature_side_force": (
        "T Fz",
        lambda size, tire, x: {"side_force": 0.02 * size * x["Fz"] * np.tanh(_warmth(x))},
    ),
    "temperature_camber_force": (
        "gamma T Fz",
        lambda size, tire, x: {"side_force": 0.05 * size * x["Fz"] * np.sin(9.0 * x["gamma"]) * _warmth(x)},
    ),
    "load_and_temperature_stiffness": (
        "Fz T",
        lambda size, tire, x: _stiffness((x["Fz"] / tire.load) ** (-0.16 * size * _warmth(x))),
    ),
    "load_and_pressure_friction": (
        "Fz p",
        lambda size, tire, x: _friction((x["Fz"] / tire.load) ** (0.7 * size * (x["p"] / tire.pressure - 1.0))),
    ),
    "speed_torque": (
        "V Fz",
        lambda size, tire, x: {"torque": 0.006 * size * tire.radius * x["Fz"] * (x["V"] / tire.speed - 1.0)},
    ),
    "hot_sliding_friction": (
        "alpha kappa T",
        lambda size, tire, x: _friction(1.0 - 0.1 * size * np.tanh(10.0 * _slip(x)) * _warmth(x)),
    ),
    "wear_trail": ("distance", lambda size, tire, x: {"trail": 1.0 - 0.25 * size * x["sliding"]}),
    "speed_and_pressure_stiffness": (
        "V p",
        lambda size, tire, x: _stiffness(
            np.exp(0.9 * size * np.log(x["V"] / tire.speed) * (x["p"] / tire.pressure - 1.0))
        ),
    ),
    "lean_and_slip_friction": (
        "gamma alpha",
        lambda size, tire, x: {"friction_y": 1.0 - 0.1 * size * _lean(x) * np.tanh(12.0 * np.abs(x["alpha"]))},
    ),
    "pressure_side_force": (
        "p Fz",
        lambda size, tire, x: {"side_force": 0.12 * size * x["Fz"] * (x["p"] / tire.pressure - 1.0)},
    ),
    "lean_and_speed_friction": (
        "gamma V",
        lambda size, tire, x: _friction((x["V"] / tire.speed) ** (-0.12 * size * _lean(x))),
    ),
    "temperature_drive_friction": (
        "kappa T",
        lambda size, tire, x: {"friction_x": 1.0 + 0.08 * size * np.tanh(x["kappa"] / 0.02) * _warmth(x)},
    ),
    "softening_trail": (
        "alpha kappa memory",
        lambda size, tire, x: {"trail": 1.0 - 0.25 * size * x["largest_slip"]},
    ),
}


def _sized(law: Law) -> Callable[[float], Effect]:
    return lambda size: lambda tire, x: law(size, tire, x)


#: The effects of these laws, by name.
UNKNOWN_EFFECTS: Mapping[str, Callable[[float], Effect]] = {name: _sized(law) for name, (_, law) in LAWS.items()}
#: The variables of the laws, by name.
UNKNOWN_VARIABLES: Mapping[str, frozenset[str]] = {name: frozenset(text.split()) for name, (text, _) in LAWS.items()}
