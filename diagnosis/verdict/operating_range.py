"""Change of the forces by identified effects over the operating range, compared with the spread among tires."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import replace
from itertools import product

import numpy as np
import numpy.typing as npt

from ..least_squares import LeastSquares, Solution
from ..recording.signals import Signals
from ..recording.simulation import Simulator

FloatArray = npt.NDArray[np.float64]

#: Points along a slip curve, and along each slip of combined slip.
ALONG, COMBINED = 13, 5
#: Random tires from the prior of an effect's coefficients.
TIRES = 16


def operating_points(signals: Signals) -> FloatArray:
    """Return points of the operating range, shape (n_inputs, n).

    Both slips, pure and combined, at three loads; each other input at both ends of its range, with the others at their
    medians. The ranges are those of the recording without the outermost 0.5 % of the rows on each side.

    Parameters
    ----------
    signals : Signals
    """
    named = signals.named()
    median = {name: float(np.median(values)) for name, values in named.items()} | {"kappa": 0.0, "alpha": 0.0}
    ends = {
        name: (float(np.quantile(values, 0.005)), float(np.quantile(values, 0.995))) for name, values in named.items()
    }
    slips = [name for name in ("kappa", "alpha") if name in named]
    curves: list[dict[str, float]] = [
        {name: float(value)} for name in slips for value in np.linspace(ends[name][0], ends[name][1], ALONG)
    ]
    if len(slips) == 2:
        both = product(*(np.linspace(ends[name][0], ends[name][1], COMBINED) for name in ("kappa", "alpha")))
        curves += [{"kappa": float(kappa), "alpha": float(alpha)} for kappa, alpha in both]
    loads = [ends["Fz"][0], median["Fz"], ends["Fz"][1]]
    others: list[dict[str, float]] = [{}]
    for name, (lower, upper) in ends.items():
        if name not in ("kappa", "alpha", "Fz") and upper > lower:
            others += [{name: lower}, {name: upper}]
    points = [{**median, **other, **curve, "Fz": load} for other in others for curve in curves for load in loads]
    return np.array([[point[name] for point in points] for name in signals.names])


def change_over_spread(
    problem: LeastSquares, before: FloatArray, after: Solution, effects: Mapping[str, Collection[str]]
) -> dict[str, float]:
    """Return the change of each channel from one tire to another one, relative to the spread of the effects.

    Parameters
    ----------
    problem : LeastSquares
    before : ndarray, shape (n_parameters,)
        Parameters of the tire without the effects.
    after : Solution
        Of the tire with them.
    effects : mapping of str to collection of str
        Free coefficients of each effect.

    Returns
    -------
    dict of str to float
        By channel: root mean square change over `operating_points`, divided by that of tires whose coefficients are
        drawn from the prior (`Model.prior_spread`). Channels on which no effect acts are omitted.
    """
    signals = problem.simulator.signals
    points = operating_points(signals)
    simulator = problem.simulator.with_signals(
        replace(signals, inputs=points, rows=np.arange(points.shape[1]), timed=False)
    )
    start = simulator.forces(before)
    change = _rms(simulator.forces(after.parameters) - start)
    spread = np.zeros(len(signals.channels))
    for coefficients in effects.values():
        spread += _spread(problem, simulator, before, start, tuple(coefficients)) ** 2
    return {
        name: float(moved / size)
        for name, moved, size in zip(signals.channels, change, np.sqrt(spread), strict=True)
        if size > 1e-9 * max(moved, 1e-9)
    }


def _spread(
    problem: LeastSquares, simulator: Simulator, parameters: FloatArray, forces: FloatArray, names: Sequence[str]
) -> FloatArray:
    """Return the root mean square change by an effect over random tires, shape (n_channels,)."""
    center, deviation = problem.prior(names)
    lower, upper = problem.bounds(names)
    draws = np.random.default_rng(0).standard_normal((TIRES, len(names)))
    squares = np.zeros(len(forces))
    for draw in draws:
        moved = parameters.copy()
        moved[[simulator.index[name] for name in names]] = np.clip(center + deviation * draw, lower, upper)
        squares += _rms(np.nan_to_num(simulator.forces(moved) - forces)) ** 2
    return np.asarray(np.sqrt(squares / TIRES))


def _rms(rows: FloatArray) -> FloatArray:
    return np.asarray(np.sqrt(np.mean(rows**2, axis=1)))
