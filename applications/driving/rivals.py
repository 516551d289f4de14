"""Explanations of a drive compared: changed factors of the tires, a wrong entry of the car, an effect that tires lack.

With an effect or without one, the whole drive is estimated; the coefficients of the effect are unknowns like the
factors of the tires. The evidence of an estimate integrates over the motion, the car, the factors and these
coefficients, with the unexplained force that it needs. Residuals that are correlated over time count as fewer. Within
an estimate, which factors changed, and at most one wrong entry of the car, are compared by the Gaussian of the
estimate: a prior gives a changed factor the spread of factors, a wrong entry a multiple of its uncertainty (MacKay,
Information Theory, Inference, and Learning Algorithms, 2003, chapter 28).
"""

from __future__ import annotations

import itertools
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt

from ...numerics.correlation import correlation_length
from ...numerics.ties import graded
from ...tires import Tire
from .effects import Missing, Motion, effect_columns, factor_values, motion_of, scaled
from .estimate import Estimate, Forces
from .inputs.car import Car
from .inputs.grid import Grid
from .inputs.unknowns import AXLES, CHANGED, LATERAL, Unknowns
from .interval import BALANCE, MOTION, Added

FloatArray = npt.NDArray[np.float64]

#: Odds that an entry of the car is wrong, and that the tires lack an effect; how many times its uncertainty a wrong
#: entry has. Judgement: most numbers of a car are right.
ODDS, WRONG_SPREAD = 0.05, 10.0
#: Factor of the prior odds of an effect for each coefficient after the first. Judgement: of effects that a drive does
#: not separate, the simpler one is the more likely.
FURTHER = 0.5
#: Posterior probability at which a change of a tire, a wrong entry of the car or an effect is a finding.
CERTAIN = 0.95
#: Effects that are compared by an estimate of their own. Convention: computing time.
COMPARED = 4
#: Error of the form of a tire over its side force. Judgement: a Magic Formula differs from bench data by about 1 %, of
#: which its factors and the car take the larger part.
FORM_ERROR = 0.003
#: Steps for derivatives: of an unknown in its standard deviations, of a slip angle in rad.
STEP, SLIP_STEP = 0.02, 1e-4
#: Gives the grid and the estimate with the forces of an effect.
Refit = Callable[[Forces], tuple[Grid, Estimate]]


@dataclass(frozen=True)
class Probabilities:
    """Posterior probabilities: of changed factors by axle and name, of wrong entries of the car.

    `wrong_car`: logarithm by which the evidence of an estimate grows if an entry of the car may be wrong.
    """

    factors: dict[tuple[str, str], float]
    car: dict[str, float]
    wrong_car: float


def probabilities_of(grid: Grid, estimate: Estimate, unknowns: Unknowns) -> Probabilities:
    """Return the probabilities over all explanations."""
    lateral = [pair for pair in unknowns.factors if pair[1] in LATERAL]
    places = [unknowns.factor(*pair) for pair in lateral]
    information, score = estimate.information(grid, np.zeros((len(grid.t), 2, 0)))
    changed = np.array(list(itertools.product((False, True), repeat=len(places))))
    logs = np.empty((len(changed), 1 + len(unknowns.car)))
    for row, some in enumerate(changed):
        for column in range(logs.shape[1]):
            spread = np.ones(len(estimate.z))
            spread[places] = some
            if column:
                spread[column - 1] = WRONG_SPREAD
            logs[row, column] = (np.log(ODDS) if column else 0.0) + evidence_of(information, score, spread)
        logs[row] += np.log(np.where(some, CHANGED, 1.0 - CHANGED)).sum()
    share = np.exp(logs - logs.max())
    share /= share.sum()
    return Probabilities(
        {pair: float(share[changed[:, i]].sum()) for i, pair in enumerate(lateral)},
        dict(zip(unknowns.car, share[:, 1:].sum(axis=0).tolist(), strict=True)),
        float(-np.log(max(share[:, 0].sum(), 1e-300))),
    )


def evidence_of(information: FloatArray, score: FloatArray, spread: FloatArray) -> float:
    """Return the logarithm of the evidence for a prior with standard deviations `spread`, up to a constant."""
    free = np.flatnonzero(spread)
    spread = spread[free]
    scaled = np.eye(len(free)) + spread[:, None] * information[np.ix_(free, free)] * spread[None, :]
    whole = spread * score[free]
    return float(whole @ np.linalg.solve(scaled, whole) - np.linalg.slogdet(scaled)[1]) / 2


@dataclass(frozen=True)
class Explanation:
    """An estimate with an effect, or without one: `missing` is None."""

    missing: Missing | None
    grid: Grid
    estimate: Estimate
    probability: float = 0.0


def explanations(
    base: Explanation, unknowns: Unknowns, car: Car, tires: dict[str, Tire], refit: Refit
) -> list[Explanation]:
    """Return the estimate without an effect and those with the most likely ones, with their probabilities.

    Likely ones first.
    """
    if not base.estimate.converged:
        return [replace(base, probability=1.0)]
    compared, powers = [base], [1.0]
    for missing, power in _shortlist(base, unknowns, car, tires):
        try:
            explanation = Explanation(missing, *refit(_forces(missing, unknowns, car, base)))
        except np.linalg.LinAlgError:
            continue
        if explanation.estimate.converged:
            compared.append(explanation)
            powers.append(power)
    logs = np.array([_evidence(explanation, unknowns) for explanation in compared])
    # All rivals are compared under one likelihood, that of the best one.
    first = int(np.argmax(graded(logs)))
    best = compared[first]
    residuals = best.estimate.residuals.values[:, -len(BALANCE) :].T
    length = np.mean([correlation_length(row, best.grid.segment) for row in residuals])
    logs = (logs - logs[0]) * powers[first] / length + [_log_prior(explanation.missing) for explanation in compared]
    share = np.exp(logs - logs.max())
    ranked = zip(compared, share / share.sum(), strict=True)
    return sorted(
        (replace(explanation, probability=float(p)) for explanation, p in ranked),
        key=lambda explanation: -graded(explanation.probability),
    )


def answer_of(ranked: Sequence[Explanation], unknowns: Unknowns) -> Explanation:
    """Return the explanation that is the answer: with the most probable effect, or without one.

    An effect is no answer if an entry of the car contradicts its file beside it: the model of the car lacks something.
    """
    first, without = ranked[0], next(explanation for explanation in ranked if not explanation.missing)
    if lacking(ranked) <= CERTAIN:
        return without
    wrong = probabilities_of(first.grid, first.estimate, unknowns).car.values()
    return without if max(wrong, default=0.0) > CERTAIN else first


def lacking(ranked: Sequence[Explanation]) -> float:
    """Return the probability that the tires lack an effect of the library."""
    return sum(explanation.probability for explanation in ranked if explanation.missing)


def _log_prior(missing: Missing | None) -> float:
    return float(np.log(ODDS) + (len(missing.center) - 1) * np.log(FURTHER)) if missing else 0.0


def _evidence(explanation: Explanation, unknowns: Unknowns) -> float:
    estimate = explanation.estimate
    return estimate.evidence + probabilities_of(explanation.grid, estimate, unknowns).wrong_car


def _forces(missing: Missing, unknowns: Unknowns, car: Car, base: Explanation) -> Forces:
    """Return the forces of an effect about the motion, the factors and the coefficients that are estimated so far."""
    n, further = len(unknowns), len(missing.center)

    def forces(grid: Grid, states: FloatArray, z: FloatArray) -> Added:
        z = np.concatenate([z[:n], z[n:] if len(z) > n else np.zeros(further)])
        motion = motion_of(grid, replace(base.estimate, states=states, z=z), unknowns, car)

        def added(z: FloatArray, motion: Motion = motion) -> FloatArray:
            return missing.side_forces(motion, z[n:], factor_values(unknowns, z))

        at, last = added(z), len(unknowns.factors) + further
        columns = np.zeros((*at.shape, last))
        for name in LATERAL:  # of both axles at a time
            places = [unknowns.factor(axle, name) for axle in AXLES]
            change = (added(z + STEP * np.isin(np.arange(len(z)), places)) - at) / STEP
            for axle, place in enumerate(places):
                columns[:, axle, place - len(z)] = change[:, axle]
        for i in range(n, n + further):
            columns[:, :, i - len(z)] = (added(z + STEP * (np.arange(len(z)) == i)) - at) / STEP
        turned = {**motion.inputs, "alpha": motion.inputs["alpha"] + SLIP_STEP}
        by_slip = (added(z, replace(motion, inputs=turned)) - at) / SLIP_STEP
        p = unknowns.car_values(car, z)
        middle = (states[grid.left] + states[grid.right])[:, : len(MOTION)] / 2
        ahead = np.array([p["cg_to_front"], -p["cg_to_rear"]])
        slopes = np.stack([0.0 * by_slip, by_slip, by_slip * ahead], axis=2) / middle[:, :1, None]
        offset = at - columns @ z[len(z) - last :] - np.einsum("kim,km->ki", slopes, middle)
        return Added(offset, columns, slopes, further)

    return forces


def _shortlist(base: Explanation, unknowns: Unknowns, car: Car, tires: dict[str, Tire]) -> list[tuple[Missing, float]]:
    """Return the effects that raise the evidence of the linearized estimate most, if any do, in their best form.

    With each the power of its likelihood: no formula is exact, and the information of a log on an error of the form
    grows with its length (Miller and Dunson, Robust Bayesian inference via coarsening, JASA 114, 2019). The error has
    the shape of the effect; what the car and the factors explain of it does not count.
    """
    factors = factor_values(unknowns, base.estimate.z)
    motion = motion_of(base.grid, base.estimate, unknowns, car)
    columns = effect_columns(motion, tires, factors)
    if not columns:
        return []
    forces = np.stack([column for _, column in columns], axis=2)
    information, score = base.estimate.information(base.grid, forces)
    n = len(base.estimate.z)
    without = evidence_of(information, score, np.repeat([1.0, 0.0], [n, len(columns)]))
    by_car = np.linalg.solve(information[:n, :n] + np.eye(n), information[:n, n:])
    alone = np.diag(information[n:, n:]) - np.sum(information[:n, n:] * by_car, axis=0)
    of_tires = motion.side_forces({axle: scaled(tire, factors[axle]) for axle, tire in tires.items()})
    errors = FORM_ERROR**2 * np.mean(of_tires**2) / np.mean(forces**2, axis=(0, 1))
    powers = 1.0 / (1.0 + errors * alone / 2)
    gains = dict[str, tuple[float, Missing, float]]()
    for i, (missing, _) in enumerate(columns):
        spread = np.concatenate([np.ones(n), np.arange(len(columns)) == i])
        gain = powers[i] * (evidence_of(information, score, spread) - without)
        if gain > gains.get(missing.name, (0.0,))[0]:
            gains[missing.name] = gain, missing, powers[i]
    ranked = sorted(gains.values(), key=lambda entry: -graded(entry[0]))[:COMPARED]
    return [(missing, power) for _, missing, power in ranked]
