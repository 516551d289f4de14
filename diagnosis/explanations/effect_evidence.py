"""Evidence for an effect in a tire: the fit with it compared with the fit without it, or with a rival in its place.

The comparison has one noise and errors of all forms, of which a tire has none: where both decide differently between
two confounded effects, the recording does not decide. The tire then has the one that certainly predicts better.
"""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from scipy.special import chdtrc, ndtri

from ...numerics.arrays import FloatArray, IntArray
from ...numerics.block_regression import error_of_sum
from ...numerics.ties import graded
from ..least_squares import LeastSquares, Solution, density_gains
from ..probing.effect_probing import Screen
from ..thresholds import CONFOUNDED
from .additions import in_place_of
from .answer import NAMED, Answer
from .explanation import UNKNOWN, in_order
from .linearization import Addition
from .refit import Refitted, fitted_as_tire
from .table import Table

#: Number of long stretches in which an effect is judged. Convention.
STRETCHES = 8
#: Gain of the stretches, in standard errors, above which an effect is in the tire and may be called missing.
#: Convention, as of the correction of the form.
CERTAIN = 2.0
#: Share of what an effect explains by which the fit without it may still fall. Convention: a tenth of a standard error
#: of a gain of ten of them.
EXACT = 0.01


@dataclass(frozen=True, eq=False)
class Evidence:
    """Evidence for an effect of the tire. Its probability decides whether it is called missing.

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
    (response,) = screen.responses([columns])
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


def proof_of(after: Screen, coefficients: Collection[str]) -> float:
    """Return how well the recording proves an effect: all channels together, by predictive density.

    Compared with the optimum without the effect. The result is the gain over `STRETCHES` parts of the recording, each
    with an equal share of the effect, in its standard errors; 0 at most if left-out blocks, predicted from the others,
    are not better with the effect.

    `after`: of the model with all effects. `coefficients`: free ones of the effect.
    """
    return proof_over(after, without_effect(after, coefficients))


def proof_over(after: Screen, without: Screen) -> float:
    """Return how well the recording proves one fit over another one: `proof_of` with these two."""
    used = after.problem.inverse_noise > 0.0
    before, now = without.solution.residual, after.solution.residual
    apart, together = (screen.solution.residual + screen.change_without_block for screen in (without, after))
    change = after.problem.weighted(before - now)
    begins = _equal_shares(np.cumsum(np.sum(change**2, axis=0)))[:-1]
    gains = np.add.reduceat(density_gains(before, now, used, used).sum(axis=0), begins)
    proven = float(gains.sum()) / max(error_of_sum(gains), 1e-300) if len(gains) > 1 else 0.0
    return proven if density_gains(apart, together, used, used).sum() > 0.0 else min(proven, 0.0)


def with_rivals(
    answer: Answer, leader: Refitted, table: Table, problem: LeastSquares, baseline: Solution
) -> tuple[Answer, Refitted]:
    """Return answer and leader in which a tire with an effect predicts better than one with a rival in its place.

    `problem`, `baseline`: of the baseline model, without discrepancies.
    """
    paired = set[str]()
    for name in [name for name, probability in answer.probabilities.items() if probability >= NAMED]:
        pair = None if name in paired else rival_of(name, table, paired)
        if pair is None:
            continue
        (rival,) = set(pair[1].explanation.parts).difference(pair[0].explanation.parts)
        fits = (fitted_as_tire(problem, refit.linear, baseline, refit.linear.solution.free) for refit in pair)
        proof = proof_over(*(Screen(*fit) for fit in fits))
        paired |= {name, rival}
        if proof <= CERTAIN:
            answer = answer.with_rival(name, rival, better=proof >= -CERTAIN)
        exchanged = in_order({*leader.explanation.parts, rival}.difference([name]))
        if proof < -CERTAIN:
            leader = table.refits.get(exchanged, pair[1])
    return answer, leader


def rival_of(effect: str, table: Table, paired: Collection[str]) -> tuple[Refitted, Refitted] | None:
    """Return the most probable refit with an effect, and the best one with a confounded effect in its place.

    The other one explains, beside the same others, at least half of what the effect does. Not those `paired` before.
    None if there is none.
    """
    divided, scores = table.divided(), table.scores
    able = [parts for parts in table.refits if effect in parts]
    refit = table.refits[max(able, key=lambda parts: graded(divided[parts]))] if able else None
    if not refit or (rest := refit.explanation.without(effect).parts) not in scores:
        return None
    rivals = [
        other
        for parts, other in table.refits.items()
        if len(parts) == len(rest) + 1
        and set(rest) < set(parts)
        and not {effect, UNKNOWN, *paired}.difference(rest).intersection(parts)
        and other.score > 0.5 * (refit.score + scores[rest])
    ]
    ordered = sorted(rivals, key=lambda other: -graded(other.score))
    return next(((refit, other) for other in ordered if alike(effect, refit, other) > CONFOUNDED), None)


def alike(effect: str, refit: Refitted, other: Refitted) -> float:
    """Return the correlation of an effect with the one that another refit has in its place."""
    (rival,) = set(other.explanation.parts).difference(refit.explanation.parts)
    addition = Addition(rival, other.linear.responses.of(rival)[:, :, None], np.ones(1))
    columns = in_place_of(effect, refit.linear, [addition])
    return float(columns.correlations(columns.groups[1])[0])


def without_effect(after: Screen, coefficients: Collection[str]) -> Screen:
    """Return the fit of the same model without an effect, the more exact the less the effect explains."""
    problem, solution = after.problem, after.solution
    removed = problem.simulator.without(solution.parameters, coefficients)
    others = tuple(name for name in solution.free if name not in coefficients)
    least = solution.cost
    return Screen(problem, problem.solve(removed, others, tolerance=EXACT, above=least))


def _stretches(screen: Screen, change: FloatArray, z: float) -> IntArray:
    """Return the edges of the stretches in which an effect with a change of the weighted forces is judged.

    A stretch in which the significance of the effect would be less than one standard deviation states nothing about it.
    If more than a quarter are of that kind, as for an effect that ends soon, they contain equal shares of the effect.
    """
    marks = np.round(np.linspace(0, screen.n_blocks, STRETCHES + 1)).astype(np.int64)
    edges: IntArray = screen.edges[marks]
    evidence = np.cumsum(np.sum(change**2, axis=0))
    shares = np.diff(np.concatenate([[0.0], evidence])[edges]) / max(float(evidence[-1]), 1e-300)
    if np.sum(z**2 * shares > 1.0) >= 0.75 * STRETCHES:
        return edges
    return _equal_shares(evidence)


def _equal_shares(evidence: FloatArray) -> IntArray:
    """Return the edges of `STRETCHES` parts with equal shares of what is summed up over the rows."""
    inner = np.searchsorted(evidence, np.linspace(0.0, evidence[-1], STRETCHES + 1)[1:-1]) + 1
    return np.unique(np.concatenate([[0], inner, [len(evidence)]]).clip(max=len(evidence))).astype(np.int64)


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
