"""Alignment of forces and inputs in time: a skew of the recording is corrected before effects are searched for.

A skew delays all forces by the same time, relaxation delays the response of each slip by a distance. At one speed with
one slip they are the same. The skew is preferred, because it is a property of the bench, unless relaxation explains
significantly more.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from ..least_squares import LeastSquares, Solution
from ..probing.effect_probing import Screen
from ..recording.skew import delay_response
from ..thresholds import EFFECT_ERRORS, EFFECT_GAIN, MAX_SKEW, MIN_SKEW, PREFERRED_ERRORS
from .effect_search import Search

#: Iterations of the estimate; each corrects the delay that the previous ones left.
STEPS = 3
#: Number of relaxation effects that are compared with a skew, together.
RELAXATIONS = 2


def align(search: Search) -> None:
    """Correct a skew between forces and inputs if the recording has one.

    Parameters
    ----------
    search : Search
        Before its first round; its problem and solution are replaced.
    """
    problem, solution = search.problem, search.solution
    if not problem.simulator.signals.timed:
        return
    before = Screen(problem, solution)
    shifted, fitted = problem, solution
    for _ in range(STEPS):
        shifted, fitted = _shifted(shifted, fitted)
        if abs(shifted.simulator.signals.skew) < 0.5 * MIN_SKEW:
            return
    skew = shifted.simulator.signals.skew
    gains = before.baseline.loss - Screen(shifted, fitted).baseline.loss
    error = float(np.sqrt(len(gains)) * np.std(gains, ddof=1))
    least = max(EFFECT_ERRORS * error, EFFECT_GAIN * float(before.baseline.loss.sum()))
    if not MIN_SKEW < abs(skew) < MAX_SKEW or gains.sum() < least:
        return
    relaxed = _relaxed(search)
    if relaxed is not None:
        difference = (before.baseline.loss - relaxed.baseline.loss) - gains
        error = float(np.sqrt(len(difference)) * np.std(difference, ddof=1))
        if difference.sum() > PREFERRED_ERRORS * error:
            return
    search.problem, search.solution = shifted, fitted
    search.progress(f"the forces are recorded {1000.0 * skew:.1f} ms after the inputs: corrected")


def _shifted(problem: LeastSquares, solution: Solution) -> tuple[LeastSquares, Solution]:
    """Return problem and solution with the inputs delayed by the skew that the residual contains."""
    simulator = problem.simulator
    column = delay_response(simulator, solution.parameters)[:, :, None]
    extended = problem.disturbances.extended(("skew",), column, np.array([MAX_SKEW]))
    linear = replace(problem, disturbances=extended).solve(solution.parameters, solution.free, iterations=3)
    delay = float(np.clip(linear.disturbance[-1], -MAX_SKEW, MAX_SKEW))
    moved = replace(problem, simulator=simulator.with_signals(simulator.signals.delayed(delay)))
    return moved, moved.solve(linear.parameters, solution.free, iterations=3)


def _relaxed(search: Search) -> Screen | None:
    """Return the screen of the model with the relaxation effects that pass the criteria, or None."""
    relaxing = search.problem.simulator.book.relaxing_effects
    candidates = {name: one for name, one in search.candidates.items() if name in relaxing}
    trial = Search(search.problem, search.solution, candidates, lambda sentence: None)
    for _ in range(RELAXATIONS):
        best = trial.best_effect()
        if best is None or best.name not in relaxing:
            break
        trial.accept(best)
    return Screen(trial.problem, trial.solution) if trial.found else None
