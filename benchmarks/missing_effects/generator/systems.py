"""Systems that are not tires: an oscillator with hysteresis, an electric drive, two tanks.

The baseline model is a sum of declared columns in each channel. Hidden effects add to channels.

- bouc_wen: restoring force of a spring with hysteresis, driven by its displacement (Y.-K. Wen, Method for random
  vibration of hysteretic systems, 1976; the benchmark of Noel and Schoukens, 2016).
- drive: force of an electro-mechanical positioning system (A. Janot, M. Gautier, M. Brunot, Data set and reference
  models of EMPS, 2019): mass and viscous friction are known.
- two_tanks: net flows of a pump and two tanks in a row by Torricelli's law (M. Schoukens, J. P. Noel, Three benchmarks
  addressing open challenges in nonlinear system identification, 2017).
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np

from .draws import Draws, FloatArray, low_pass

Inputs = Mapping[str, FloatArray]
Law = Callable[[float, Inputs], Mapping[str, FloatArray]]


@dataclass(frozen=True)
class System:
    """A system.

    - `inputs`: names and units. `channels`: what is measured, with units.
    - `base`: by channel the texts of the columns of the baseline model, and `columns` that compute them.
    - `values`: ranges of the coefficients of all columns, in this order.
    - `effects`: by the name of a candidate its meaning and law.
    - `unknown`: variables and law of an effect that no candidate describes.
    - `program`: inputs over time; the flag is True for the other maneuvers.
    """

    inputs: Mapping[str, str]
    channels: Mapping[str, str]
    base: Mapping[str, tuple[str, ...]]
    columns: Callable[[Inputs], Mapping[str, list[FloatArray]]]
    values: tuple[tuple[float, float], ...]
    effects: Mapping[str, tuple[str, Law]]
    unknown: tuple[tuple[str, ...], Law]
    program: Callable[[Draws, bool], dict[str, FloatArray]]

    def outputs(self, values: FloatArray, x: Inputs, hidden: Mapping[str, float]) -> dict[str, FloatArray]:
        """Return the channels with the baseline model's coefficients and hidden effects of given sizes."""
        outputs, at = {}, 0
        for channel, columns in self.columns(x).items():
            outputs[channel] = np.stack(columns, axis=1) @ values[at : at + len(columns)]
            at += len(columns)
        for name, size in hidden.items():
            law = self.unknown[1] if name == "UNKNOWN" else self.effects[name][1]
            for channel, change in law(size, x).items():
                outputs[channel] = outputs[channel] + change
        return outputs


def _waves(draws: Draws, t: FloatArray, frequencies: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return a sum of sines of about one, and its first and second derivative."""
    phases, amplitudes = draws.uniform(0.0, 2.0 * np.pi, len(frequencies)), 1.0 / (1.0 + frequencies)
    angle, rate = 2.0 * np.pi * frequencies * t[:, None] + phases, 2.0 * np.pi * frequencies
    sine, cosine = amplitudes * np.sin(angle), amplitudes * np.cos(angle)
    scale = 1.0 / np.abs(sine.sum(axis=1)).max()
    return (scale * sine.sum(axis=1), scale * (cosine * rate).sum(axis=1), -scale * (sine * rate**2).sum(axis=1))


def _times(other: bool) -> FloatArray:
    return np.arange(1000 if other else 2500) / 50.0


def _motion(draws: Draws, other: bool) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray]:
    t = _times(other)
    return (t, *_waves(draws, t, draws.uniform(0.1, 1.2 if other else 0.8, 5)))


def _oscillator_program(draws: Draws, other: bool) -> dict[str, FloatArray]:
    t, x, v, _ = _motion(draws, other)
    return {"t": t, "x": 0.02 * x, "v": 0.02 * v}


def _hysteresis(size: float, x: Inputs) -> Mapping[str, FloatArray]:
    """Bouc and Wen: dz = A dx - beta |dx| |z|^0.5 z - gamma dx |z|^1.5, in small parts of each step."""
    z, state = np.zeros(len(x["t"])), 0.0
    for i, dx in enumerate(np.diff(x["x"]), 1):
        for _ in range(8):
            state += dx / 8.0 * (1.0 - (0.8 * np.sign(dx * state) + 0.2) * abs(state / 0.004) ** 1.5)
        z[i] = state
    return {"F": 4e4 * size * z}


def _drive_program(draws: Draws, other: bool) -> dict[str, FloatArray]:
    t, q, v, a = _motion(draws, other)
    return {"t": t, "q": 0.12 * q, "v": 0.12 * v, "a": 0.12 * a}


def _tank_program(draws: Draws, other: bool) -> dict[str, FloatArray]:
    t = _times(other)
    u, h1, h2 = (_waves(draws, t, draws.uniform(0.02, 0.3, 5))[0] for _ in range(3))
    return {"t": t, "u": 3.0 + 2.5 * u, "h1": 0.5 + 0.42 * h1, "h2": 0.4 + 0.34 * h2}


SYSTEMS: Mapping[str, System] = {
    "bouc_wen": System(
        {"t": "s", "x": "m", "v": "m/s"}, {"F": "N"}, {"F": ("x", "v")},
        lambda x: {"F": [x["x"], x["v"]]}, ((3e4, 6e4), (200.0, 600.0)),
        {
            "hysteresis": ("a force with memory of the displacement, which opposes its change", _hysteresis),
            "cubic_stiffness": ("the spring stiffens with displacement",
                                lambda s, x: {"F": 160.0 * s * np.sinh(x["x"] / 0.008) / np.sinh(2.5)}),
            "coulomb_friction": ("a force against the sign of the velocity",
                                 lambda s, x: {"F": 60.0 * s * np.tanh(x["v"] / 0.001)}),
            "quadratic_damping": ("damping grows with speed",
                                  lambda s, x: {"F": 9e3 * s * np.abs(x["v"]) ** 0.8 * x["v"]}),
        },
        (("x", "v"), lambda s, x: {"F": 120.0 * s * np.tanh(x["x"] / 0.01) * x["v"] / 0.04}),
        _oscillator_program,
    ),
    "drive": System(
        {"t": "s", "q": "m", "v": "m/s", "a": "m/s2"}, {"F": "N"}, {"F": ("a", "v", "1")},
        lambda x: {"F": [x["a"], x["v"], np.ones_like(x["t"])]}, ((80.0, 120.0), (150.0, 300.0), (-5.0, 5.0)),
        {
            "coulomb_friction": ("a force against the sign of the velocity",
                                 lambda s, x: {"F": 15.0 * s * np.tanh(x["v"] / 0.003)}),
            "stribeck_friction": ("friction that falls with speed", lambda s, x: {
                "F": 15.0 * s * np.tanh(x["v"] / 0.003) * np.exp(-np.abs(x["v"]) / 0.04)}),
            "cogging": ("a force that is periodic in the position, with a pitch of 0.04 m",
                        lambda s, x: {"F": 5.0 * s * np.sin(2.0 * np.pi * x["q"] / 0.04 + 0.6)}),
            "belt_elasticity": ("the acceleration acts with a lag of about 0.02 to 0.08 s", lambda s, x: {
                "F": 60.0 * s * (low_pass(x["a"], np.full(len(x["t"]), 0.5)) - x["a"])}),
        },
        (("q", "a"), lambda s, x: {"F": 22.0 * s * x["a"] * np.tanh(x["q"] / 0.06)}),
        _drive_program,
    ),
    "two_tanks": System(
        {"t": "s", "u": "V", "h1": "m", "h2": "m"}, {"q1": "l/s", "q2": "l/s"},
        {"q1": ("u", "sqrt(h1)"), "q2": ("sqrt(h1)", "sqrt(h2)")},
        lambda x: {"q1": [x["u"], np.sqrt(x["h1"])], "q2": [np.sqrt(x["h1"]), np.sqrt(x["h2"])]},
        ((0.3, 0.5), (-1.6, -1.0), (1.0, 1.6), (-1.8, -1.2)),
        {
            "overflow": ("the upper tank spills into the lower one above 0.75 m", lambda s, x: {
                "q1": -1.8 * s * np.maximum(x["h1"] - 0.75, 0.0), "q2": 1.5 * s * np.maximum(x["h1"] - 0.75, 0.0)}),
            "pump_saturation": ("the flow of the pump levels off with its voltage",
                                lambda s, x: {"q1": -0.12 * s * (np.cosh(x["u"] / 3.0) - 1.0)}),
            "leak": ("the lower tank loses water in proportion to its level",
                     lambda s, x: {"q2": -0.35 * s * x["h2"] ** 1.1}),
            "pump_lag": ("the flow follows the voltage with a lag of about 0.2 to 2 s",
                         lambda s, x: {"q1": 0.4 * s * (low_pass(x["u"], np.full(len(x["t"]), 0.02 / 0.7)) - x["u"])}),
        },
        (("h1", "h2"), lambda s, x: {"q2": 0.5 * s * x["h1"] * (x["h2"] - 0.4)}),
        _tank_program,
    ),
}  # fmt: skip
