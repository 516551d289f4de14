"""Explanations of a drive compared: changed factors of the tires, a wrong entry of the car, an effect that tires lack.

All are compared by the Gaussian of the estimate of the whole drive, in which the discrepancy of the car has its part:
the coefficients of an effect join the unknowns, and its forces are linearized about them in some rounds. The evidence
integrates over the motion, the car, its discrepancy, the factors and these coefficients. Residuals that are correlated
over time count as fewer. For which factors changed, and at most one wrong entry of the car, a prior gives a changed
factor one of several spreads, another one that of equal tires, and a wrong entry a multiple of its uncertainty (MacKay,
Information Theory, Inference, and Learning Algorithms, 2003, chapter 28). One wide spread for all changes would call a
small one improbable however certain it is (Lindley, Biometrika 44, 1957).
"""

from __future__ import annotations

import itertools
from collections.abc import Callable, Mapping, Sequence
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
from .inputs.unknowns import AXLES, CHANGED, CHANGES, FACTOR_SPREAD, FACTORS, SAME, Unknowns
from .interval import BALANCE, MOTION
from .linear import AddedForces
from .trust.contradiction import is_agreement

FloatArray = npt.NDArray[np.float64]
IntArray = npt.NDArray[np.intp]

#: Odds that an entry of the car is wrong, and that the tires lack an effect; how many times its uncertainty a wrong
#: entry has. Judgement: most numbers of a car are right.
ODDS, WRONG_SPREAD = 0.05, 10.0
#: Factor of the prior odds of an effect for each coefficient after the first. Judgement: of effects that a drive does
#: not separate, the simpler one is the more likely.
FURTHER = 0.5
#: Effects whose coefficients are estimated, rounds of that, and a change of a standardized coefficient that ends them.
#: Convention: computing time.
COMPARED, FITTED, SMALL_CHANGE = 4, 4, 0.1
#: Probability from which the whole drive is estimated with an effect, and it is reported. Coefficients are estimated if
#: twice the gain before that can reach it.
LIKELY = 0.05
LIKELY_ODDS = float(np.log(LIKELY / (1.0 - LIKELY)))
#: Error of the form of a tire over its side force. Judgement: a Magic Formula differs from bench data by about 1 %, of
#: which its factors and the car take the larger part.
FORM_ERROR = 0.003
#: Step of a coefficient for derivatives, in its standard deviations, of a slip angle, rad, and of a load, N.
STEP, SLIP_STEP, LOAD_STEP = 0.02, 1e-4, 50.0
#: The left and the right corners.
SIDES = np.array([[1.0, 0.0, 1.0, 0.0], [0.0, 1.0, 0.0, 1.0]])


@dataclass(frozen=True)
class Probabilities:
    """Posterior probabilities: of changed factors by axle and name, of wrong entries of the car."""

    factors: dict[tuple[str, str], float]
    car: dict[str, float]


def probabilities_of(grid: Grid, estimate: Estimate, unknowns: Unknowns) -> Probabilities:
    """Return the probabilities over all explanations."""
    places = np.arange(len(unknowns.car), len(unknowns))
    information, score = estimate.information(grid, np.zeros((len(grid.t), 2, 0)))
    # The scatter over parts of the drive is a further error of what the log states.
    noise = np.eye(len(score)) + information @ (estimate.scatter + np.zeros_like(information))
    information, score = np.split(np.linalg.solve(noise, np.column_stack([information, score])), [len(score)], axis=1)
    score = score[:, 0]
    spreads = np.array([SAME / 2, *CHANGES]) / FACTOR_SPREAD
    priors = np.log([1.0 - CHANGED, *[CHANGED / len(CHANGES)] * len(CHANGES)])
    chosen = np.array(list(itertools.product(range(len(spreads)), repeat=len(places))))
    logs = np.empty((1 + len(unknowns.car), len(chosen)))
    for row in range(len(logs)):
        spread = np.ones(len(score))
        if row:
            spread[row - 1] = WRONG_SPREAD
        rest, of_places, slope = _integrated(information, score, spread, places)
        scaled = np.eye(len(places)) + spreads[chosen][:, :, None] * of_places * spreads[chosen][:, None, :]
        whole = spreads[chosen] * slope
        gain = np.einsum("ki,ki->k", whole, np.linalg.solve(scaled, whole[:, :, None])[:, :, 0])
        logs[row] = rest + (gain - np.linalg.slogdet(scaled)[1]) / 2 + (np.log(ODDS) if row else 0.0)
    logs += priors[chosen].sum(axis=1)
    share = np.exp(logs - logs.max())
    share /= share.sum()
    return Probabilities(
        {pair: float(share[:, chosen[:, i] > 0].sum()) for i, pair in enumerate(unknowns.factors)},
        dict(zip(unknowns.car, share[1:].sum(axis=1).tolist(), strict=True)),
    )


def _integrated(
    information: FloatArray, score: FloatArray, spread: FloatArray, kept: IntArray
) -> tuple[float, FloatArray, FloatArray]:
    """Return the logarithm of the evidence of all but the kept unknowns, and information and score on the latter."""
    others = np.setdiff1d(np.arange(len(score)), kept)
    size = spread[others]
    inner = np.eye(len(others)) + size[:, None] * information[np.ix_(others, others)] * size
    right = size[:, None] * np.column_stack([information[np.ix_(others, kept)], score[others]])
    solved = right.T @ np.linalg.solve(inner, right)
    evidence = float(solved[-1, -1] - np.linalg.slogdet(inner)[1]) / 2
    return evidence, information[np.ix_(kept, kept)] - solved[:-1, :-1], score[kept] - solved[:-1, -1]


def evidence_of(information: FloatArray, score: FloatArray, spread: FloatArray) -> float:
    """Return the logarithm of the evidence for a prior with standard deviations `spread`, up to a constant."""
    return _integrated(information, score, spread, np.zeros(0, dtype=np.intp))[0]


@dataclass(frozen=True)
class Rival:
    """An effect that the tires may lack, or none: `missing` is None.

    - `u`: standardized deviations of its coefficients. `probability`: of this explanation. `agrees`: whether the car
      agrees with its file if the tires lack the effect.
    - `gain`: logarithm of its evidence over that of none, whose part `power` counts.
    """

    missing: Missing | None
    u: FloatArray
    probability: float = 1.0
    agrees: bool = False
    gain: float = 0.0
    power: float = 1.0

    @property
    def log_odds(self) -> float:
        """Logarithm of the odds over no effect."""
        if not self.missing:
            return 0.0
        return float(self.gain * self.power + np.log(ODDS) + (len(self.missing.center) - 1) * np.log(FURTHER))


@dataclass(frozen=True)
class DriveExplanation:
    """An estimate with an effect, or without one: `missing` is None."""

    missing: Missing | None
    grid: Grid
    estimate: Estimate


def rivals_of(base: DriveExplanation, unknowns: Unknowns, car: Car, tires: dict[str, Tire]) -> list[Rival]:
    """Return no effect and the most likely ones, with their probabilities about the estimate; likely ones first."""
    if not base.estimate.converged:
        return [Rival(None, np.zeros(0))]
    without = _with_wrong_car(*base.estimate.information(base.grid, np.zeros((len(base.grid.t), 2, 0))), unknowns)
    rivals = [Rival(None, np.zeros(0))]
    residuals = base.estimate.residuals.values[:, -len(BALANCE) :].T
    length = float(np.mean([correlation_length(row, base.grid.segment) for row in residuals]))
    factors, motion = factor_values(unknowns, base.estimate.z), motion_of(base.grid, base.estimate, unknowns, car)
    for missing, u, power in _shortlist(base, motion, tires, factors, length):
        evidence, u, agrees = _fitted(base, motion, unknowns, missing, u, factors)
        rivals.append(Rival(missing, u, agrees=agrees, gain=evidence - without, power=power / length))
    return _ranked(rivals)


def _ranked(rivals: Sequence[Rival]) -> list[Rival]:
    """Return explanations with their probabilities, likely ones first."""
    logs = np.array([rival.log_odds for rival in rivals])
    share = np.exp(logs - logs.max())
    ranked = [replace(rival, probability=float(p)) for rival, p in zip(rivals, share / share.sum(), strict=True)]
    return sorted(ranked, key=lambda rival: -graded(rival.probability))


def reestimated(
    ranked: Sequence[Rival], base: DriveExplanation, unknowns: Unknowns,
    refit: Callable[[Rival], DriveExplanation | None],
) -> tuple[list[Rival], dict[str, DriveExplanation]]:  # fmt: skip
    """Return the explanations compared by estimates of the whole drive with likely effects, and these by name.

    About an estimate without an effect, other unknowns and the noise have taken a part of it, and the linearized
    evidence is too small: by how much differs, so that it does not decide between effects, and an effect is likely if
    it is against none.
    """
    fitted = {_name(rival): refit(rival) for rival in ranked if rival.missing and rival.log_odds > LIKELY_ODDS}
    compared = _compared(ranked, fitted, base, unknowns)
    return compared, {name: explanation for name, explanation in fitted.items() if explanation}


def _name(rival: Rival) -> str:
    """Return the name of an effect, '' for none."""
    return rival.missing.name if rival.missing else ""


def _compared(
    ranked: Sequence[Rival], fitted: Mapping[str, DriveExplanation | None], base: DriveExplanation, unknowns: Unknowns
) -> list[Rival]:
    """Return the explanations compared by those estimates that there are.

    One power for all likelihoods is that of the effect that explains most: a coarsened likelihood has one, and the
    effects compete with each other.
    """
    estimates = {name: explanation for name, explanation in fitted.items() if explanation}
    if not estimates:
        return _ranked(ranked)
    evidence = _whole_evidence(base, unknowns)
    gains = {name: _whole_evidence(explanation, unknowns) - evidence for name, explanation in estimates.items()}
    strongest = max(gains, key=lambda name: graded(gains[name]))
    power = next(rival.power for rival in ranked if _name(rival) == strongest)
    rivals = []
    for rival in ranked:
        name = _name(rival)
        if name in estimates:
            u = estimates[name].estimate.z[len(unknowns) :][: len(rival.u)]
            rival = replace(rival, u=u, gain=gains[name], power=power)
        elif name in fitted:  # without an optimum, it may explain as much
            rival = replace(rival, gain=gains[strongest], power=power)
        rivals.append(rival)
    return _ranked(rivals)


def _whole_evidence(explanation: DriveExplanation, unknowns: Unknowns) -> float:
    """Return the logarithm of the evidence of an estimate of the whole drive, with a wrong entry of the car or none."""
    estimate, grid = explanation.estimate, explanation.grid
    information, score = estimate.information(grid, np.zeros((len(grid.t), 2, 0)))
    wrong = _with_wrong_car(information, score, unknowns) - evidence_of(information, score, np.ones(len(score)))
    return estimate.evidence + wrong


def lacking(ranked: Sequence[Rival]) -> float:
    """Return the probability that the tires lack an effect of the library."""
    return sum(rival.probability for rival in ranked if rival.missing)


def explaining(ranked: Sequence[Rival]) -> tuple[str, ...]:
    """Return the effects that explain a drive as well as another car would: with one, the car agrees with its file."""
    none = next(rival.probability for rival in ranked if not rival.missing)
    return tuple(rival.missing.name for rival in ranked if rival.missing and rival.agrees and rival.probability > none)


def _with_wrong_car(information: FloatArray, score: FloatArray, unknowns: Unknowns) -> float:
    """Return the logarithm of the evidence if no entry of the car or one is wrong."""
    spread = np.ones(len(score))
    logs = [evidence_of(information, score, spread)]
    for i in range(len(unknowns.car)):
        wrong = np.where(np.arange(len(score)) == i, WRONG_SPREAD, spread)
        logs.append(float(np.log(ODDS)) + evidence_of(information, score, wrong))
    return float(np.logaddexp.reduce(logs))


def _fitted(
    base: DriveExplanation, motion: Motion, unknowns: Unknowns, missing: Missing, u: FloatArray,
    factors: Mapping[str, Mapping[str, float]],
) -> tuple[float, FloatArray, bool]:  # fmt: skip
    """Return the evidence of an effect for the linearized rest of the drive, and its coefficients (Gauss-Newton).

    Third: whether the car agrees with its file.
    """
    k, without = len(u), motion.side_forces(missing.off(factors))

    def added(u: FloatArray) -> FloatArray:
        return np.nan_to_num(motion.side_forces(missing.on(u, factors)) - without)

    evidence, limits, held = -np.inf, missing.limits(k), np.zeros(k, dtype=bool)
    u = np.clip(u, *limits)
    for _ in range(FITTED):
        at = added(u)
        columns = [0.0 * at if held[i] else (added(u + STEP * (np.arange(k) == i)) - at) / STEP for i in range(k)]
        offset = at - np.tensordot(u, np.array(columns), axes=1)
        both, score = base.estimate.information(base.grid, np.stack([*columns, offset], axis=2))
        # The coefficient of the offset is 1.
        information, rest = both[:-1, :-1], score[:-1] - both[:-1, -1]
        constant = score[-1] - both[-1, -1] / 2
        covariance = np.asarray(np.linalg.inv(information + np.eye(len(rest))), dtype=np.float64)
        z = covariance @ rest
        beyond = (z[-k:] < limits[0]) & (u <= limits[0]) | (z[-k:] > limits[1]) & (u >= limits[1])
        if np.any(beyond & ~held):  # no tire has such a coefficient: it stays at its bound
            held |= beyond
            continue
        evidence = constant + _with_wrong_car(information, rest, unknowns)
        change = np.clip(z[-k:] - u, -1.0, 1.0) * ~held
        if np.abs(change).max() < SMALL_CHANGE:
            break
        u = np.clip(u + change, *limits)
    n_car = len(unknowns.car)
    return float(evidence), u, is_agreement(z[:n_car], covariance[:n_car, :n_car])


def nearby(rival: Rival, base: DriveExplanation, unknowns: Unknowns) -> Estimate:
    """Return an estimate without an effect as the start of one with it: coefficients in proportion to it are 0.

    The linearized coefficients would begin far from any optimum where the effect changes what the car takes.
    """
    missing, estimate = rival.missing, base.estimate
    assert missing is not None
    u = np.where([name in missing.logarithmic for name in missing.center], rival.u, 0.0)
    n = len(unknowns)
    return replace(estimate, z=np.concatenate([estimate.z[:n], u, estimate.z[n:]]))


def forces_of(rival: Rival, unknowns: Unknowns, car: Car, base: DriveExplanation) -> Forces:
    """Return the forces of an effect about the motion and the unknowns that are estimated so far.

    They are linear in the coefficients, in factors, slip angles and loads, too: of a tire with the effect, these change
    other forces than of one without. Slip angles follow from the motion and the car, loads from the car.
    """
    missing, n, further = rival.missing, len(unknowns), len(rival.u)
    assert missing is not None

    def forces(grid: Grid, states: FloatArray, z: FloatArray) -> AddedForces:
        def motion_at(z: FloatArray) -> Motion:
            return motion_of(grid, replace(base.estimate, states=states, z=z), unknowns, car)

        def added(z: FloatArray, motion: Motion) -> FloatArray:
            factors = factor_values(unknowns, z)
            on, off = missing.on(z[n : n + further], factors), missing.off(factors)
            return np.nan_to_num(motion.side_forces(on) - motion.side_forces(off))

        motion, steps = motion_at(z), STEP * np.eye(len(z))
        at, columns = added(z, motion), []
        by_slip = (added(z, motion.moved("alpha", np.full(4, SLIP_STEP))) - at) / SLIP_STEP
        by_load = [(added(z, motion.moved("Fz", LOAD_STEP * side)) - at) / LOAD_STEP for side in SIDES]
        for step in steps[: len(unknowns.car)]:
            other = motion_at(z + step)
            slip, load = ((other.inputs[name] - motion.inputs[name]).reshape(2, 2, -1).T for name in ("alpha", "Fz"))
            change = by_slip * slip.mean(axis=1) + by_load[0] * load[:, 0] + by_load[1] * load[:, 1]
            columns.append((change + at * (np.array(motion.loads) / other.loads - 1.0)) / STEP)
        by_factor = {  # of both axles at once
            name: (added(z + sum(steps[unknowns.factor(axle, name)] for axle in AXLES), motion) - at) / STEP
            for name in FACTORS
        }
        for axle, name in unknowns.factors:
            columns.append(np.where([axle == other for other in AXLES], by_factor[name], 0.0))
        columns += [(added(z + step, motion) - at) / STEP for step in steps[n : n + further]]
        by_last = np.stack(columns, axis=2)
        middle = (states[grid.left] + states[grid.right])[:, : len(MOTION)] / 2
        entries = unknowns.car_values(car, z)
        arms = np.array([entries["cg_to_front"], -entries["cg_to_rear"]])
        by_vy = by_slip / middle[:, :1]
        slopes = np.stack([np.zeros_like(at), by_vy, by_vy * arms], axis=2)
        offset = at - by_last @ z[: n + further] - np.einsum("kim,km->ki", slopes, middle)
        return AddedForces(offset, by_last, slopes, further, limits=missing.limits(further))

    return forces


def _shortlist(
    base: DriveExplanation, motion: Motion, tires: dict[str, Tire], factors: Mapping[str, Mapping[str, float]],
    length: float,
) -> list[tuple[Missing, FloatArray, float]]:  # fmt: skip
    """Return the effects that raise the evidence of the linearized estimate most, if any do, in their best form.

    `length`: residuals that count as one.

    With each its coefficients and the power of its likelihood: no formula is exact, and the information of a log on an
    error of the form grows with its length (Miller and Dunson, Robust Bayesian inference via coarsening, JASA 114,
    2019). The error has the shape of the effect; what the car and the factors explain of it does not count.
    """
    columns = effect_columns(motion, tires, factors)
    if not columns:
        return []
    forces = np.stack([column for _, _, column in columns], axis=2)
    information, score = base.estimate.information(base.grid, forces)
    n = len(base.estimate.z)
    without = evidence_of(information, score, np.repeat([1.0, 0.0], [n, len(columns)]))
    by_car = np.linalg.solve(information[:n, :n] + np.eye(n), information[:n, n:])
    alone = np.diag(information[n:, n:]) - np.sum(information[:n, n:] * by_car, axis=0)
    of_tires = motion.side_forces({axle: scaled(tire, factors[axle]) for axle, tire in tires.items()})
    errors = FORM_ERROR**2 * np.mean(of_tires**2) / np.mean(forces**2, axis=(0, 1))
    powers = 1.0 / (1.0 + errors * alone / 2)
    gains = dict[str, tuple[float, Missing, FloatArray, float]]()
    for i, (missing, u, _) in enumerate(columns):
        spread = np.concatenate([np.ones(n), np.arange(len(columns)) == i])
        gain = powers[i] * (evidence_of(information, score, spread) - without)
        likely = Rival(missing, u, gain=2.0 * gain, power=1.0 / length).log_odds > LIKELY_ODDS
        if likely and gain > gains.get(missing.name, (0.0,))[0]:
            gains[missing.name] = gain, missing, u, powers[i]
    ranked = sorted(gains.values(), key=lambda entry: -entry[0])[:COMPARED]
    return [(missing, u, power) for _, missing, u, power in ranked]
