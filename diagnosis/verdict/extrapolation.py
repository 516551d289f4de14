"""Extrapolation of the improved model: the measured range of an effect's inputs, and its change outside it."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Mapping
from dataclasses import dataclass, replace
from typing import ClassVar

import numpy as np

from ...drawing.labels import range_text
from ...numerics.arrays import FloatArray
from ...numerics.ties import graded
from ...symbolic.declarations import Quantity
from ..least_squares import LeastSquares
from ..probing.effect_probing import Screen

#: Distance outside an input's range at which an effect is evaluated, as a share of the range and of the distance to the
#: limit of the physical range, and the change of its part of a force, relative to the force, that is reported as
#: doubtful. Convention.
EXTRAPOLATED_SHARE, MAX_CHANGE = 0.5, 0.15

#: Number of rows at which the model is evaluated.
ROWS = 300


@dataclass(frozen=True)
class Extrapolation:
    """The measured range of an input of an identified effect, and the change of the effect outside it.

    - `lower`, `upper`: limits of the range, SI units, without the outermost 0.5 % of the rows on each side.
    - `change`: largest change of the effect's part of a measured channel, as a share of the channel's root mean square,
      if the input is outside the range by half of its width, on either side, and all other inputs are unchanged. Below
      the range, at most half of the distance to the limit of the physical range (`Quantity.lower`).
    - `channel`: the channel with this change.
    """

    JSON_KEYS: ClassVar = ("effect", "input", "lower", "upper", "change", "channel", "doubtful")

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
            f"{self.effect} was measured for {range_text(self.input, self.lower, self.upper)}; outside, up to 50 % of "
            f"this range away, its part of {self.channel} may change by {100.0 * self.change:.0f} % of "
            f"{self.channel}{advice}"
        )


def extrapolations(
    improved: Screen, effects: Mapping[str, Collection[str]], inputs: Mapping[str, Collection[str]]
) -> tuple[Extrapolation, ...]:
    """Return the measured ranges of the inputs of identified effects, and the change of the effects outside them.

    `improved`: of the improved model. `effects`, `inputs`: by identified effect: its free coefficients, and the inputs
    that it depends on. Returns: in the order of the effects; without slips and time, whose range depends on the test
    program.
    """
    problem, solution, signals = improved.problem, improved.solution, improved.signals
    named = signals.named()
    extrapolated = []
    for effect, coefficients in effects.items():
        without = problem.simulator.without(solution.parameters, coefficients)
        for name in inputs[effect]:
            if name not in named or name not in signals.origin.recorded or name in ("t", "alpha", "kappa"):
                continue
            lower, upper = (float(edge) for edge in np.quantile(named[name], [0.005, 0.995]))
            change, channel = _change(problem, (solution.parameters, without), name, lower, upper)
            extrapolated.append(Extrapolation(effect, name, lower, upper, change, channel))
    return tuple(extrapolated)


def _change(
    problem: LeastSquares, tires: tuple[FloatArray, FloatArray], name: str, lower: float, upper: float
) -> tuple[float, str]:
    """Return the largest change of an effect's part of a channel, and the channel; the tires have it and lack it."""
    signals = problem.simulator.signals
    rows = signals.rows[:: max(1, len(signals.rows) // ROWS)]
    index = signals.names.index(name)

    def forces(value: float) -> tuple[FloatArray, FloatArray]:
        inputs = signals.inputs[:, rows].copy()
        inputs[index] = value
        still = replace(signals, inputs=inputs, rows=np.arange(len(rows)), timed=False)
        simulator = problem.simulator.with_signals(still)
        complete = simulator.forces(tires[0])
        return complete, complete - simulator.forces(tires[1])

    worst = np.zeros(len(signals.channels))
    for edge, value in zip(
        (lower, upper), outside(problem.simulator.symbolic_model.inputs, name, lower, upper), strict=True
    ):
        (complete, part), (_, beyond) = forces(edge), forces(value)
        size, moved = (np.sqrt(np.mean(values**2, axis=1)) for values in (complete, beyond - part))
        worst = np.maximum(worst, np.nan_to_num(moved / np.maximum(size, 1e-12)))
    i = int(np.argmax(graded(worst)))
    return float(worst[i]), signals.channels[i]


def outside(quantities: Iterable[Quantity], name: str, lower: float, upper: float) -> tuple[float, float]:
    """Return the values outside a range of an input at which a model is evaluated, within the physical range.

    >>> from tirefmu.symbolic.quantities import GAMMA, V
    >>> outside([GAMMA, V], "gamma", -2.0, 2.0), outside([GAMMA, V], "V", 9.0, 27.0)
    ((-4.0, 4.0), (4.5, 36.0))
    """
    (limit,) = (quantity.lower for quantity in quantities if quantity.name == name)
    margin = EXTRAPOLATED_SHARE * (upper - lower)
    return lower - min(margin, EXTRAPOLATED_SHARE * max(lower - limit, 0.0)), upper + margin
