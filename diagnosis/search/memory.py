"""The search with effects that have states, where the residual of a search without them has memory.

Effects with states can imitate a missing effect without states and errors of a recording, and each probe is a
simulation. Therefore they are tested on the residual of a completed search without them. If one of them is significant
there, the search is repeated from the baseline model with all effects. A skew of the recording is then a linear
disturbance, estimated together with the effects, because skew and memory both separate rising from falling slip.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace

import numpy as np
import numpy.typing as npt

from ..least_squares import LeastSquares, Solution
from ..probing.candidates import Candidate
from ..probing.effect_probing import Screen
from ..recording.skew import delay_response
from ..thresholds import EFFECT_ERRORS, EFFECT_GAIN, EFFECT_P, EFFECT_P_OF_BLOCKS, MAX_SKEW, MIN_SKEW
from . import alignment
from .effect_search import Search
from .refits import Tried

FloatArray = npt.NDArray[np.float64]

#: Name of the disturbance; iterations of a fit with another skew, and number of such fits.
SKEW, ITERATIONS, ALIGNMENTS = "skew", 4, 2


def searched(
    problem: LeastSquares, solution: Solution, candidates: Mapping[str, Candidate], progress: Callable[[str], None]
) -> tuple[Screen, Search]:
    """Search for missing effects.

    Parameters
    ----------
    problem : LeastSquares
    solution : Solution
        Of the baseline model.
    candidates : mapping of str to Candidate
    progress : callable
        Called with a sentence at each step.

    Returns
    -------
    before : Screen
        Of the baseline model.
    search : Search
        Completed.
    """
    at_once = {name: one for name, one in candidates.items() if not one.has_states}
    before, first = alignment.searched(Search(problem, solution, at_once, progress))
    with_states = [one for one in candidates.values() if one.has_states]
    first.candidates = candidates
    if not with_states or not problem.simulator.signals.timed or not _has_memory(first, with_states):
        return before, first
    progress("the residual depends on the past: the search is repeated with effects that have states")
    skewed, start = _with_skew(before.problem, before.solution)
    second = Search(skewed, start, candidates, progress)
    second.run()
    if not any(candidates[refit.name].has_states for refit in second.found):
        return before, first
    return _aligned(problem, before, second)


def _has_memory(search: Search, candidates: list[Candidate]) -> bool:
    """Return whether an effect with states is significant in the residual of a search."""
    problem, solution = _with_skew(search.problem, search.solution)
    trial = Search(problem, solution, search.candidates, search.progress)
    trial.screen = Screen(problem, solution)
    tried = trial.tested(trial.forms_of(candidates))
    return any(_is_significant(trial.screen, one, len(tried)) for one in tried)


def _is_significant(screen: Screen, tried: Tried, tests: int) -> bool:
    """Return whether a linear response satisfies the criteria of an effect."""
    response, loss = tried.response, screen.baseline.loss
    gains = loss - response.loss
    error = float(np.sqrt(len(gains)) * np.std(gains, ddof=1))
    material = float(gains.sum()) > max(EFFECT_ERRORS * error, EFFECT_GAIN * float(loss.sum()))
    return material and response.p_coloured * tests < EFFECT_P and response.p_blocks < EFFECT_P_OF_BLOCKS


def _with_skew(problem: LeastSquares, solution: Solution) -> tuple[LeastSquares, Solution]:
    """Return problem and solution with a skew of the recording as a linear disturbance."""
    column = delay_response(problem.simulator, solution.parameters)[:, :, None]
    disturbances = problem.disturbances.without((SKEW,)).extended((SKEW,), column, np.array([MAX_SKEW]))
    skewed = replace(problem, disturbances=disturbances)
    return skewed, skewed.at(solution.parameters, solution.free)


def _aligned(recorded: LeastSquares, before: Screen, search: Search) -> tuple[Screen, Search]:
    """Replace the disturbance by delayed inputs, if the skew is significant.

    Parameters
    ----------
    recorded : LeastSquares
        Of the signals without a delay.
    before : Screen
        Of the baseline model, possibly with a delay that was estimated without the effects with states.
    search : Search
        Completed, with the disturbance.
    """
    signals, problem, solution = recorded.simulator.signals, search.problem, search.solution
    for _ in range(ALIGNMENTS):
        estimate = float(solution.disturbance[problem.disturbances.names.index(SKEW)])
        skew = float(np.clip(problem.simulator.signals.skew + estimate, -MAX_SKEW, MAX_SKEW))
        late = replace(problem, simulator=problem.simulator.with_signals(signals.delayed(skew)))
        problem, solution = _with_skew(late, late.solve(solution.parameters, solution.free, iterations=ITERATIONS))
    problem = replace(problem, disturbances=problem.disturbances.without((SKEW,)))
    at_once = replace(problem, simulator=problem.simulator.with_signals(signals))
    fits = [one.solve(solution.parameters, solution.free, iterations=ITERATIONS) for one in (problem, at_once)]
    losses = [Screen(one, fit).baseline.loss for one, fit in zip((problem, at_once), fits, strict=True)]
    skew = problem.simulator.signals.skew
    if not (MIN_SKEW < abs(skew) < MAX_SKEW and alignment.significant(losses[1] - losses[0], losses[1])):
        problem, fits, skew = at_once, fits[1:], 0.0
    search.progress(f"the forces are recorded {1000.0 * skew:.1f} ms after the inputs" + " (corrected)" * bool(skew))
    search.problem, search.solution = problem, fits[0]
    if before.problem.simulator.signals.skew != skew:
        base = replace(before.problem, simulator=problem.simulator)
        before = Screen(base, base.solve(before.solution.parameters, before.solution.free, iterations=ITERATIONS))
    return before, search
