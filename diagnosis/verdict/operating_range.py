"""Changes by identified effects over the operating range that a recording does not determine."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import replace
from itertools import product

import numpy as np
import numpy.typing as npt

from ..probing.effect_probing import Screen
from ..recording.signals import Signals
from ..recording.simulation import Simulator
from ..thresholds import MAX_UNCERTAINTY

FloatArray = npt.NDArray[np.float64]

#: Points along a slip curve, and along each slip of combined slip.
ALONG, COMBINED = 13, 5
#: Number of random tires.
TIRES = 16
#: Spread among tires, as a share of a force, below which an effect is taken not to act on it.
MIN_SHARE = 0.002


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


def undetermined_change(whitened: Screen, effects: Mapping[str, Collection[str]]) -> dict[str, float]:
    """Return the changes by effects over the operating range that a recording does not determine.

    Parameters
    ----------
    whitened : Screen
        Of the tire with the effects; its normal matrix gives the covariance of the coefficients.
    effects : mapping of str to collection of str
        Free coefficients of each effect.

    Returns
    -------
    dict of str to float
        By effect: root mean square change of a force over `operating_points`, relative to the effect's spread among
        tires (`Model.prior_spread`), in the channel in which this ratio is largest. Only channels that the recording
        does not determine: the standard deviation over random tires from the posterior distribution of the coefficients
        exceeds `MAX_UNCERTAINTY` of that from their prior.
    """
    problem, solution = whitened.problem, whitened.solution
    signals = problem.simulator.signals
    points = operating_points(signals)
    simulator = problem.simulator.with_signals(
        replace(signals, inputs=points, rows=np.arange(points.shape[1]), timed=False)
    )
    forces, absent = simulator.forces(solution.parameters), simulator.tire.parameters()
    ratios = {}
    for effect, coefficients in effects.items():
        names = tuple(coefficients)
        own = [solution.free.index(name) for name in names]
        indices = [simulator.index[name] for name in names]
        center, deviation = problem.prior(names)
        bounds = problem.bounds(names)
        covariance = whitened.baseline.inverse[np.ix_(own, own)]
        both = (
            _spread(simulator, solution.parameters, indices, mean, matrix, bounds)
            for mean, matrix in ((solution.parameters[indices], covariance), (center, np.diag(deviation**2)))
        )
        posterior, prior = both
        without = solution.parameters.copy()
        without[indices] = absent[indices]
        change = _rms(np.nan_to_num(forces - simulator.forces(without)))
        undetermined = (prior > MIN_SHARE * _rms(forces)) & (posterior > MAX_UNCERTAINTY * prior)
        if undetermined.any():
            ratios[effect] = float((change[undetermined] / prior[undetermined]).max())
    return ratios


def _spread(
    simulator: Simulator, parameters: FloatArray, indices: Sequence[int], mean: FloatArray, covariance: FloatArray,
    bounds: tuple[FloatArray, FloatArray],
) -> FloatArray:  # fmt: skip
    """Return the standard deviation of each force over random tires, shape (n_channels,)."""
    draws = np.random.default_rng(0).multivariate_normal(mean, covariance, TIRES, method="eigh")
    forces = []
    for draw in draws:
        moved = parameters.copy()
        moved[list(indices)] = np.clip(draw, *bounds)
        forces.append(np.nan_to_num(simulator.forces(moved)))
    return np.asarray(np.sqrt(np.mean(np.var(np.stack(forces), axis=0), axis=-1)))


def _rms(rows: FloatArray) -> FloatArray:
    return np.asarray(np.sqrt(np.mean(rows**2, axis=1)))
