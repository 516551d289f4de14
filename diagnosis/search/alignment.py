"""Alignment of forces and inputs in time: a skew of the recording is corrected before effects are searched for.

A skew delays all forces by the same time, relaxation delays the response of each slip by a distance. At one speed with
one slip they are the same. Relaxation alone is compared with a skew, to which relaxation may be added: the skew is
preferred, because it is a property of the bench, unless relaxation alone explains significantly more.
"""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import replace

import numpy as np
import numpy.typing as npt

from ..least_squares import LeastSquares, Solution
from ..probing.effect_probing import Screen
from ..recording.skew import delay_response
from ..thresholds import EFFECT_ERRORS, EFFECT_GAIN, MAX_SKEW, MIN_SKEW, PREFERRED_ERRORS
from .effect_search import Search
from .settling import doubtful_cross_talk, without

FloatArray = npt.NDArray[np.float64]

#: Iterations of the estimate; each corrects the delay that the previous ones left.
STEPS = 3
#: Iterations of a fit with delayed inputs.
ITERATIONS = 4
#: The cross-talk that has nearly the shape of an effect.
LEVER = "cross_talk_Fy_in_Mz"
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
    problem, solution = _without_doubtful_lever(search.problem, search.solution)
    skew = _skew(search, problem, solution)
    before, done = _run(search, problem, solution, skew)
    relaxing = problem.simulator.book.relaxing_effects
    lagging = {name for refit in done.found if refit.name in relaxing for name in refit.form.free}
    if not lagging or skew:
        return before, done
    skew = _skew(done, done.problem, _without(lagging, done.problem, done.solution))
    return _run(search, problem, solution, skew) if skew else (before, done)


def _without_doubtful_lever(problem: LeastSquares, solution: Solution) -> tuple[LeastSquares, Solution]:
    """Return problem and solution without a lever of Fy in Mz, unless it is significant: it resembles the trail."""
    if LEVER not in doubtful_cross_talk(problem, solution):
        return problem, solution
    problem = without(problem, (LEVER,))
    return problem, problem.solve(solution.parameters, solution.free, iterations=ITERATIONS)


def _run(search: Search, problem: LeastSquares, solution: Solution, skew: float) -> tuple[Screen, Search]:
    """Return the screen of the baseline model and the completed search, with a skew corrected."""
    if skew:
        search.progress(f"the forces are recorded {1000.0 * skew:.1f} ms after the inputs: corrected")
        problem, solution = _delayed(problem, solution, skew)
    run = Search(problem, solution, search.candidates, search.progress)
    before = Screen(problem, solution)
    run.run()
    return before, run


def _without(names: Collection[str], problem: LeastSquares, solution: Solution) -> Solution:
    """Return the solution without effects, given their coefficients."""
    simulator, parameters = problem.simulator, solution.parameters.copy()
    indices = [simulator.index[name] for name in names]
    parameters[indices] = simulator.tire.parameters()[indices]
    free = tuple(name for name in solution.free if name not in names)
    return problem.solve(parameters, free, iterations=ITERATIONS)


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
        if _has_skew(aligned[0]) and excess.sum() <= (PREFERRED_ERRORS * _error(excess) if clear else 0.0):
            return aligned[0].simulator.signals.skew
    if relaxed is None:
        return 0.0
    aligned = _aligned(relaxed.problem, relaxed.solution)
    present = _has_skew(aligned[0]) and significant(others - Screen(*aligned).baseline.loss, others)
    return aligned[0].simulator.signals.skew if present else 0.0


def significant(gains: FloatArray, loss: FloatArray) -> bool:
    """Return whether the gains of all blocks satisfy the criteria of an effect."""
    return float(gains.sum()) > max(EFFECT_ERRORS * _error(gains), EFFECT_GAIN * float(loss.sum()))


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


def _error(gains: FloatArray) -> float:
    """Return the standard error of the sum of the gains of all blocks."""
    return float(np.sqrt(len(gains)) * np.std(gains, ddof=1))


def _relaxed(search: Search, problem: LeastSquares, solution: Solution) -> Search | None:
    """Return a search that has accepted the relaxation effects that pass the criteria, or None."""
    relaxing = problem.simulator.book.relaxing_effects
    candidates = {name: one for name, one in search.candidates.items() if name in relaxing}
    trial = Search(problem, solution, candidates, lambda sentence: None)
    for _ in range(RELAXATIONS):
        best = trial.best_effect()
        if best is None or best.name not in relaxing:
            break
        trial.accept(best)
    trial.screen = Screen(trial.problem, trial.solution)
    return trial if trial.found else None
