"""The final fit after a search: without errors of the functional form, confirmed effects only, whitened noise.

Channels are weighted by their residuals, so that a channel with an inexact formula does not make the others worse; the
baseline tire is fitted with the same weights. Refinements that the recording does not determine are removed. Cross-talk
remains only if it is as significant as an effect. If no effect remains, both are one tire.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt

from tirefmu.estimation.noise_model import Whitening, noise_parts

from ..least_squares import LeastSquares, Solution
from ..probing.cross_talk import doubtful_cross_talk, without
from ..probing.effect_probing import Screen
from ..thresholds import FINAL_ITERATIONS, MAX_UNCERTAINTY, MAX_WHITENED_MISFIT
from .confirmation import Confirmation, confirmation
from .effect_search import Search
from .refits import Refit

FloatArray = npt.NDArray[np.float64]

#: Number of times that the channels are weighted by their residuals and fitted.
BALANCING = 2


@dataclass(frozen=True, eq=False)
class Settled:
    """The final fits.

    Attributes
    ----------
    before : Screen
        Of the baseline model.
    after : Screen
        Of the model with the identified effects.
    whitened : Screen
        The same with whitened rows, for confidence intervals.
    confirmed : mapping of str to Confirmation
        By name of an identified effect or a refinement.
    rejected : mapping of str to Confirmation
        The effects that the search identified and the final fit did not confirm.
    """

    before: Screen
    after: Screen
    whitened: Screen
    confirmed: Mapping[str, Confirmation]
    rejected: Mapping[str, Confirmation]


def settle(search: Search, before: Screen) -> Settled:
    """Fit the baseline model and the model with the identified effects once more, as they are delivered.

    Disturbances by which the search corrects the functional form are removed, as a tire does not contain
    them. Effects that are not confirmed are removed from the search.

    Parameters
    ----------
    search : Search
        Completed.
    before : Screen
        Of the baseline model.

    Returns
    -------
    Settled
    """
    unchanged = search.solution is before.solution
    search.problem = replace(search.problem, disturbances=search.problem.disturbances.of_recording())
    search.solution = search.problem.at(search.solution.parameters, search.solution.free)
    doubtful = doubtful_cross_talk(search.problem, search.solution)
    search.problem = without(search.problem, doubtful)
    for _ in range(BALANCING):
        search.problem = _balanced(search.problem, search.solution)
        search.solution = search.problem.solve(
            search.solution.parameters, search.solution.free, iterations=FINAL_ITERATIONS
        )
    confirmed, rejected = _confirmed_or_replaced(search)
    if unchanged:
        before = Screen(search.problem, search.solution)
    elif set(search.solution.free) == set(before.solution.free):  # all was rejected: one tire, from the baseline fit
        search.solution = search.problem.solve(
            before.solution.parameters, before.solution.free, iterations=FINAL_ITERATIONS
        )
        before = Screen(search.problem, search.solution)
    else:  # with the same weights: a channel that gives way to another one in one fit only looks better or worse
        problem = replace(without(before.problem, doubtful), inverse_noise=search.problem.inverse_noise)
        before = Screen(
            problem, problem.solve(before.solution.parameters, before.solution.free, iterations=FINAL_ITERATIONS)
        )
    first, solution, whitened = _whitened(search.problem, search.solution, before)
    if undetermined := _undetermined_refinements(search, whitened):
        for refit in undetermined:
            rejected[refit.name] = confirmed[refit.name]
            _remove(search, refit)
        confirmed, others = _confirmed(search)
        rejected |= others
        first, solution, whitened = _whitened(search.problem, search.solution, before)
    search.solution = solution
    search.screen = Screen(search.problem, search.solution)
    search.last = search.probe()
    return Settled(first, search.screen, whitened, confirmed, rejected)


def _balanced(problem: LeastSquares, solution: Solution) -> LeastSquares:
    """Return the problem with each channel weighted by its residual, as in a fit of maximum likelihood.

    The search weights a channel by its short-range noise. A channel whose formula is inexact has a larger residual; the
    fit would then make the other channels worse for it.
    """
    used = problem.inverse_noise > 0.0
    sums = np.sum((problem.inverse_noise * solution.residual) ** 2, axis=1, where=used)
    size = np.sqrt(sums / np.maximum(used.sum(axis=1), 1))
    relative = size / np.sqrt(np.mean(size[size > 0.0] ** 2)) if size.any() else np.ones_like(size)
    return replace(problem, inverse_noise=problem.inverse_noise / np.where(size > 0.0, relative, 1.0)[:, None])


def _confirmed(search: Search) -> tuple[dict[str, Confirmation], dict[str, Confirmation]]:
    """Remove the least significant unconfirmed effect and refit, until all remaining effects are confirmed."""
    rejected: dict[str, Confirmation] = {}
    absent = search.problem.simulator.tire.parameters()
    while True:
        judged = [(refit, _evidence(search, refit, absent)) for refit in [*search.found, *search.refinements]]
        failing = [(refit, one) for refit, one in judged if not one.passes]
        if not failing:
            return {refit.name: one for refit, one in judged}, rejected
        worst, evidence = min(failing, key=lambda pair: pair[1].z)
        rejected[worst.name] = evidence
        search.progress(f"not confirmed: {worst.name} ({evidence.reason_against})")
        _remove(search, worst)


def _confirmed_or_replaced(search: Search) -> tuple[dict[str, Confirmation], dict[str, Confirmation]]:
    """Continue the search without the effects that were not confirmed: another one may explain the same residual."""
    candidates, rejected = search.candidates, dict[str, Confirmation]()
    while True:
        confirmed, failed = _confirmed(search)
        rejected |= failed
        search.candidates = {name: one for name, one in search.candidates.items() if name not in failed}
        if failed.keys().isdisjoint(candidates) or not search.extended():
            search.candidates = candidates
            return confirmed, {name: one for name, one in rejected.items() if name not in confirmed}
        search.solution = search.problem.solve(
            search.solution.parameters, search.solution.free, iterations=FINAL_ITERATIONS
        )


def _evidence(search: Search, refit: Refit, absent: FloatArray) -> Confirmation:
    candidate = search.candidates.get(refit.name)
    has_states = candidate is not None and candidate.has_states
    return confirmation(search.problem, search.solution, _coefficients(refit, search), absent, has_states=has_states)


def _undetermined_refinements(search: Search, whitened: Screen) -> list[Refit]:
    """Return the refinements all of whose coefficients the recording leaves open: these remain neutral."""
    problem, free = whitened.problem, whitened.solution.free
    deviations = dict(zip(free, np.sqrt(np.diag(whitened.baseline.inverse)), strict=False))  # then the disturbances
    undetermined = []
    for refit in search.refinements:
        posterior, prior = np.array([deviations[name] for name in refit.form.free]), problem.prior(refit.form.free)[1]
        if np.all(posterior > MAX_UNCERTAINTY * prior):
            search.progress(f"not determined by the recording: {refit.name}")
            undetermined.append(refit)
    return undetermined


def _coefficients(refit: Refit, search: Search) -> tuple[str, ...]:
    """Return the free coefficients that belong to an effect, also those of its refinements."""
    model = search.problem.simulator.symbolic_model
    owned = model.owned(refit.name) if refit.name in model.effects else frozenset()
    return tuple(name for name in search.solution.free if name in refit.form.free or name in owned)


def _remove(search: Search, refit: Refit) -> None:
    """Remove an effect, its refinements and its coefficients, and fit the others again."""
    names = _coefficients(refit, search)
    search.found = [one for one in search.found if one is not refit]
    search.refinements = [one for one in search.refinements if not set(one.form.free) <= set(names)]
    search.solution = search.problem.solve_without(search.solution, names, iterations=FINAL_ITERATIONS)


def _whitened(problem: LeastSquares, solution: Solution, before: Screen) -> tuple[Screen, Solution, Screen]:
    """Refit baseline and final model with whitened noise.

    The search itself uses rows of equal weight. A missing effect resembles correlated noise, and whitening amplifies
    errors in the functional form of a model. Solutions that fit the rows worse than without whitening are not used.

    Returns
    -------
    Screen
        Of the baseline model.
    Solution
        Of the final model.
    Screen
        Of the final model with whitened rows.
    """
    signals = problem.simulator.signals
    if not signals.timed:
        screen = Screen(problem, solution)
        screen.learn_noise({})
        return before, solution, screen
    t = signals.t[signals.rows]
    rest, step = problem.weighted(solution.residual), float(np.median(np.diff(t)))
    noise = tuple(noise_parts(*rows, step) for rows in zip(rest, problem.inverse_noise > 0.0, strict=True))
    whitening = Whitening(noise, t, problem.inverse_noise)
    whitened = replace(problem, whitening=whitening)
    final = _not_worse(
        problem, whitened.solve(solution.parameters, solution.free, iterations=FINAL_ITERATIONS), solution
    )
    of_base = before.solution
    screen = Screen(whitened, whitened.at(final.parameters, final.free))
    screen.learn_noise({})
    if of_base is solution:
        return Screen(before.problem, final), final, screen
    first = replace(before.problem, whitening=whitening).solve(
        of_base.parameters, of_base.free, iterations=FINAL_ITERATIONS
    )
    return Screen(before.problem, _not_worse(before.problem, first, of_base)), final, screen


def _not_worse(problem: LeastSquares, whitened: Solution, equal: Solution) -> Solution:
    """Return the whitened solution unless its misfit over rows of equal weight is much larger in a channel."""
    squares = [np.sum(problem.weighted(solution.residual) ** 2, axis=1) for solution in (whitened, equal)]
    return whitened if np.all(squares[0] <= MAX_WHITENED_MISFIT**2 * squares[1]) else equal
