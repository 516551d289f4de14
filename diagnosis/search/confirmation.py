"""Confirmation of identified effects: the final fit is compared with a fit without each effect."""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt
from scipy import stats

from ..least_squares import LeastSquares, Solution
from ..probing.effect_probing import Screen
from ..thresholds import CONFIRMED_STRETCHES, CONFIRMED_Z, MIN_HOLDOUT_GAIN, STRETCHES

FloatArray = npt.NDArray[np.float64]

#: Iterations of the fit without an effect.
ITERATIONS = 6


@dataclass(frozen=True)
class Confirmation:
    """Evidence for an identified effect: the final fit compared with the fit of the same model without the effect.

    Attributes
    ----------
    z : float
        Joint significance of all coefficients of the effect under coloured noise and over blocks of time, as the number
        of standard deviations of a normal distribution with the same p-value.
    stretches : int
        Number of long stretches of the recording (of `STRETCHES`) that the effect predicts better, estimated from the
        other stretches.
    holdout_gain : float
        Share of the squared misfit on the hold-out set that the effect removes.
    compensated : bool
        Whether only the fit with the effect has more cross-talk than a bench: one compensates the other.
    """

    z: float
    stretches: int
    holdout_gain: float
    compensated: bool

    @property
    def passes(self) -> bool:
        """Whether the effect is significant, in nearly every stretch, no worse on the hold-out set, and plausible."""
        predicts = self.stretches >= CONFIRMED_STRETCHES and self.holdout_gain > MIN_HOLDOUT_GAIN
        return self.z > CONFIRMED_Z and predicts and not self.compensated


def confirmation(
    problem: LeastSquares, solution: Solution, coefficients: Collection[str], absent: FloatArray
) -> Confirmation:
    """Compare a fit with the fit without an effect.

    Parameters
    ----------
    problem : LeastSquares
    solution : Solution
        Of the model with all identified effects.
    coefficients : collection of str
        Free coefficients of the effect.
    absent : ndarray, shape (n_parameters,)
        Parameters without the effect; only the values of `coefficients` are used.

    Returns
    -------
    Confirmation
    """
    indices = [problem.simulator.index[name] for name in coefficients]
    removed = solution.parameters.copy()
    removed[indices] = absent[indices]
    others = tuple(name for name in solution.free if name not in coefficients)
    without = problem.solve(removed, others, iterations=ITERATIONS)
    screen = Screen(problem, without)
    change = problem.simulator.forces(solution.parameters) - problem.simulator.forces(removed)
    columns = problem.weighted(np.nan_to_num(change))[:, :, None]
    screen.learn_noise({0: columns})
    response = screen.response(columns)
    size = float(response.estimate[0] / response.error[0]) if np.isfinite(response.error[0]) else 0.0
    gains = screen.stretch_losses(STRETCHES) - Screen(problem, solution).stretch_losses(STRETCHES)
    return Confirmation(
        joint_z(size, len(indices)),
        int(np.sum(gains > 0.0)),
        problem.holdout_gain(without, solution),
        _has_implausible_cross_talk(problem, solution) and not _has_implausible_cross_talk(problem, without),
    )


def _has_implausible_cross_talk(problem: LeastSquares, solution: Solution) -> bool:
    return bool(problem.disturbances.implausible(solution.disturbance))


def joint_z(size: float, coefficients: int) -> float:
    """Return the significance of several coefficients as standard deviations of a normal distribution.

    Parameters
    ----------
    size : float
        Estimate over standard error of the fitted combination of the coefficients.
    coefficients : int

    Examples
    --------
    >>> round(joint_z(5.0, 1), 6), round(joint_z(5.0, 3), 2)
    (5.0, 4.32)
    """
    if size <= 0.0:
        return 0.0
    log_p = float(stats.chi2.logsf(size**2, coefficients))
    return float(-stats.norm.ppf(np.exp(log_p) / 2.0)) if log_p > -600.0 else size
