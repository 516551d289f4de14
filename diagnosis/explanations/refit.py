"""Refits of explanations under one noise, and their evidence."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import lru_cache
from itertools import chain

import numpy as np
from scipy.linalg import cho_solve, solve_triangular

from ...measurements.virtual_bench.bench_errors import MAX_SKEW
from ...numerics.arrays import FloatArray
from ...numerics.noise_model import Whitening, noise_parts
from ...numerics.ties import graded
from ..least_squares import AT_BOUND, LeastSquares, Solution
from ..probing.candidates import Candidate
from ..signals.disturbances import Disturbances
from ..signals.simulation import Simulator
from ..thresholds import DISCREPANCIES, MAX_ROWS, UNKNOWN_SHARE
from .budget import Budget
from .discrepancy import fast_drift, grip_drift, input_noise_responses, model_discrepancy
from .evidence import NormalEquations, inflation, likelihood_power
from .explanation import Explanation, Term, terms_of_form
from .linearization import TERM, Addition, Linearization

#: How the names of the columns of the discrepancy, and of fast drift and noise of the inputs, begin.
DISCREPANCY, BENCH = "discrepancy_", "bench_"
#: The group of terms of formulas in the discrepancy, and their deviation if the evidence is larger without them.
OF_FORMULAS, ABSENT = "formulas", 1e-6
#: Iterations before a refit, for the choice of initial values; corrections of the skew.
COARSE_ITERATIONS, ALIGNMENTS = 8, 3
#: Rows of this choice at least, if as many are compared; share of the cost by which it may still fall.
COARSE_ROWS, COARSE = 1000, 1e-3
#: Added to the scaled diagonal for a draw from the posterior: columns may be equal.
RIDGE_OF_DRAW = 1e-10
#: A smaller change of the evidence is none: a factor of 1.1 between two explanations.
SAME_EVIDENCE = 0.1


@dataclass(frozen=True, eq=False)
class Shared:
    """What all compared explanations have in common.

    - `problem`: of the baseline model with the common noise and the discrepancy of the model.
    - `free`: the coefficients of the baseline model.
    - `explained`: as in `evidence.inflation`.
    - `budget`: the time of the comparison.
    """

    problem: LeastSquares
    free: tuple[str, ...]
    candidates: Mapping[str, Candidate]
    explained: float
    budget: Budget


@dataclass(frozen=True, eq=False)
class Refitted:
    """An explanation with its best coefficients.

    - `evidence`: logarithm, without the prior odds of the explanation.
    """

    linear: Linearization
    evidence: float

    @property
    def explanation(self) -> Explanation:
        """The explanation."""
        return self.linear.explanation

    @property
    def score(self) -> float:
        """Logarithm of the evidence with the prior odds."""
        return self.evidence + self.explanation.log_prior

    @property
    def term_sizes(self) -> tuple[float, ...]:
        """The fitted coefficients of the terms of the unknown component."""
        named = dict(
            zip(self.linear.problem.disturbances.names, self.linear.solution.disturbance.tolist(), strict=True)
        )
        return tuple(named[f"{TERM}{i}"] for i in range(len(self.explanation.terms)))


def refitted(shared: Shared, explanation: Explanation, starts: Sequence[FloatArray], simulator: Simulator) -> Refitted:
    """Fit an explanation from the best of several initial values, each of shape (n_parameters,).

    The skew begins with that of the simulator, or with none if that is at its bound. Raises `Ended` if the time of the
    comparison is over.
    """
    signals = simulator.signals
    if abs(signals.skew) > (1.0 - AT_BOUND) * MAX_SKEW:  # no delay of a bench, but what a relaxation may explain
        simulator = simulator.with_signals(signals.delayed(-signals.skew))
    whole = with_terms(shared.problem, explanation.terms).over(simulator)
    fitted = {*shared.free, *(name for _, form in explanation.forms for name in form.free)}
    free = tuple(sorted(fitted, key=simulator.names.index))
    start = starts[0] if len(starts) == 1 else _best_of(starts, whole, free, shared.budget)
    best = _evaluated(shared, explanation, whole, start, free)
    for _ in range(ALIGNMENTS if simulator.signals.timed else 0):
        signals = best.linear.simulator.signals
        step = best.linear.skew - signals.skew
        if best.linear.error_of_skew(step) < SAME_EVIDENCE:
            break
        delayed = whole.over(simulator.with_signals(signals.delayed(step)))
        other = _evaluated(shared, explanation, delayed, best.linear.solution.parameters, free)
        if other.evidence <= best.evidence:
            break
        best = other
    return best


def fitted_as_tire(
    problem: LeastSquares, linear: Linearization, base: Solution, free: Sequence[str]
) -> tuple[LeastSquares, Solution]:
    """Fit what a refit explains without discrepancies, which a tire does not have.

    Begins where the refit ended, with its core and with that of `base`, a fit without them; the better one counts.
    """
    started, index = linear.solution.parameters, [problem.simulator.index[name] for name in base.free]
    core_alone = started.copy()
    core_alone[index] = base.parameters[index]
    driven = problem.driven(linear.solution)
    return min((driven.fitted(start, free) for start in (started, core_alone)), key=lambda fit: graded(fit[1].cost))


def _best_of(starts: Sequence[FloatArray], whole: LeastSquares, free: Sequence[str], budget: Budget) -> FloatArray:
    """Return where the best of several initial values leads on some of the rows, of independent noise."""
    every = max(whole.inverse_noise.shape[1] // COARSE_ROWS, 1)
    few = whole.subsampled(slice(None, None, every))
    coarse, tried = replace(few, inverse_noise=np.sqrt(every) * few.inverse_noise), []  # the weight of all
    for start in starts:
        budget.check()
        tried.append(coarse.solve(start, free, iterations=COARSE_ITERATIONS, tolerance=COARSE))
    return min(tried, key=lambda solution: graded(solution.cost)).parameters


def some_rows(simulator: Simulator) -> slice:
    """Return every n-th compared row, at most half of `MAX_ROWS`."""
    return slice(None, None, -(-len(simulator.signals.rows) // (MAX_ROWS // 2)))


@lru_cache(maxsize=2)  # explanations with the same terms share one problem
def with_terms(problem: LeastSquares, terms: tuple[Term, ...]) -> LeastSquares:
    """Return a problem with the terms of an unknown component as disturbances."""
    if not terms:
        return problem
    names = tuple(f"{TERM}{i}" for i in range(len(terms)))
    columns = np.stack([term.column for term in terms], axis=-1)
    deviation = np.array([term.deviation for term in terms])
    return problem.extended(names, columns, deviation)


def _evaluated(
    shared: Shared, explanation: Explanation, problem: LeastSquares, start: FloatArray, free: Sequence[str]
) -> Refitted:
    """Return a refit from all rows."""
    shared.budget.check()
    solution = problem.solve(start, free)
    linear = Linearization(explanation, problem, solution, shared.candidates)
    return Refitted(linear, linear.equations().solved()[1])


def shared_problem(
    linear: Linearization, baseline: Solution, effects: Sequence[Addition], reproduced: Collection[str],
    explained: float, budget: Budget,
) -> Shared:  # fmt: skip
    """Return the common noise and discrepancy.

    The noise is what no combination of all columns explains, so that no explanation has an advantage by it. The
    deviation of each channel's discrepancy is that of the largest evidence.

    `linear`: at the leading explanation, with rows of independent noise. `baseline`: solution of the baseline model.
    `effects`: that it lacks. `reproduced`: terms that are no errors of form (`additions.reproduced_terms`).
    `explained`: logarithm of the likelihood that it explains.
    """
    problem, signals, additions = linear.problem, linear.simulator.signals, [*effects, linear.unknown()]
    drift, of_drift = fast_drift(signals, problem.inverse_noise)
    forces = problem.simulator.forces(baseline.parameters)
    grip, of_grip = grip_drift(signals, forces)
    noise = input_noise_responses(problem.simulator, linear.solution.parameters)
    deviation = np.concatenate([of_drift, of_grip, np.ones(noise.shape[-1])])
    names = tuple(f"{BENCH}{i}" for i in range(len(deviation)))
    disturbances = problem.disturbances.extended(names, np.concatenate([drift, grip, noise], axis=-1), deviation)
    smooth, formulas = model_discrepancy(signals, forces), _of_formulas(problem, baseline, reproduced)
    columns = np.concatenate([smooth, formulas], axis=-1)
    channels = np.argmax(np.any(smooth, axis=1), axis=0).tolist() + [OF_FORMULAS] * formulas.shape[-1]
    names = tuple(f"{DISCREPANCY}{channel}_{i}" for i, channel in enumerate(channels))
    widest = np.full(len(names), max(DISCREPANCIES))
    extended = replace(problem, disturbances=disturbances.extended(names, columns, widest))
    budget.check()
    size = _sizes(extended, saturated_residual(replace(linear, problem=extended), additions))
    extended = replace(extended, inverse_noise=extended.inverse_noise / size[:, None])
    budget.check()
    noisy = _with_noise(extended, saturated_residual(replace(linear, problem=extended), additions), explained)
    budget.check()
    normal = replace(linear, problem=noisy).equations(effects)
    disturbances = replace(noisy.disturbances, deviation=_best_deviation(normal, noisy.disturbances))
    of_leader = {name for name in disturbances.names if name.startswith(TERM)}
    chosen = replace(noisy, disturbances=disturbances.without(of_leader) if of_leader else disturbances)
    return Shared(chosen, baseline.free, linear.candidates, explained, budget)


def _of_formulas(problem: LeastSquares, baseline: Solution, reproduced: Collection[str]) -> FloatArray:
    """Return the terms of formulas that are errors of form, N and N m, shape (n_channels, n, k).

    Each is as large as the measured forces.
    """
    terms = [term for term in terms_of_form(problem, baseline) if term.text not in reproduced]
    columns = [term.deviation / UNKNOWN_SHARE * term.column for term in terms]
    return np.stack(columns, axis=-1) if columns else np.zeros((*problem.inverse_noise.shape, 0))


def _best_deviation(normal: NormalEquations, disturbances: Disturbances) -> FloatArray:
    """Return the deviations of the disturbances, shape (k,), with those of the discrepancy of the largest evidence.

    One deviation is that of all smooth columns of a channel; formulas have another one, beside these. `normal`: with
    all effects, so that the discrepancy does not take their part.
    """
    groups = np.array([name.rpartition("_")[0] for name in disturbances.names])
    deviation = np.where(groups == f"{DISCREPANCY}{OF_FORMULAS}", ABSENT, disturbances.deviation)

    def evidence(tried: FloatArray) -> float:
        precision = normal.precision.copy()
        precision[: len(tried)] = tried**-2.0
        return replace(normal, precision=precision).solved()[1]

    for group in sorted({str(name) for name in groups if name.startswith(DISCREPANCY)}):
        sizes = (ABSENT, *DISCREPANCIES) if group.endswith(OF_FORMULAS) else DISCREPANCIES
        tried = np.tile(deviation, (len(sizes), 1))
        tried[:, groups == group] = np.array(sizes)[:, None]
        deviation = tried[int(np.argmax(graded([evidence(deviations) for deviations in tried])))]
    return deviation


def saturated_residual(linear: Linearization, additions: Sequence[Addition]) -> FloatArray:
    """Return what all columns together do not explain, in units of the weights of rows, shape (n_channels, n).

    The columns also follow noise, most of it slow. The residual is therefore that of a draw from the posterior of their
    coefficients: its spectrum is that of the noise in the mean, as in a step of the algorithm of Dempster, Laird and
    Rubin (1977) for a variance.
    """
    problem = linear.problem
    normal = linear.equations(additions)
    (factor, _), scale = normal.factored(RIDGE_OF_DRAW)
    estimate = scale * cho_solve((factor, True), scale * (normal.target + normal.gradient))
    drawn = scale * solve_triangular(factor, np.random.default_rng(0).standard_normal(len(scale)), trans=1, lower=True)
    both, end = np.stack([estimate, drawn], axis=-1), 0
    fitted = np.zeros((*problem.inverse_noise.shape, 2))
    contained = (group.columns for group in linear.contained())
    for columns in chain([problem.disturbances.columns], contained, (addition.columns for addition in additions)):
        begin, end = end, end + columns.shape[-1]
        fitted += columns @ both[begin:end]
    rest = problem.weighted(problem.misfit(linear.solution.parameters) - fitted[:, :, 0])
    return np.asarray(rest - problem.weighted(fitted[:, :, 1]))


def _sizes(problem: LeastSquares, residual: FloatArray) -> FloatArray:
    """Return the root mean square of a weighted residual in each channel, shape (n_channels,); 1 in unused ones."""
    rows = np.maximum((problem.inverse_noise > 0.0).sum(axis=1), 1)
    size = np.sqrt(np.sum(residual**2, axis=1) / rows)
    return np.where(size > 0.0, size, 1.0)


def _with_noise(problem: LeastSquares, residual: FloatArray, explained: float) -> LeastSquares:
    """Return a problem with the noise of a residual in units of its weights, the likelihood raised to its power."""
    signals, used = problem.simulator.signals, problem.inverse_noise > 0.0
    power = likelihood_power(int(used.any(axis=0).sum())) / inflation(explained)
    if not signals.timed:
        size = _sizes(problem, residual)[:, None]
        return replace(problem, inverse_noise=np.sqrt(power) * problem.inverse_noise / size)
    t = signals.t[signals.rows]
    step = float(np.median(np.diff(t)))
    noise = tuple(noise_parts(*rows, step).times(1.0 / power) for rows in zip(residual, used, strict=True))
    return replace(problem, whitening=Whitening(noise, t, problem.inverse_noise))
