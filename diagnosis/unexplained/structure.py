"""Unexplained structure: the variables that the residual depends on, and a proposed formula."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from tirefmu.estimation.block_regression import block_sums, error_of_sum, regression

from ..probing.effect_probing import Response, Screen
from ..thresholds import (
    EFFECT_P,
    MAX_TERMS,
    MIN_RETAINED_GAIN,
    MIN_STRETCHES,
    P_FACTOR,
    PREFERRED_ERRORS,
    PROBE_PRIOR,
    SHORTLIST,
    STRETCHES,
    STRUCTURE_ERRORS,
    STRUCTURE_GAIN,
    TERM_ERRORS_OF_VARIABLE,
)
from .features import Feature, Location, determined, directions, features, locations_of

FloatArray = npt.NDArray[np.float64]

#: Inputs of the steady-state core. Structure in these alone is an error of the functional form, not a missing effect.
CORE_INPUTS = frozenset({"alpha", "kappa", "Fz"})


@dataclass(frozen=True, eq=False)
class Structure:
    """Structure in a residual.

    Attributes
    ----------
    location : Location
    terms : tuple of Feature
    response : Response
        Response of all terms together.
    gain, gain_error : float
        Gain in blocked cross-validation, as a share of the squared misfit, and its standard error.
    gains : ndarray, shape (n_blocks,)
    p : float
        p-value under coloured noise, adjusted for all columns tested.
    columns : ndarray, shape (n_channels, n, n_terms)
        Change of the forces per unit of each term, N and N m.
    stretch_gains : ndarray, shape (STRETCHES,)
        Gain in each long stretch, estimated from the other stretches, as a share of the total squared misfit.
    tests : int
        Number of columns tested.
    """

    location: Location
    terms: tuple[Feature, ...]
    response: Response
    gain: float
    gain_error: float
    gains: FloatArray
    p: float
    columns: FloatArray
    stretch_gains: FloatArray
    tests: int

    @property
    def passes(self) -> bool:
        """Whether the gain is significant; the criteria are stricter than for effects, as many forms are tested."""
        significant = self.p < EFFECT_P / P_FACTOR and self.response.p_blocks < EFFECT_P
        return significant and self.gain > max(STRUCTURE_ERRORS * self.gain_error, STRUCTURE_GAIN) and self.generalizes

    @property
    def generalizes(self) -> bool:
        """Whether the structure, estimated from the other stretches, is present in nearly every stretch."""
        everywhere = int(np.sum(self.stretch_gains > 0.0)) >= MIN_STRETCHES
        return everywhere and float(self.stretch_gains.sum()) > MIN_RETAINED_GAIN * self.gain

    @property
    def depends_on(self) -> tuple[str, ...]:
        """The variables, sorted."""
        return tuple(sorted(frozenset(self.location.proportional_to).union(*(term.depends_on for term in self.terms))))

    @property
    def formula(self) -> str:
        """The proposed formula as text."""
        return self.formula_with(self.response.estimate)

    def formula_with(self, sizes: Sequence[float] | FloatArray) -> str:
        """Return the proposed formula with given coefficients.

        Parameters
        ----------
        sizes : sequence of float
            One per term.
        """
        terms = " ".join(f"{value:+.3g}*{_bracketed(term)}" for value, term in zip(sizes, self.terms, strict=True))
        head = "1 " if self.location.how == "factor" else ""
        return f"{' and '.join(self.location.quantities)}, {self.location.how}: {head}{terms}"


def _bracketed(term: Feature) -> str:
    return f"({term.text})" if " " in term.text else term.text


def structure_of(screen: Screen) -> Structure | None:
    """Return the structure that explains most of a residual, or None if there are no features.

    Parameters
    ----------
    screen : Screen
        With estimated noise (`learn_noise`).
    """
    columns, candidates = _dictionary(screen)
    if not candidates:
        return None
    scores = _scores(screen, columns)
    best: tuple[float, int, Response] | None = None
    for i in np.argsort(-scores)[:SHORTLIST]:
        response = screen.response(columns[:, :, [i]])
        loss = float(response.loss.sum())
        if best is None or loss < best[0]:
            best = (loss, int(i), response)
    assert best is not None
    chosen, response = [best[1]], best[2]
    chosen, response = _extended_terms(screen, columns, candidates, chosen, response)
    return _evaluated(
        screen, candidates[chosen[0]][0], tuple(candidates[i][1] for i in chosen), response, len(candidates)
    )


def core_part(screen: Screen, structure: Structure) -> Structure | None:
    """Return the terms of a structure that depend on the inputs of the steady-state core alone, or None.

    A formula that gathers an error of the functional form and a missing effect says of neither what it is.

    Parameters
    ----------
    screen : Screen
        Of the residual that has the structure.
    structure : Structure
    """
    proportional = frozenset(structure.location.proportional_to)
    of_core = [i for i, term in enumerate(structure.terms) if proportional | term.depends_on <= CORE_INPUTS]
    if not of_core:
        return None
    terms = tuple(structure.terms[i] for i in of_core)
    response = screen.response(structure.response.columns[:, :, of_core])
    return _evaluated(screen, structure.location, terms, response, structure.tests)


def _evaluated(
    screen: Screen, location: Location, terms: tuple[Feature, ...], response: Response, tests: int
) -> Structure:
    """Return terms at a location with their gains."""
    gains = screen.baseline.loss - response.loss
    total = float(screen.baseline.loss.sum())
    gain, error = float(gains.sum()) / total, error_of_sum(gains) / total
    p = min(1.0, response.p_coloured * tests)
    acts = directions(screen.problem.simulator, screen.solution.parameters)[location.name]
    unweighted = np.stack([acts * term.values for term in terms], axis=-1)
    stretch_gains = _stretch_gains(screen, response.columns)
    return Structure(location, terms, response, gain, error, gains, p, unweighted, stretch_gains, tests)


def _stretch_gains(screen: Screen, columns: FloatArray) -> FloatArray:
    """Return the cross-validated gain of columns in each long stretch, as a share of the total squared misfit."""
    edges, n_columns = screen.stretches(STRETCHES), columns.shape[-1]
    baseline = screen.stretch_losses(edges)
    total = np.concatenate([screen.tangent, columns], axis=-1)
    prior = np.concatenate([screen.prior_precision, np.full(n_columns, PROBE_PRIOR**-2.0)])
    gradient = np.concatenate([screen.prior_gradient, np.zeros(n_columns)])
    extended = regression(block_sums(total, screen.residual, edges), prior, gradient)
    return np.asarray((baseline - extended.loss) / baseline.sum())


def _extended_terms(
    screen: Screen,
    columns: FloatArray,
    candidates: list[tuple[Location, Feature]],
    chosen: list[int],
    response: Response,
) -> tuple[list[int], Response]:
    """Add terms at the same location while their gain is significant.

    Tested are the terms that explain most, and the factors of products: with these the result does not depend on the
    arbitrary origin of each factor (marginality: Nelder, A reformulation of linear models, 1977).
    """
    location = candidates[chosen[0]][0]
    same = [i for i, (other, _) in enumerate(candidates) if other == location]
    while len(chosen) < MAX_TERMS:
        fitted = columns[:, :, chosen] @ response.estimate
        rest = screen.residual - screen.project(fitted[:, :, None])[:, :, 0]
        order = [same[k] for k in np.argsort(-_scores(screen, columns[:, :, same], rest))]
        parts = {part for i in chosen for part in candidates[i][1].parts}
        options = [*order[:4], *(i for i in order[4:] if candidates[i][1].text in parts)]
        responses = [(screen.response(columns[:, :, [*chosen, i]]), i) for i in options if i not in chosen]
        known = frozenset().union(location.proportional_to, *(candidates[i][1].depends_on for i in chosen))
        best = _best(screen, response, [(more, i, candidates[i][1].depends_on <= known) for more, i in responses])
        if best is None:
            break
        response, i = best
        chosen = [*chosen, i]
    return chosen, response


def _best(screen: Screen, response: Response, richer: list[tuple[Response, int, bool]]) -> tuple[Response, int] | None:
    """Return the extended response with the largest significant gain, or None; known variables have priority.

    Parameters
    ----------
    screen : Screen
    response : Response
        Of the current terms.
    richer : list of (Response, int, bool)
        Extended response, index of the added column, and whether its variables are already in the formula.
    """
    least = STRUCTURE_GAIN * float(np.sum(screen.baseline.loss - response.loss))
    for known_only in (True, False):
        errors = PREFERRED_ERRORS if known_only else TERM_ERRORS_OF_VARIABLE
        gaining = [
            (more, i) for more, i, known in richer if known == known_only and _adds(response, more, errors) > least
        ]
        if gaining:
            return min(gaining, key=lambda one: float(one[0].loss.sum()))
    return None


def _adds(response: Response, more: Response, errors: float) -> float:
    """Return the cross-validated gain of an extended response; 0 if it is within `errors` standard errors."""
    gains = response.loss - more.loss
    error = error_of_sum(gains)
    return float(gains.sum()) if float(gains.sum()) > errors * error else 0.0


def _dictionary(screen: Screen) -> tuple[FloatArray, list[tuple[Location, Feature]]]:
    """Return columns, shape (n_channels, n, m), with the location and feature of each."""
    signals, tire = screen.signals, screen.problem.simulator.tire
    even, odd = features(signals, tire)
    expressible = [f for f in even if f.expressible]
    pairs = [a * b for i, a in enumerate(expressible) for b in expressible[i:]]
    odd_pairs = [a * b for a in odd for b in expressible]
    at = {
        name: screen.problem.inverse_noise * acts
        for name, acts in directions(screen.problem.simulator, screen.solution.parameters).items()
    }
    candidates: list[tuple[Location, Feature]] = []
    for location in locations_of(screen.problem.simulator.symbolic_model):
        if not np.any(at[location.name]):
            continue
        allowed = [*even, *pairs] if location.how == "factor" else [*odd, *odd_pairs, *even]
        candidates += [(location, feature) for feature in allowed if determined(location, feature, signals, tire)]
    columns = np.stack([at[location.name] * feature.values for location, feature in candidates], axis=-1)
    return columns, candidates


def _scores(screen: Screen, columns: FloatArray, residual: FloatArray | None = None) -> FloatArray:
    """Return the squared residual that each column alone explains, with the baseline model projected out."""
    rest = (screen.residual if residual is None else residual).ravel()
    flat = columns.reshape(len(rest), -1)
    tangent = screen.tangent.reshape(len(rest), -1)
    cross = tangent.T @ flat
    inner = screen.baseline.inverse @ cross
    power = np.einsum("nk,nk->k", flat, flat) - np.einsum("qk,qk->k", cross, inner)
    target = flat.T @ rest - inner.T @ (tangent.T @ rest)
    total = np.einsum("nk,nk->k", flat, flat)
    independent = power > 1e-3 * total
    return np.where(independent, target**2 / np.where(independent, power, 1.0), 0.0)
