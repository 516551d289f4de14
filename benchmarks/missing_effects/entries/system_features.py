"""Baseline columns and responses of the systems that are not tires, in textbook forms."""

from __future__ import annotations

from collections.abc import Callable, Mapping

import numpy as np
from scipy.signal import lfilter

from ..answers import FloatArray

Inputs = Mapping[str, FloatArray]
Response = Callable[[Inputs], dict[str, list[FloatArray]]]

BASE: Mapping[str, Callable[[Inputs], FloatArray]] = {
    **{name: lambda x, name=name: x[name] for name in ("x", "v", "a", "u")},  # type: ignore[misc]
    "1": lambda x: np.ones_like(x["t"]), "sqrt(h1)": lambda x: np.sqrt(x["h1"]), "sqrt(h2)": lambda x: np.sqrt(x["h2"]),
}  # fmt: skip


def _play(x: Inputs, *widths: float) -> list[FloatArray]:
    """Return friction elements in series with a spring: the force follows the displacement until it slides."""
    found = []
    for width in widths:
        force, state = np.zeros_like(x["x"]), 0.0
        for i, step in enumerate(np.diff(x["x"], prepend=x["x"][0])):
            force[i] = state = min(max(state + step, -width), width)
        found.append(force)
    return found


def _lagged(x: Inputs, name: str, *times: float) -> list[FloatArray]:
    """Return what lags of first order change in an input, a step behind none of the rows being equal."""
    step = float(x["t"][1] - x["t"][0])
    shares = [1.0 - np.exp(-step / time) for time in times]
    return [lfilter([one], [1.0, one - 1.0], x[name], zi=[(1.0 - one) * x[name][0]])[0] - x[name] for one in shares]


RESPONSES: Mapping[str, Mapping[str, Response]] = {
    "bouc_wen": {
        "hysteresis": lambda x: {"F": _play(x, 0.002, 0.004, 0.008)}, "cubic_stiffness": lambda x: {"F": [x["x"] ** 3]},
        "coulomb_friction": lambda x: {"F": [np.sign(x["v"])]},
        "quadratic_damping": lambda x: {"F": [np.abs(x["v"]) * x["v"]]},
    },
    "drive": {
        "coulomb_friction": lambda x: {"F": [np.sign(x["v"])]},
        "stribeck_friction": lambda x: {"F": [np.sign(x["v"]) * np.exp(-np.abs(x["v"]) / 0.05)]},
        "cogging": lambda x: {"F": [np.sin(2.0 * np.pi * x["q"] / 0.04), np.cos(2.0 * np.pi * x["q"] / 0.04)]},
        "belt_elasticity": lambda x: {"F": _lagged(x, "a", 0.02, 0.04, 0.08)},
    },
    "two_tanks": {
        "overflow": lambda x: {name: [np.maximum(x["h1"] - 0.75, 0.0)] for name in ("q1", "q2")},
        "pump_saturation": lambda x: {"q1": [x["u"] ** 2]}, "leak": lambda x: {"q2": [x["h2"]]},
        "pump_lag": lambda x: {"q1": _lagged(x, "u", 0.2, 0.6, 2.0)},
    },
}  # fmt: skip
