"""Confirmation of identified effects: the final fit is compared with a fit without each effect.

Compared are the joint significance of the difference between both fits, the number of stretches that improve, the error
on the hold-out set, and cross-talk that only the fit with the effect increases beyond that of a bench. An effect with
states must also exceed the noise of the inputs, which it might filter. Effects that fail are removed, and the search
goes on without them, because another one may explain the same residual.
"""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt
from scipy.special import chdtrc, ndtri

from tirefmu.estimation.block_regression import error_of_sum

from ..least_squares import LeastSquares, Solution
from ..probing.effect_probing import Screen
from ..thresholds import CONFIRMED_Z, MIN_STRETCHES, STRETCHES

FloatArray = npt.NDArray[np.float64]
IntArray = npt.NDArray[np.int64]

#: Probability below which the estimate over its standard error is used as it is: quantiles end at 1e-308.
MIN_P = 1e-260
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
        Number of stretches of the recording (of `STRETCHES`) that the effect predicts better, estimated from the other
        stretches. They are equally long, or contain equal shares of the effect if it acts in few of these.
    holdout_gain, holdout_error : float
        Share of the squared misfit on the hold-out set that the effect removes, and its standard error over blocks.
    compensated : bool
        Whether only the fit with the effect has more cross-talk than a bench: one compensates the other.
    within_noise : bool
        Whether an effect with states changes each force less than the noise of the inputs does. It may then be a filter
        of this noise, which a tire does not follow.
    """

    z: float
    stretches: int
    holdout_gain: float
    holdout_error: float
    compensated: bool
    within_noise: bool

    @property
    def passes(self) -> bool:
        """Whether the effect is significant, in nearly every stretch, no worse on the hold-out set, and plausible.

        The hold-out set has four to eight blocks: an increase of its misfit within one standard error says nothing.
        """
        predicts = self.stretches >= MIN_STRETCHES and self.holdout_gain > -self.holdout_error
        return self.z > CONFIRMED_Z and predicts and not (self.compensated or self.within_noise)

    @property
    def reason_against(self) -> str:
        """Why an effect that does not pass is not confirmed, in a few words."""
        if self.compensated:
            return "cross-talk would compensate it"
        if self.within_noise:
            return "noise of the inputs explains it"
        if self.z <= CONFIRMED_Z:
            return f"{self.z:.1f} standard deviations"
        if self.stretches < MIN_STRETCHES:
            return f"it predicts {self.stretches} of {STRETCHES} stretches better"
        return "it worsens the hold-out set"


def confirmation(
    problem: LeastSquares,
    solution: Solution,
    coefficients: Collection[str],
    absent: FloatArray,
    *,
    has_states: bool = False,
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
    has_states : bool
        Whether the effect has states.

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
    # In the linear case the change by the effect alone, but right, too, if the other coefficients follow nonlinearly.
    columns = problem.weighted(without.residual - solution.residual)[:, :, None]
    screen.learn_noise({0: columns})
    response = screen.response(columns)
    size = float(response.estimate[0] / response.error[0]) if np.isfinite(response.error[0]) else 0.0
    z = joint_z(size, len(indices))
    edges = _stretches(screen, columns[:, :, 0], z)
    holdout = problem.holdout_gains(without, solution)
    gains = screen.stretch_losses(edges) - Screen(problem, solution).stretch_losses(edges)
    return Confirmation(
        z,
        int(np.sum(gains > 0.0)),
        float(holdout.sum()),
        error_of_sum(holdout) if len(holdout) > 1 else 0.0,
        _has_implausible_cross_talk(problem, solution) and not _has_implausible_cross_talk(problem, without),
        has_states and bool(np.all(_rms(change) <= _change_by_noise(problem, solution))),
    )


def _change_by_noise(problem: LeastSquares, solution: Solution) -> FloatArray:
    """Return the root mean square change of each force by the noise of all inputs, shape (n_channels,)."""
    signals, forces = problem.simulator.signals, problem.simulator.forces(solution.parameters)
    squares = np.zeros(len(forces))
    for name, deviation in signals.input_noise.items():
        inputs = signals.inputs + deviation * (np.array(signals.names) == name)[:, None]
        noisy = problem.simulator.with_signals(replace(signals, inputs=inputs))
        squares += _rms(noisy.forces(solution.parameters) - forces) ** 2
    return np.asarray(np.sqrt(squares))


def _rms(rows: FloatArray) -> FloatArray:
    return np.asarray(np.sqrt(np.mean(np.nan_to_num(rows) ** 2, axis=1)))


def _stretches(screen: Screen, change: FloatArray, z: float) -> IntArray:
    """Return the edges of the stretches in which an effect with a change of the weighted forces is judged.

    A stretch in which the significance of the effect would be less than one standard deviation says nothing about it.
    If too many are of that kind, as for an effect that ends soon, the stretches contain equal shares of the effect.
    """
    edges = screen.stretches(STRETCHES)
    evidence = np.cumsum(np.sum(change**2, axis=0))
    shares = np.diff(np.concatenate([[0.0], evidence])[edges]) / max(float(evidence[-1]), 1e-300)
    if np.sum(z**2 * shares > 1.0) >= MIN_STRETCHES:
        return edges
    inner = np.searchsorted(evidence, np.linspace(0.0, evidence[-1], STRETCHES + 1)[1:-1]) + 1
    return np.unique(np.concatenate([edges[:1], inner, edges[-1:]]))


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
    p = float(chdtrc(coefficients, size**2))
    return float(-ndtri(p / 2.0)) if p > MIN_P else size
