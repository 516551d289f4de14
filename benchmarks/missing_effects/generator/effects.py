"""Hidden effects of tires, in forms that no library of effects has; size 1 is that of a typical tire.

Each function takes a size, the tire and its inputs, and returns what changes (`formula.FACTORS`, `formula.TERMS`).
Inputs are those of the recording, and ``distance`` (m). `UNKNOWN` are effects that no candidate describes, with the
inputs on which they depend.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping

import numpy as np

from .draws import FloatArray, low_pass
from .formula import Changes, Inputs, Tire

Effect = Callable[[float, Tire, Inputs], Changes]


def _mu(factor: FloatArray) -> Changes:
    return {"mu_x": factor, "mu_y": factor}


def _over(x: Inputs, name: str, nominal: float) -> FloatArray:
    """Return the relative deviation of an input from its nominal value."""
    return x[name] / nominal - 1.0


def _combined(slope: float, own: FloatArray, other: FloatArray) -> FloatArray:
    """Return a weight that decays exponentially with the other slip."""
    return np.asarray(1.0 / np.cosh(slope * other / (1.0 + 4.0 * np.abs(own))))


def _wear(size: float, tire: Tire, x: Inputs) -> Changes:
    worn = x["distance"] / (x["distance"] + 700.0)
    stiffer = 1.0 + 0.14 * size * worn
    return {**_mu(1.0 - 0.16 * size * worn), "K_x": stiffer, "K_y": stiffer}


def _turn_slip(size: float, tire: Tire, x: Inputs) -> Changes:
    spin = tire.radius * np.abs(x["phit"])
    return {"mu_y": 1.0 / (1.0 + 0.4 * size * spin), "K_y": np.exp(-4.0 * size * spin**2),
            "trail": np.exp(-2.5 * size * spin)}  # fmt: skip


def _saturation(size: float, tire: Tire, x: Inputs) -> Changes:
    ratio = x["Fz"] / tire.load * size / 1.3
    return {"K_y": np.tanh(ratio) / ratio}


def _pressure_stiffness(size: float, tire: Tire, x: Inputs) -> Changes:
    over = _over(x, "p", tire.pressure)
    return {"K_x": np.exp(-0.35 * size * over), "K_y": (1.0 + 0.6 * size * over) / (1.0 + 0.15 * size * over)}


#: Effects that change forces at once, by the name of the candidate.
KNOWN: Mapping[str, Effect] = {
    "camber_thrust": lambda s, tire, x: {
        "Fy": -0.9 * s * x["Fz"] * x["gamma"] / np.sqrt(1.0 + (x["gamma"] / 0.09) ** 2)
    },
    "camber_stiffness": lambda s, tire, x: {"K_y": 1.0 / (1.0 + 1.8 * s * np.abs(x["gamma"]))},
    "camber_friction": lambda s, tire, x: _mu(1.0 - 0.09 * s * (1.0 - np.cos(22.0 * x["gamma"]))),
    "load_friction": lambda s, tire, x: _mu((1.0 + 0.16 * s) / (1.0 + 0.16 * s * x["Fz"] / tire.load)),
    "load_stiffness": _saturation,
    "pressure_friction": lambda s, tire, x: _mu(np.exp(-0.22 * s * _over(x, "p", tire.pressure))),
    "pressure_stiffness": _pressure_stiffness,
    "combined_Gxa": lambda s, tire, x: {"G_x": _combined(7.0 * s, x["kappa"], np.tan(x["alpha"]))},
    "combined_Gyk": lambda s, tire, x: {"G_y": _combined(8.0 * s, np.tan(x["alpha"]), x["kappa"])},
    "conicity": lambda s, tire, x: {"Fy": 0.035 * s * tire.load * (1.0 - np.exp(-x["Fz"] / tire.load))},
    "plysteer": lambda s, tire, x: {"slip": 0.0035 * s / (0.7 + 0.3 * x["Fz"] / tire.load)},
    "temp_friction": lambda s, tire, x: _mu(1.0 - 0.09 * s * np.tanh((x["T"] - 52.0) / 18.0)),
    "temp_stiffness": lambda s, tire, x: dict.fromkeys(("K_x", "K_y"), np.exp(-0.008 * s * (x["T"] - 50.0))),
    "speed_friction": lambda s, tire, x: _mu(1.0 / (1.0 + 0.13 * s * _over(x, "V", tire.speed))),
    "wear_drift": _wear,
    "residual_torque_Mzr": lambda s, tire, x: {
        "Mz": -0.009 * s * tire.radius * x["Fz"] / np.cosh(9.0 * np.tan(x["alpha"]))
    },
    "trail_load": lambda s, tire, x: {"trail": 1.0 / (1.0 + 0.35 * s * _over(x, "Fz", tire.load))},
    "turn_slip": _turn_slip,
}
#: The slip that an effect delays, and the relaxation length in radii as a function of load over nominal load.
LAGS: Mapping[str, tuple[str, Callable[[FloatArray], FloatArray]]] = {
    "relax_lat": ("alpha", lambda ratio: 1.4 + 0.1 * np.tanh(ratio - 1.0)),
    "relax_lon": ("kappa", lambda ratio: 0.8 + 0.1 * np.tanh(ratio - 1.0)),
}
#: The lever arm of Fx in Mz over the radius, which the side force moves.
LEVER = "Mz_from_Fx"
UNKNOWN: Mapping[str, tuple[tuple[str, ...], Effect]] = {
    "warm_camber": (("gamma", "T", "Fz"), lambda s, tire, x: {
        "Fy": -0.09 * s * x["Fz"] * np.sin(12.0 * x["gamma"]) * (x["T"] - 50.0) / 15.0}),
    "leaning_traction": (("gamma", "kappa", "Fz"), lambda s, tire, x: {
        "Fx": 0.07 * s * x["Fz"] * np.sin(14.0 * x["gamma"]) * np.tanh(12.0 * x["kappa"])}),
    "pressure_pull": (("p", "alpha", "Fz"), lambda s, tire, x: {
        "Fy": 0.25 * s * x["Fz"] * _over(x, "p", tire.pressure) * np.exp(-((np.tan(x["alpha"]) / 0.08) ** 2))}),
    "warm_trail": (("T", "alpha"), lambda s, tire, x: {"trail": np.exp(-0.016 * s * (x["T"] - 50.0))}),
    "fast_shape": (("V", "alpha"), lambda s, tire, x: {"E_y": 0.9 * s * _over(x, "V", tire.speed)}),
}  # fmt: skip
#: Names of the effects that can be hidden, and of candidates that never are.
NAMES = (*KNOWN, LEVER, *LAGS)
DECOYS = ("load_curvature", "curvature_asym", "kappa_sideforce_SVyk", "relax_load")


def true_forces(tire: Tire, x: Inputs, hidden: Mapping[str, float]) -> dict[str, FloatArray]:
    """Return the forces with hidden effects, whose sizes are given by name."""
    step = np.diff(x["t"], prepend=x["t"][0])
    inputs = {**x, "distance": np.cumsum(x["V"] * step)}
    for name in LAGS.keys() & hidden.keys():
        slip, length = LAGS[name]
        steps = x["V"] * step / (hidden[name] * tire.radius * length(x["Fz"] / tire.load))
        inputs[slip] = np.arctan(low_pass(np.tan(x[slip]), steps)) if slip == "alpha" else low_pass(x[slip], steps)
    laws = {**KNOWN, **{name: law for name, (_, law) in UNKNOWN.items()}}
    forces = tire.forces(inputs, tuple(laws[name](size, tire, inputs) for name, size in hidden.items() if name in laws))
    if LEVER in hidden:
        arm = hidden[LEVER] * tire.radius * (0.03 + 0.02 * np.tanh(forces["Fy"] / tire.load))
        forces["Mz"] = forces["Mz"] - arm * forces["Fx"]
    return forces
