"""Extrapolation of the improved model: the measured range of an effect's inputs, and the change outside it."""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt

from ..least_squares import LeastSquares, Solution
from ..thresholds import EXTRAPOLATED_SHARE, MAX_CHANGE
from .range_text import range_text

FloatArray = npt.NDArray[np.float64]

#: Number of rows at which the model is evaluated.
ROWS = 300


@dataclass(frozen=True)
class Extrapolation:
    """The measured range of an input of an identified effect, and the change of the forces outside it.

    Attributes
    ----------
    effect, input : str
    lower, upper : float
        Limits of the range, SI units, without the outermost 0.5 % of the rows on each side.
    change : float
        Largest change of a measured channel, as a share of its root mean square, if the input exceeds the range by half
        of its width on either side and all other inputs are unchanged.
    channel : str
        The channel with this change.
    """

    effect: str
    input: str
    lower: float
    upper: float
    change: float
    channel: str

    @property
    def doubtful(self) -> bool:
        """Whether the change is so large that the model should not be used outside the range without measurements."""
        return self.change > MAX_CHANGE

    def __str__(self) -> str:
        advice = "; do not use the model there without measurements" if self.doubtful else ""
        return (
            f"{self.effect} was measured for {range_text(self.input, self.lower, self.upper)}; up to half of "
            f"that range outside, {self.channel} changes by up to {100.0 * self.change:.0f} %{advice}"
        )


def extrapolations(
    problem: LeastSquares, solution: Solution, effects: dict[str, Collection[str]]
) -> tuple[Extrapolation, ...]:
    """Return the measured ranges of the inputs of identified effects, and the change of the forces outside them.

    Parameters
    ----------
    problem : LeastSquares
    solution : Solution
        Of the improved model.
    effects : dict of str to collection of str
        By identified effect: the inputs that it depends on.

    Returns
    -------
    tuple of Extrapolation
        In the order of the effects; without slips and time, whose range depends on the test program.
    """
    signals = problem.simulator.signals
    named = signals.named()
    extrapolated = []
    for effect, inputs in effects.items():
        for name in inputs:
            if name not in named or name not in signals.recorded or name in ("t", "alpha", "kappa"):
                continue
            lower, upper = (float(edge) for edge in np.quantile(named[name], [0.005, 0.995]))
            change, channel = _change(problem, solution, name, lower, upper)
            extrapolated.append(Extrapolation(effect, name, lower, upper, change, channel))
    return tuple(extrapolated)


def _change(problem: LeastSquares, solution: Solution, name: str, lower: float, upper: float) -> tuple[float, str]:
    signals = problem.simulator.signals
    rows = signals.rows[:: max(1, len(signals.rows) // ROWS)]
    index = signals.names.index(name)

    def forces(value: float) -> FloatArray:
        inputs = signals.inputs[:, rows].copy()
        inputs[index] = value
        still = replace(signals, inputs=inputs, rows=np.arange(len(rows)), timed=False)
        return problem.simulator.with_signals(still).forces(solution.parameters)

    margin = EXTRAPOLATED_SHARE * (upper - lower)
    least = 0.0 if name in ("Fz", "p") else -np.inf
    worst = np.zeros(len(signals.channels))
    for edge, value in ((lower, max(lower - margin, least)), (upper, upper + margin)):
        inside, beyond = forces(edge), forces(value)
        if name == "Fz":  # forces grow with load: compare force per load
            inside, beyond = inside / max(edge, 1.0), beyond / max(value, 1.0)
        size = np.sqrt(np.mean(inside**2, axis=1))
        moved = np.sqrt(np.mean((beyond - inside) ** 2, axis=1))
        worst = np.maximum(worst, np.nan_to_num(moved / np.maximum(size, 1e-12)))
    i = int(np.argmax(worst))
    return float(worst[i]), signals.channels[i]
