"""Errors of a bench: noise with heavy tails, offsets, drift, cross-talk, delay, ripple, spikes, coarse steps."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from .draws import Draws, FloatArray

#: Errors that a recording has with a probability; noise is always there.
ERRORS = ("offsets", "drift", "cross_talk", "delay", "ripple", "spikes", "coarse", "noisy_inputs")
PROBABILITY = 0.3
#: Standard deviation of the noise over the size of a channel.
NOISE = 0.008
#: The same for the inputs that a bench of tires measures; absolute for angles and slips.
INPUT_NOISE = {"kappa": 3e-4, "alpha": 2e-4, "gamma": 1e-4, "Fz": 0.002, "p": 0.001, "V": 0.001, "T": 0.004}
RELATIVE = ("Fz", "p", "V", "T")


def recorded(
    draws: Draws, inputs: Mapping[str, FloatArray], forces: Mapping[str, FloatArray], radius: float
) -> tuple[dict[str, FloatArray], dict[str, float]]:
    """Return the recording of a tire, and the standard deviation of the noise of each channel."""
    present = {name for name in ERRORS if draws.chance(PROBABILITY)}
    n, t = len(inputs["t"]), inputs["t"]
    size = {name: float(np.sqrt(np.mean(force**2))) for name, force in forces.items()}
    delay = draws.between(0.002, 0.01) if "delay" in present else 0.0
    late = {name: np.interp(t - delay, t, force) for name, force in forces.items()}
    revolution = np.cumsum(inputs["V"] * np.diff(t, prepend=t[0])) / radius
    table, noise = dict(inputs), {}
    for name, force in late.items():
        values = force + NOISE * size[name] * heavy(draws, n)
        if "offsets" in present:
            values = values + draws.between(-0.02, 0.02) * size[name]
        if "drift" in present:
            values = values + draws.between(-0.02, 0.02) * size[name] * t / t[-1]
        if "cross_talk" in present and name != "Fy":  # of Fx it would be an effect: kappa_sideforce_SVyk, Mz_from_Fx
            values = values + draws.between(-0.01, 0.01) * size[name] * late["Fy"] / size["Fy"]
        if "ripple" in present:
            values = values + 0.008 * size[name] * np.sin(revolution + draws.between(0.0, 6.0))
        if "spikes" in present:
            values = np.where(draws.uniform(0.0, 1.0, n) < 0.002, values + 0.5 * size[name], values)
        step = size[name] / (150.0 if "coarse" in present else 3000.0)
        table[name], noise[name] = step * np.round(values / step), NOISE * size[name]
    for name, deviation in INPUT_NOISE.items():
        scale = deviation * (2.5 if "noisy_inputs" in present else 1.0)
        table[name] = table[name] + scale * heavy(draws, n) * (np.mean(inputs[name]) if name in RELATIVE else 1.0)
    return table, noise


def heavy(draws: Draws, n: int) -> FloatArray:
    """Return noise of variance one with heavy tails, shape (n,): one in twenty has three times the deviation."""
    scale = np.where(draws.uniform(0.0, 1.0, n) < 0.05, 3.0, 1.0)
    return np.asarray(draws.normal(n) * scale / np.sqrt(0.95 + 0.05 * 9.0))
