"""Change of the forces by identified effects over the operating range, compared with the spread among tires."""

from __future__ import annotations

from collections.abc import Collection, Mapping
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
#: Share of the largest relative change of a channel, below which a channel is not compared.
LEAST_SHARE = 0.1


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
    problem: LeastSquares, solution: Solution, effects: Mapping[str, Collection[str]]
) -> dict[str, float]:
    """Return the largest change of a force by each effect, relative to its spread among tires.

    Parameters
    ----------
    problem : LeastSquares
    solution : Solution
        Of the tire with the effects.
    effects : mapping of str to collection of str
        Free coefficients of each effect.

    Returns
    -------
    dict of str to float
        By effect: root mean square change over `operating_points`, divided by that of tires whose coefficients are
        drawn from the prior (`Model.prior_spread`), in the channel in which this ratio is largest. Channels with less
        than a tenth of the effect's change, relative to their own size, are omitted.
    """
    signals = problem.simulator.signals
    points = operating_points(signals)
    simulator = problem.simulator.with_signals(
        replace(signals, inputs=points, rows=np.arange(points.shape[1]), timed=False)
    )
    absent = problem.simulator.tire.parameters()
    forces = simulator.forces(solution.parameters)
    ratios = {}
    for effect, coefficients in effects.items():
        without = solution.parameters.copy()
        indices = [simulator.index[name] for name in coefficients]
        without[indices] = absent[indices]
        start = simulator.forces(without)
        change, spread = _rms(np.nan_to_num(forces - start)), _spread(problem, simulator, without, start, coefficients)
        share = change / np.maximum(_rms(forces), 1e-12)
        acts = (share > LEAST_SHARE * share.max()) & (spread > 0.0)
        if acts.any():
            ratios[effect] = float((change[acts] / spread[acts]).max())
    return ratios


def _spread(
    problem: LeastSquares,
    simulator: Simulator,
    parameters: FloatArray,
    forces: FloatArray,
    coefficients: Collection[str],
) -> FloatArray:
    """Return the root mean square change by an effect over random tires, shape (n_channels,)."""
    names = tuple(coefficients)
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
