"""Candidates fitted jointly with the baseline: their gain, the acceptance criteria, and the preferred one."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from tirefmu.estimation.block_regression import error_of_sum, limited
from tirefmu.symbolic.detection import Form

from ..least_squares import Solution
from ..probing.candidates import Candidate
from ..probing.effect_probing import Response, Screen
from ..thresholds import (
    EFFECT_ERRORS,
    EFFECT_GAIN,
    EFFECT_P,
    LARGEST_SHARE,
    P_FACTOR,
    PREFERRED_ERRORS,
)

FloatArray = npt.NDArray[np.float64]

#: Prefix of the names of refinements; the effect, or "core", follows.
REFINEMENT = "refinement of "


@dataclass(frozen=True, eq=False)
class Refit:
    """A candidate fitted jointly with the baseline.

    Attributes
    ----------
    name : str
    form : Form
    solution : Solution
    screen : Screen
        Linearization at the solution.
    p : float
        p-value, adjusted for all forms tested.
    gain, gain_error : float
        Cross-validated gain, as a share of the squared misfit of the baseline, and its standard error.
    gains : ndarray, shape (n_blocks,)
        Gain of each time block, in squared noise standard deviations.
    response : Response
    """

    name: str
    form: Form
    solution: Solution
    screen: Screen
    p: float
    gain: float
    gain_error: float
    gains: FloatArray
    response: Response

    @property
    def passes(self) -> bool:
        """Whether the gain is significant and material."""
        significant = self.p < EFFECT_P and self.response.p_blocks < P_FACTOR * EFFECT_P
        return significant and self.gain > EFFECT_GAIN and consistent(self.gains)


@dataclass(frozen=True, eq=False)
class Tried:
    """A form of a candidate with its response in the residual."""

    name: str
    form: Form
    response: Response


def consistent(gains: FloatArray) -> bool:
    """Return whether the gains of the blocks, of which none may dominate, exceed their standard error sufficiently.

    Parameters
    ----------
    gains : ndarray, shape (n_blocks,)
        Cross-validated.
    """
    counted = limited(gains, LARGEST_SHARE)
    return float(counted.sum()) > EFFECT_ERRORS * error_of_sum(counted)


def preferred(refits: list[Refit], candidates: Mapping[str, Candidate], found: Collection[str] = ()) -> Refit:
    """Return the best of several refits that pass.

    The one with the largest gain is preferred. A refinement of the baseline model must exceed an effect, and an effect
    another that it contains, by `PREFERRED_ERRORS` standard errors of the difference; so must an effect with states one
    without. A refinement of an effect that was identified in this recording has no such disadvantage, because the form
    of that effect is uncertain.

    Parameters
    ----------
    refits : list of Refit
    candidates : mapping of str to Candidate
    found : collection of str
        Names of the identified effects.
    """
    best = max(refits, key=lambda refit: refit.gain)
    for other in sorted(refits, key=lambda refit: -refit.gain):
        if other is best:
            continue
        difference = limited(best.gains - other.gains, LARGEST_SHARE)
        contains = candidates[best.name].contains == other.name if best.name in candidates else False
        stateful = _has_states(best, candidates) and not _has_states(other, candidates)
        refinement = best.name.startswith(REFINEMENT) and not other.name.startswith(REFINEMENT)
        refinement = refinement and best.name.removeprefix(REFINEMENT) not in found
        if (contains or refinement or stateful) and difference.sum() <= PREFERRED_ERRORS * error_of_sum(difference):
            best = other
    return best


def rivals(best: Refit, passing: Collection[Refit]) -> frozenset[str]:
    """Return the effects whose gain is not significantly smaller than that of the preferred one.

    Parameters
    ----------
    best : Refit
    passing : collection of Refit
        All that pass the criteria, with the preferred one.
    """
    near = set()
    for other in passing:
        difference = limited(best.gains - other.gains, LARGEST_SHARE)
        if float(difference.sum()) <= PREFERRED_ERRORS * error_of_sum(difference):
            near.add(other.name)
    return frozenset(name for name in near - {best.name} if not name.startswith(REFINEMENT))


def _has_states(refit: Refit, candidates: Mapping[str, Candidate]) -> bool:
    return refit.name in candidates and candidates[refit.name].has_states


def distinct(tried: list[Tried]) -> list[Tried]:
    """Return the first form of each effect, in order; all refinements are distinct.

    A later form that is a part of it is preferred, unless the loss is larger by `PREFERRED_ERRORS` standard errors.
    """
    seen: dict[str, Tried] = {}
    for one in tried:
        key = one.name if not one.name.startswith(REFINEMENT) else f"{one.name}{one.form.free}"
        best = seen.setdefault(key, one)
        excess = one.response.loss - best.response.loss
        if set(one.form.free) < set(best.form.free) and excess.sum() <= PREFERRED_ERRORS * error_of_sum(excess):
            seen[key] = one
    return list(seen.values())
