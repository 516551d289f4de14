"""The search with effects that have states, where the residual of a search without them has memory.

Effects with states can imitate missing effects without states and errors of a recording, and each probe is a
simulation. Therefore they are tested on the residual of a completed search without them. If one of them is significant
there, or if unexplained structure depends on the past, the search is repeated from the baseline model with all effects.
A skew of the recording and an error of the load that follows the direction of slip are then linear disturbances. They
are estimated together with the effects, because these, too, separate growing from falling slip. The result replaces the
first one if it has an effect with states, or if it needs fewer effects.

The repeated search begins with or without the skew that was found before, whichever lets the first effect explain more:
a carcass delays the forces, too. An effect with states is preferred to one without if its gain is larger by two
standard errors. If structure that depends on the past remains beside the first effect and another one gained as much,
the search is repeated without the first effect; that result is taken if it explains more with fewer findings.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace

import numpy as np
import numpy.typing as npt

from ..least_squares import LeastSquares, Solution
from ..probing.candidates import Candidate
from ..probing.effect_probing import Screen
from ..recording.load_error import LAGS, load_error_responses
from ..recording.skew import delay_response
from ..thresholds import EFFECT_GAIN, EFFECT_P, LOAD_ERROR_PRIOR, MAX_SKEW, MIN_SKEW, P_FACTOR
from . import alignment
from .effect_search import Search
from .refits import Tried, consistent

FloatArray = npt.NDArray[np.float64]

#: Names of the disturbances; iterations of a fit with another skew, and number of such fits.
SKEW, LOAD_ERRORS = "skew", tuple(f"load_error_{i}" for i in range(len(LAGS)))
ITERATIONS, ALIGNMENTS = 4, 3
#: Variables of structure that depends on the past.
PAST_ONLY = frozenset({"memory", "dalpha/dt", "dkappa/dt", "dFz/dt"})


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
    if not with_states or not problem.simulator.signals.timed or not _has_memory(first, with_states):
        if first.found:  # they are compared with what was found
            first.candidates = candidates
        return before, first
    progress("the residual depends on the past: the search is repeated with effects that have states")
    starts = {0.0: (problem, solution), before.problem.simulator.signals.skew: (before.problem, before.solution)}
    trials = [Search(*_disturbed(*one), candidates, progress) for one in starts.values()]
    second = min(trials, key=_first_loss) if len(trials) > 1 else trials[0]
    unused = second.copy()
    second.run()
    second = _simpler(second, unused)
    late, second = _aligned(problem, before, second)
    if any(candidates[one.name].has_states for one in second.found) or _findings(second) < _findings(first):
        return late, second
    first.candidates = candidates
    return before, first


def _first_loss(search: Search) -> float:
    """Return the squared misfit that the first effect leaves.

    A state can delay the forces, too: what was taken for a skew of the recording may be one. As large as that, it is
    not undone by a linear disturbance, therefore each effect is tried without it as well.
    """
    best = search.best_effect()
    return float((best or search).screen.baseline.loss.sum())


def _findings(search: Search) -> int:
    return len(search.found) + len(search.structures)


def _depends_on_past(search: Search) -> bool:
    return any(PAST_ONLY.intersection(structure.depends_on) for structure in search.structures)


def _simpler(search: Search, other: Search) -> Search:
    """Return the search, or another one without its first effect, if this explains more by fewer findings.

    It must identify an effect, and leave no structure that depends on the past.

    An effect that resembles the missing one may gain the most alone. Structure that depends on the past then remains,
    which an effect of nearly the same gain would have explained, too.

    Parameters
    ----------
    search : Search
        Completed.
    other : Search
        Not begun.
    """
    if not (search.rivals and _depends_on_past(search)):
        return search
    first, candidates = search.found[0].name, other.candidates
    other.progress(f"structure that depends on the past remains: the search is repeated without {first}")
    other.candidates = {name: one for name, one in candidates.items() if name != first}
    other.run()
    gain = float((search.screen.baseline.loss - other.screen.baseline.loss).sum())
    explains = bool(other.found) and not _depends_on_past(other)
    if not (explains and gain > 0.0 and _findings(other) < _findings(search)):
        return search
    other.candidates = candidates
    return other


def _has_memory(search: Search, candidates: list[Candidate]) -> bool:
    """Return whether structure that a search found, or an effect with states in its residual, depends on the past."""
    if _depends_on_past(search):
        return True
    problem, solution = _disturbed(search.problem, search.solution)
    trial = Search(problem, solution, search.candidates, search.progress)
    trial.screen = Screen(problem, solution)
    tried = trial.tested(trial.forms_of(candidates))
    return any(_is_significant(trial.screen, one, len(tried)) for one in tried)


def _is_significant(screen: Screen, tried: Tried, tests: int) -> bool:
    """Return whether a linear response satisfies the criteria of an effect, as a joint fit does (`Refit.passes`)."""
    response, loss = tried.response, screen.baseline.loss
    gains = loss - response.loss
    material = float(gains.sum()) > EFFECT_GAIN * float(loss.sum()) and consistent(gains)
    return material and response.p_coloured * tests < EFFECT_P and response.p_blocks < P_FACTOR * EFFECT_P


def _disturbed(problem: LeastSquares, solution: Solution) -> tuple[LeastSquares, Solution]:
    """Return problem and solution with a skew of the recording and errors of the load as linear disturbances.

    The errors of the load are removed if the recording would need larger ones than a bench has.
    """
    skew = delay_response(problem.simulator, solution.parameters)[:, :, None]
    loads = load_error_responses(problem.simulator, solution.parameters)
    columns, names = np.concatenate([skew, loads], axis=-1), (SKEW, *LOAD_ERRORS)
    deviations = np.array([MAX_SKEW, *(LOAD_ERROR_PRIOR for _ in LOAD_ERRORS)])
    disturbed = replace(problem, disturbances=problem.disturbances.without(names).extended(names, columns, deviations))
    first = disturbed.at(solution.parameters, solution.free)
    errors = first.disturbance[[disturbed.disturbances.names.index(name) for name in LOAD_ERRORS]]
    if np.all(np.abs(errors) <= 2.0 * LOAD_ERROR_PRIOR):
        return disturbed, first
    disturbed = replace(disturbed, disturbances=disturbed.disturbances.without(LOAD_ERRORS))
    return disturbed, disturbed.at(solution.parameters, solution.free)


def _aligned(recorded: LeastSquares, before: Screen, search: Search) -> tuple[Screen, Search]:
    """Remove the disturbances, and delay the inputs if the skew is significant.

    Parameters
    ----------
    recorded : LeastSquares
        Of the signals without a delay.
    before : Screen
        Of the baseline model, possibly with a delay that was estimated without the effects with states.
    search : Search
        Completed, with the disturbances.
    """
    signals, solution = recorded.simulator.signals, search.solution
    skew = search.problem.simulator.signals.skew
    bare = replace(search.problem, disturbances=search.problem.disturbances.of_recording())  # a form can imitate a skew
    for _ in range(ALIGNMENTS):
        late = replace(bare, simulator=bare.simulator.with_signals(signals.delayed(skew)))
        disturbed, _ = _disturbed(late, late.at(solution.parameters, solution.free))
        solution = disturbed.solve(solution.parameters, solution.free, iterations=ITERATIONS)
        estimate = float(solution.disturbance[disturbed.disturbances.names.index(SKEW)])
        skew = float(np.clip(skew + estimate, -MAX_SKEW, MAX_SKEW))
    problem, at_once = (
        replace(bare, simulator=bare.simulator.with_signals(one)) for one in (signals.delayed(skew), signals)
    )
    fits = [one.solve(solution.parameters, solution.free, iterations=ITERATIONS) for one in (problem, at_once)]
    losses = [Screen(one, fit).baseline.loss for one, fit in zip((problem, at_once), fits, strict=True)]
    if not (MIN_SKEW < abs(skew) < MAX_SKEW and alignment.significant(losses[1] - losses[0], losses[1])):
        problem, fits, skew = at_once, fits[1:], 0.0
    search.progress(f"the forces are recorded {1000.0 * skew:.1f} ms after the inputs" + " (corrected)" * bool(skew))
    search.problem, search.solution = problem, fits[0]
    if before.problem.simulator.signals.skew != skew:
        base = replace(before.problem, simulator=problem.simulator)
        before = Screen(base, base.solve(before.solution.parameters, before.solution.free, iterations=ITERATIONS))
    return before, search
