"""Features of the past: rates of change and memories of the inputs, and the states that resemble them.

The regression of unexplained structure computes rates and memories from a recording at once. A tire needs equations:
a direction of change becomes the hysteresis of a lagged slip, a rate the difference between an input and its lag.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Protocol

import numpy as np
from scipy.ndimage import uniform_filter1d

from ...numerics.arrays import FloatArray
from ...tires.states.transient import recursion
from ..thresholds import SIDE

#: Time constant of the lag whose difference from its input replaces a rate, s.
RATE_LAG = 0.1
#: The states of proposed effects by name, which no effect of the library has: the keys of their tables in an effect
#: file. Each stands behind those that it reads.
#: Length and widths are those with which a diagnosis starts the effects of the library.
STATES: Mapping[str, Mapping[str, str | tuple[str, ...]]] = {
    "found_followed_kappa": {"kind": "lag", "drive": "kappa", "length": "0.05"},
    "found_followed_alpha": {"kind": "lag", "drive": "tan(alpha)", "length": "0.05"},
    "found_alpha_direction": {"kind": "hysteresis", "drive": "found_followed_alpha", "width": "0.02"},
    "found_kappa_direction": {"kind": "hysteresis", "drive": "found_followed_kappa", "width": "0.02"},
    "found_recent_alpha": {"kind": "lag", "drive": "alpha", "rate": "1/0.3"},
    "found_late_alpha": {"kind": "lag", "drive": "alpha", "rate": f"1/{RATE_LAG}"},
    "found_late_load": {"kind": "lag", "drive": "Fz", "rate": f"1/{RATE_LAG}"},
    "found_recent_slip_1": {"kind": "lag", "drive": "absolute(tan(alpha)) + absolute(kappa)", "rate": "1.0"},
    "found_recent_slip_5": {"kind": "lag", "drive": "absolute(tan(alpha)) + absolute(kappa)", "rate": "0.2"},
}


@dataclass(frozen=True)
class Past:
    """How an effect file expresses a rate or a memory.

    - `formula`: reads `states`.
    - `states`: names in `STATES`, with those that they read.
    """

    formula: str
    states: tuple[str, ...]


class Adding(Protocol):
    """Adds a feature."""

    def __call__(
        self, text: str, depends: str, values: FloatArray, *, odd: bool = False, past: Past | None = None
    ) -> None:
        """Add a feature with its text, the variables it depends on, and its values at all rows."""


def add_rates_and_memory(add: Adding, t: FloatArray, named: Mapping[str, FloatArray]) -> None:
    """Add features of rates of change and of memory: first-order lags of the inputs.

    `t`, shape (m,), s. `named`, shape (m,): inputs.
    """
    steps = np.diff(t)
    step = float(np.median(steps[steps > 0.0]))
    width = max(3, round(0.1 / step))

    def rate(name: str) -> FloatArray:
        with np.errstate(divide="ignore", invalid="ignore"):
            slope = np.gradient(named[name], t)
        usable = np.where(np.isfinite(slope), slope, 0.0)
        return np.asarray(uniform_filter1d(usable, width, mode="nearest"))

    turning = rate("alpha")
    typical = 0.3 * float(np.sqrt(np.mean(turning**2))) + 1e-9
    add("rate of alpha", "dalpha/dt", turning / (3.3 * typical), odd=True,
        past=_difference("alpha", "found_late_alpha", 3.3 * typical))  # fmt: skip
    add("direction of alpha's change", "dalpha/dt memory", np.tanh(turning / typical), odd=True,
        past=Past("found_alpha_direction", ("found_followed_alpha", "found_alpha_direction")))  # fmt: skip
    loading = np.tanh(turning / typical) * np.tanh(named["alpha"] / SIDE)
    add("alpha growing or falling", "dalpha/dt memory alpha", loading, past=_signed("alpha"))
    changing = rate("kappa")
    typical = 0.3 * float(np.sqrt(np.mean(changing**2))) + 1e-9
    add("direction of kappa's change", "dkappa/dt memory", np.tanh(changing / typical),
        past=Past("found_kappa_direction", ("found_followed_kappa", "found_kappa_direction")))  # fmt: skip
    add("kappa growing or falling", "dkappa/dt memory kappa",
        np.tanh(changing / typical) * np.tanh(named["kappa"] / SIDE), past=_signed("kappa"))  # fmt: skip
    pressing = rate("Fz")
    typical = float(np.std(pressing)) + 1e-9
    add("rate of Fz", "dFz/dt", pressing / typical, past=_difference("Fz", "found_late_load", typical))
    for seconds in (1.0, 5.0):
        slide = np.abs(np.tan(named["alpha"])) + np.abs(named["kappa"])
        name = f"found_recent_slip_{seconds:g}"
        add(f"slip of the last {seconds:g} s", "memory alpha kappa",
            5.0 * _low_pass(slide, step / seconds), past=Past(f"5*{name}", (name,)))  # fmt: skip
    add("alpha of the last 0.3 s", "dalpha/dt memory", 5.0 * _low_pass(named["alpha"], step / 0.3), odd=True,
        past=Past("5*found_recent_alpha", ("found_recent_alpha",)))  # fmt: skip


def _signed(slip: str) -> Past:
    """Return whether a slip grows or falls: the direction of its change, and its sign."""
    state = f"found_{slip}_direction"
    return Past(f"{state}*tanh({slip}/{SIDE})", (f"found_followed_{slip}", state))


def _difference(drive: str, state: str, unit: float) -> Past:
    """Return a rate in multiples of a unit as the difference between an input and its lag."""
    return Past(f"{1.0 / (RATE_LAG * unit):.4g}*({drive} - {state})", (state,))


def _low_pass(values: FloatArray, share: float) -> FloatArray:
    """Return a signal behind a first-order lag; `share` is the ratio of time step and time constant."""
    decay = float(np.exp(-share))
    return recursion(float(values[0]), np.full(len(values) - 1, decay), (1.0 - decay) * values[1:])
