"""Features of the past: rates of change and memories of the inputs, and the states that resemble them.

The regression of unexplained structure computes rates and memories from a recording at once. A tire needs equations:
a direction of change becomes the hysteresis of a lagged slip, a rate the difference between an input and its lag.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping

import numpy as np
from scipy.ndimage import uniform_filter1d

from ...numerics.arrays import FloatArray
from ...numerics.smoothing import rate_of
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


#: A feature before it has rows: its text, the variables that it depends on, its values at all rows, whether it is odd,
#: and the formula and the states by which an effect file expresses a rate or a memory.
Described = tuple[str, str, FloatArray, bool, str, tuple[str, ...]]


def rates_and_memory(t: FloatArray, named: Mapping[str, FloatArray]) -> Iterator[Described]:
    """Yield features of rates of change and of memory: first-order lags of the inputs.

    `t`, shape (m,), s. `named`, shape (m,): inputs.
    """
    steps = np.diff(t)
    step = float(np.median(steps[steps > 0.0]))
    width = max(3, round(0.1 / step))

    def rate(name: str) -> FloatArray:
        return np.asarray(uniform_filter1d(rate_of(named[name], t), width, mode="nearest"))

    def difference(drive: str, state: str, unit: float) -> tuple[str, tuple[str, ...]]:
        """Return a rate in multiples of a unit as the difference between an input and its lag."""
        return f"{1.0 / (RATE_LAG * unit):.4g}*({drive} - {state})", (state,)

    for slip, odd in (("alpha", True), ("kappa", False)):
        turning = rate(slip)
        typical = 0.3 * float(np.sqrt(np.mean(turning**2))) + 1e-9
        direction, state = np.tanh(turning / typical), f"found_{slip}_direction"
        states = (f"found_followed_{slip}", state)
        if odd:
            unit = 3.3 * typical
            yield "rate of alpha", "dalpha/dt", turning / unit, odd, *difference("alpha", "found_late_alpha", unit)
        yield f"direction of {slip}'s change", f"d{slip}/dt memory", direction, odd, state, states
        signed = direction * np.tanh(named[slip] / SIDE)
        formula = f"{state}*tanh({slip}/{SIDE})"
        yield f"{slip} growing or falling", f"d{slip}/dt memory {slip}", signed, False, formula, states
    pressing = rate("Fz")
    unit = float(np.std(pressing)) + 1e-9
    yield "rate of Fz", "dFz/dt", pressing / unit, False, *difference("Fz", "found_late_load", unit)
    slide = np.abs(np.tan(named["alpha"])) + np.abs(named["kappa"])
    for seconds in (1.0, 5.0):
        name, values = f"found_recent_slip_{seconds:g}", 5.0 * _low_pass(slide, step / seconds)
        yield f"slip of the last {seconds:g} s", "memory alpha kappa", values, False, f"5*{name}", (name,)
    values, name = 5.0 * _low_pass(named["alpha"], step / 0.3), "found_recent_alpha"
    yield "alpha of the last 0.3 s", "dalpha/dt memory", values, True, f"5*{name}", (name,)


def _low_pass(values: FloatArray, share: float) -> FloatArray:
    """Return a signal behind a first-order lag; `share` is the ratio of time step and time constant."""
    decay = float(np.exp(-share))
    return recursion(float(values[0]), np.full(len(values) - 1, decay), (1.0 - decay) * values[1:])
