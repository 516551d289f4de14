"""Evidence for an effect in the final fit: the fit with it compared with the fit of the same model without it."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from scipy.special import chdtrc, ndtri

from ...numerics.arrays import FloatArray, IntArray
from ...numerics.block_regression import block_sums, error_of_sum, regression
from ...numerics.ties import graded
from ..least_squares import density_gains
from ..probing.effect_probing import Screen
from ..thresholds import FINAL_ITERATIONS

#: Number of long stretches in which an effect is judged. Convention.
STRETCHES = 8
#: Gain of left-out blocks, in standard errors, above which an effect that is not called missing is in the tire.
#: Convention, as of the correction of the form.
CERTAIN = 2.0


@dataclass(frozen=True, eq=False)
class Evidence:
    """Evidence for an effect. The probability of the effect decides whether it is named.

    The evidence decides whether the tire has an effect that is not called missing.

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
    p : float
        p-value of its response under coloured noise.
    gains : ndarray, shape (n_blocks,)
        Cross-validated gain of each block of time, as a share of the squared misfit without the effect.
    change : ndarray, shape (n_channels, n)
        Of the forces by the effect alone, N and N m.
    """

    JSON_KEYS: ClassVar = ("z", "stretches", "holdout_gain", "holdout_error")

    z: float
    stretches: int
    holdout_gain: float
    holdout_error: float
    p: float
    gains: FloatArray
    change: FloatArray

    @property
    def gain(self) -> float:
        """The cross-validated gain of all blocks."""
        return float(self.gains.sum())

    @property
    def gain_error(self) -> float:
        """The standard error of `gain`."""
        return error_of_sum(self.gains)


def effect_evidence(after: Screen, coefficients: Collection[str]) -> Evidence:
    """Compare a fit with the fit without an effect.

    `after`: of the model with all effects. `coefficients`: free ones of the effect.
    """
    problem, solution = after.problem, after.solution
    removed = problem.simulator.without(solution.parameters, coefficients)
    screen = without_effect(after, coefficients)
    without = screen.solution
    # In the linear case the change by the effect alone, but right, too, if the other coefficients follow nonlinearly.
    columns = problem.weighted(without.residual - solution.residual)[:, :, None]
    screen.learn_noise([columns])
    response = screen.response(columns)
    size = float(response.estimate[0] / response.error[0]) if np.isfinite(response.error[0]) else 0.0
    z = joint_z(size, len(coefficients))
    edges = _stretches(screen, columns[:, :, 0], z)
    holdout = problem.holdout_gains(without, solution)
    total = float(screen.baseline.loss.sum())
    return Evidence(
        z,
        int(np.sum(screen.losses(edges) > after.losses(edges))),
        float(holdout.sum()),
        error_of_sum(holdout) if len(holdout) > 1 else 0.0,
        float(chdtrc(1, (response.estimate[0] / response.coloured[0]) ** 2)),
        (screen.baseline.loss - after.baseline.loss) / total,
        np.nan_to_num(problem.simulator.forces(solution.parameters) - problem.simulator.forces(removed)),
    )


def unproven(after: Screen, effects: Mapping[str, Collection[str]]) -> list[str]:
    """Return the effects that do not predict left-out blocks better, by more than twice the standard error over blocks.

    One after another, the least certain one first: of two that are in each other's place, one remains. All other
    coefficients follow linearly.

    `after`: of the model with all effects. `effects`: the free coefficients of each of those that are judged.
    """
    problem, parameters, free = after.problem, after.solution.parameters, after.solution.free
    at, absent = problem.simulator.forces(parameters), list[str]()

    def losses(names: Collection[str]) -> FloatArray:
        lost = {coefficient for name in names for coefficient in effects[name]}
        without = problem.simulator.forces(problem.simulator.without(parameters, lost))
        remain = np.array([i for i in range(after.tangent.shape[-1]) if i >= len(free) or free[i] not in lost])
        residual = after.residual + problem.weighted(np.nan_to_num(at - without))
        sums = block_sums(after.tangent[:, :, remain], residual, after.edges)
        return regression(sums, after.prior_precision[remain], after.prior_gradient[remain]).loss

    before = after.baseline.loss
    while remaining := [name for name in effects if name not in absent]:
        tried = {name: losses([*absent, name]) for name in remaining}
        gains = {name: loss - before for name, loss in tried.items()}
        certainty = {name: float(gain.sum()) / max(error_of_sum(gain), 1e-300) for name, gain in gains.items()}
        least = min(remaining, key=lambda name: graded(certainty[name]))
        if certainty[least] > CERTAIN:
            break
        absent, before = [*absent, least], tried[least]
    return absent


def harmful(after: Screen, effects: Mapping[str, Collection[str]]) -> list[str]:
    """Return the effect without which all coefficients find an optimum that predicts all channels better, if any does.

    The predictive density of the fitted rows counts or, if the effect improves it less, that of left-out blocks.
    """
    used = after.problem.inverse_noise > 0.0

    def gain(without: Screen) -> float:
        fits = without, after
        before, now = (fit.solution.residual for fit in fits)
        apart, together = (fit.solution.residual + fit.change_without_block for fit in fits)
        return min(
            float(density_gains(first, second, used, used).sum())
            for first, second in ((before, now), (apart, together))
        )

    gains = {name: gain(without_effect(after, coefficients)) for name, coefficients in effects.items()}
    least = min(gains, key=lambda name: graded(gains[name]))
    return [least] if not gains[least] > 0.0 else []


def without_effect(after: Screen, coefficients: Collection[str]) -> Screen:
    """Return the fit of the same model without an effect."""
    problem, solution = after.problem, after.solution
    removed = problem.simulator.without(solution.parameters, coefficients)
    others = tuple(name for name in solution.free if name not in coefficients)
    return Screen(problem, problem.solve(removed, others, iterations=FINAL_ITERATIONS))


def _stretches(screen: Screen, change: FloatArray, z: float) -> IntArray:
    """Return the edges of the stretches in which an effect with a change of the weighted forces is judged.

    A stretch in which the significance of the effect would be less than one standard deviation says nothing about it.
    If more than a quarter are of that kind, as for an effect that ends soon, they contain equal shares of the effect.
    """
    marks = np.round(np.linspace(0, screen.n_blocks, STRETCHES + 1)).astype(np.int64)
    edges: IntArray = screen.edges[marks]
    evidence = np.cumsum(np.sum(change**2, axis=0))
    shares = np.diff(np.concatenate([[0.0], evidence])[edges]) / max(float(evidence[-1]), 1e-300)
    if np.sum(z**2 * shares > 1.0) >= 0.75 * STRETCHES:
        return edges
    inner = np.searchsorted(evidence, np.linspace(0.0, evidence[-1], STRETCHES + 1)[1:-1]) + 1
    return np.unique(np.concatenate([edges[:1], inner, edges[-1:]]))


def joint_z(size: float, coefficients: int) -> float:
    """Return the significance of several coefficients as standard deviations of a normal distribution.

    `size`: estimate over standard error of the fitted combination of the coefficients.

    >>> round(joint_z(5.0, 1), 6), round(joint_z(5.0, 3), 2)
    (5.0, 4.32)
    """
    if size <= 0.0:
        return 0.0
    p = float(chdtrc(coefficients, size**2))
    return float(-ndtri(p / 2.0)) if p > 0.0 else size  # numbers end at 1e-308
