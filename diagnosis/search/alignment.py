"""Alignment of forces and inputs in time: a skew of the recording is corrected before effects are searched for.

A skew delays all forces by the same time, relaxation delays the response of each slip by a distance. At one speed with
one slip they are the same. Relaxation alone is compared with a skew, to which relaxation may be added: the skew is
preferred, because it is a property of the bench, unless relaxation alone explains significantly more.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import numpy.typing as npt

from tirefmu.estimation.block_regression import error_of_sum

from ..least_squares import LeastSquares, Solution
from ..probing.cross_talk import with_lever, without_doubtful_lever
from ..probing.effect_probing import Screen
from ..recording.skew import delay_response
from ..thresholds import EFFECT_GAIN, MAX_SKEW, MIN_SKEW, PREFERRED_ERRORS
from .effect_search import Search
from .refits import consistent

FloatArray = npt.NDArray[np.float64]

#: Iterations of the estimate; each corrects the delay that the previous ones left.
STEPS = 3
#: Iterations of a fit with delayed inputs.
ITERATIONS = 4
#: Number of relaxation effects that are compared with a skew, together.
RELAXATIONS = 2


def searched(search: Search) -> tuple[Screen, Search]:
    """Run a search over a recording whose skew is corrected.

    Missing effects can hide a skew. If the search identifies relaxation, relaxation is therefore compared with a skew
    once more, and the search is repeated with the skew corrected if the skew is preferred.

    Parameters
    ----------
    search : Search
        Before its first round.

    Returns
    -------
    before : Screen
        Of the baseline model.
    search : Search
        Completed.
    """
    problem, solution = search.problem, search.solution
    skew = _skew(search, problem, solution)
    before, done = _run(search, problem, solution, skew)
    relaxing = problem.simulator.symbolic_model.relaxing_effects
    lagging = {name for refit in done.found if refit.name in relaxing for name in refit.form.free}
    if not lagging or skew:
        return before, done
    skew = _skew(done, done.problem, done.problem.solve_without(done.solution, lagging, iterations=ITERATIONS))
    if not skew:
        return before, done
    search.progress("a skew explains the recording better than relaxation: the search is repeated")
    return _run(search, problem, solution, skew)


def _run(search: Search, problem: LeastSquares, solution: Solution, skew: float) -> tuple[Screen, Search]:
    """Return the screen of the baseline model and the completed search, with a skew corrected."""
    if skew:
        search.progress(f"the forces are recorded {1000.0 * skew:.1f} ms after the inputs: corrected")
        problem, solution = _delayed(problem, solution, skew)
    before, run = _completed(search, *without_doubtful_lever(problem, solution))  # a skew would hide its significance
    rival = "" if before.problem is problem else _like_a_lever(run, problem)
    if not rival:
        return before, run
    search.progress(f"a lever of the side force explains the recording as well as {rival}: the search is repeated")
    return _completed(search, problem, solution)


def _completed(search: Search, problem: LeastSquares, solution: Solution) -> tuple[Screen, Search]:
    run = Search(problem, solution, search.candidates, search.progress)
    before = Screen(problem, solution)
    run.run()
    return before, run


def _like_a_lever(run: Search, source: LeastSquares) -> str:
    """Return an identified effect of Mz alone that a lever of the side force could replace, or an empty text."""
    loss = Screen(run.problem, run.solution).baseline.loss
    problem = with_lever(run.problem, source)
    for refit in run.found:
        if refit.name in run.candidates and run.candidates[refit.name].channels == ("Mz",):
            other = problem.solve_without(run.solution, refit.form.free, iterations=ITERATIONS)
            excess = Screen(problem, other).baseline.loss - loss
            if excess.sum() <= PREFERRED_ERRORS * error_of_sum(excess):
                return refit.name
    return ""


def _skew(search: Search, problem: LeastSquares, solution: Solution) -> float:
    """Return the skew of a recording, s; 0 if there is none or relaxation alone explains the residual better."""
    if not problem.simulator.signals.timed:
        return 0.0
    loss = Screen(problem, solution).baseline.loss
    relaxed = _relaxed(search, problem, solution)
    others = loss if relaxed is None else relaxed.screen.baseline.loss
    aligned = _aligned(problem, solution)
    clear = significant(loss - Screen(*aligned).baseline.loss, loss)
    if _has_skew(aligned[0]) and (clear or relaxed):
        rest = _relaxed(search, *aligned) if relaxed else None
        if rest is not None:
            aligned = _aligned(rest.problem, rest.solution)
        excess = Screen(*aligned).baseline.loss - others
        if _has_skew(aligned[0]) and excess.sum() <= (PREFERRED_ERRORS * error_of_sum(excess) if clear else 0.0):
            return aligned[0].simulator.signals.skew
    if relaxed is None:
        return 0.0
    aligned = _aligned(relaxed.problem, relaxed.solution)
    present = _has_skew(aligned[0]) and significant(others - Screen(*aligned).baseline.loss, others)
    return aligned[0].simulator.signals.skew if present else 0.0


def significant(gains: FloatArray, loss: FloatArray) -> bool:
    """Return whether the gains of all blocks satisfy the criteria of an effect."""
    return float(gains.sum()) > EFFECT_GAIN * float(loss.sum()) and consistent(gains)


def _aligned(problem: LeastSquares, solution: Solution) -> tuple[LeastSquares, Solution]:
    """Return problem and solution with the skew corrected that the residual contains."""
    for _ in range(STEPS):
        problem, solution = _delayed(problem, solution, _remaining_skew(problem, solution))
        if abs(problem.simulator.signals.skew) < 0.5 * MIN_SKEW:
            break
    return problem, solution


def _remaining_skew(problem: LeastSquares, solution: Solution) -> float:
    """Return the skew that the residual contains, estimated together with the coefficients, s."""
    column = delay_response(problem.simulator, solution.parameters)[:, :, None]
    extended = problem.disturbances.extended(("skew",), column, np.array([MAX_SKEW]))
    linear = replace(problem, disturbances=extended).solve(solution.parameters, solution.free, iterations=3)
    return float(np.clip(linear.disturbance[-1], -MAX_SKEW, MAX_SKEW))


def _delayed(problem: LeastSquares, solution: Solution, seconds: float) -> tuple[LeastSquares, Solution]:
    """Return problem and solution with the inputs delayed."""
    simulator = problem.simulator
    moved = replace(problem, simulator=simulator.with_signals(simulator.signals.delayed(seconds)))
    return moved, moved.solve(solution.parameters, solution.free, iterations=ITERATIONS)


def _has_skew(problem: LeastSquares) -> bool:
    return MIN_SKEW < abs(problem.simulator.signals.skew) < MAX_SKEW


def _relaxed(search: Search, problem: LeastSquares, solution: Solution) -> Search | None:
    """Return a search that has accepted the relaxation effects that pass the criteria, or None."""
    relaxing = problem.simulator.symbolic_model.relaxing_effects
    candidates = {name: one for name, one in search.candidates.items() if name in relaxing}
    trial = Search(problem, solution, candidates, lambda sentence: None)
    for _ in range(RELAXATIONS):
        best = trial.best_effect()
        if best is None or best.name not in relaxing:
            break
        trial.accept(best)
    trial.screen = Screen(trial.problem, trial.solution)
    return trial if trial.found else None
