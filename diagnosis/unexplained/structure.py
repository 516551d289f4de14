"""What is left when nothing known explains it: which variables it depends on, and a proposed formula."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from tirefmu.estimation.block_regression import block_sums, regression

from ..probing.effect_probing import Screen, Trace
from ..thresholds import (
    LEAST_CARRIED,
    LEAST_STRETCHES,
    MOST_TERMS,
    PROBE_BELIEF,
    SHORTLIST,
    STRETCHES,
    STRUCTURE_ERRORS,
    STRUCTURE_GAIN,
    STRUCTURE_P,
    STRUCTURE_P_OF_BLOCKS,
    TERM_ERRORS,
    TERM_ERRORS_OF_VARIABLE,
    TERM_GAIN,
)
from .features import Feature, Place, directions, features, places_of

FloatArray = npt.NDArray[np.float64]

#: Inputs of the steady core: structure in these alone is another form of the base, no missing effect.
CORE_INPUTS = frozenset({"alpha", "kappa", "Fz"})


@dataclass(frozen=True, eq=False)
class Structure:
    """Structure in a residual.

    Attributes
    ----------
    place : Place
    terms : tuple of Feature
    trace : Trace
        Of all terms together.
    gain, gain_error : float
        Of blocked cross-validation, as a share of the squared misfit.
    gains : ndarray, shape (n_blocks,)
    p : float
        Under coloured noise, adjusted for all columns tried.
    columns : ndarray, shape (n_channels, n, n_terms)
        What one unit of each term does to the forces, N and N m.
    carried : ndarray, shape (STRETCHES,)
        Gain in each long stretch of the recording by what the others say, as a share of the squared misfit of all.
    """

    place: Place
    terms: tuple[Feature, ...]
    trace: Trace
    gain: float
    gain_error: float
    gains: FloatArray
    p: float
    columns: FloatArray
    carried: FloatArray

    @property
    def passes(self) -> bool:
        """Whether it is more than noise; the many forms tried make the bar higher than that of a named effect."""
        significant = self.p < STRUCTURE_P and self.trace.p_blocks < STRUCTURE_P_OF_BLOCKS
        return significant and self.gain > max(STRUCTURE_ERRORS * self.gain_error, STRUCTURE_GAIN) and self.carries_over

    @property
    def carries_over(self) -> bool:
        """Whether what it was fitted to elsewhere holds in nearly every part of the recording."""
        everywhere = int(np.sum(self.carried > 0.0)) >= LEAST_STRETCHES
        return everywhere and float(self.carried.sum()) > LEAST_CARRIED * self.gain

    @property
    def depends_on(self) -> tuple[str, ...]:
        """The variables, sorted."""
        return tuple(sorted(frozenset(self.place.carries).union(*(term.depends_on for term in self.terms))))

    @property
    def written(self) -> bool:
        """Whether an effect file can say it."""
        return all(term.written for term in self.terms)

    @property
    def formula(self) -> str:
        """The proposal as a reader sees it."""
        return self.formula_with(self.trace.estimate)

    def formula_with(self, sizes: Sequence[float] | FloatArray) -> str:
        """Return the proposal with coefficients of these sizes.

        Parameters
        ----------
        sizes : sequence of float
            By term.
        """
        terms = " ".join(f"{value:+.3g}*{_told(term)}" for value, term in zip(sizes, self.terms, strict=True))
        head = "1 " if self.place.how == "factor" else ""
        return f"{' and '.join(self.place.quantities)}, {self.place.how}: {head}{terms}"


def _told(term: Feature) -> str:
    return f"({term.text})" if " " in term.text else term.text


def structure_of(screen: Screen) -> Structure | None:
    """Return the structure that explains most of a residual, or None where there is none at all.

    Parameters
    ----------
    screen : Screen
        Its noise learnt.
    """
    columns, what = _dictionary(screen)
    if not what:
        return None
    scores = _scores(screen, columns)
    best: tuple[float, int, Trace] | None = None
    for i in np.argsort(-scores)[:SHORTLIST]:
        trace = screen.trace(columns[:, :, [i]])
        loss = float(trace.loss.sum())
        if best is None or loss < best[0]:
            best = (loss, int(i), trace)
    assert best is not None
    chosen, trace = [best[1]], best[2]
    chosen, trace = _grown(screen, columns, what, chosen, trace)
    place = what[chosen[0]][0]
    gains = screen.base.loss - trace.loss
    total = float(screen.base.loss.sum())
    error = float(np.sqrt(len(gains)) * np.std(gains, ddof=1)) / total
    p = min(1.0, trace.p_coloured * len(what))
    terms = tuple(what[i][1] for i in chosen)
    acts = directions(screen)[place.name]
    plain = np.stack([acts * term.values for term in terms], axis=-1)
    carried = _carried(screen, trace.columns)
    return Structure(place, terms, trace, float(gains.sum()) / total, error, gains, p, plain, carried)


def _carried(screen: Screen, columns: FloatArray) -> FloatArray:
    """Return the gain of columns in each long stretch when it is left out, as a share of the squared misfit of all."""
    marks = np.round(np.linspace(0, screen.n_blocks, STRETCHES + 1)).astype(int)
    edges, n_columns = screen.edges[marks], columns.shape[-1]
    without = regression(block_sums(screen.tangent, screen.residual, edges), screen.belief, screen.pull)
    whole = np.concatenate([screen.tangent, columns], axis=-1)
    belief = np.concatenate([screen.belief, np.full(n_columns, PROBE_BELIEF**-2.0)])
    pull = np.concatenate([screen.pull, np.zeros(n_columns)])
    beside = regression(block_sums(whole, screen.residual, edges), belief, pull)
    return np.asarray((without.loss - beside.loss) / without.loss.sum())


def _grown(
    screen: Screen, columns: FloatArray, what: list[tuple[Place, Feature]], chosen: list[int], trace: Trace
) -> tuple[list[int], Trace]:
    """Add terms at the same place for as long as they are worth it.

    Beside those that explain most, the parts of a product are tried: from where its parts are counted is arbitrary, and
    with them it does not matter (marginality: Nelder, A reformulation of linear models, 1977).
    """
    place = what[chosen[0]][0]
    same = [i for i, (other, _) in enumerate(what) if other == place]
    while len(chosen) < MOST_TERMS:
        fitted = columns[:, :, chosen] @ trace.estimate
        rest = screen.residual - screen.project(fitted[:, :, None])[:, :, 0]
        order = [same[k] for k in np.argsort(-_scores(screen, columns[:, :, same], rest))]
        parts = {part for i in chosen for part in what[i][1].parts}
        options = [*order[:4], *(i for i in order[4:] if what[i][1].text in parts)]
        traces = [(screen.trace(columns[:, :, [*chosen, i]]), i) for i in options if i not in chosen]
        known = frozenset().union(place.carries, *(what[i][1].depends_on for i in chosen))
        best = _best(screen, trace, [(more, i, what[i][1].depends_on <= known) for more, i in traces])
        if best is None:
            break
        trace, i = best
        chosen = [*chosen, i]
    return chosen, trace


def _best(screen: Screen, trace: Trace, richer: list[tuple[Trace, int, bool]]) -> tuple[Trace, int] | None:
    """Return the richer trace that is most worth it, or None; one without a further variable comes first.

    Parameters
    ----------
    screen : Screen
    trace : Trace
        So far.
    richer : list of (Trace, int, bool)
        With the added column, and whether its variables are known.
    """
    least = TERM_GAIN * float(np.sum(screen.base.loss - trace.loss))
    for wanted in (True, False):
        errors = TERM_ERRORS if wanted else TERM_ERRORS_OF_VARIABLE
        worth = [(more, i) for more, i, known in richer if known == wanted and _adds(trace, more, errors) > least]
        if worth:
            return min(worth, key=lambda one: float(one[0].loss.sum()))
    return None


def _adds(trace: Trace, more: Trace, errors: float) -> float:
    """Return what a richer trace gains in cross-validation; 0 where that is within so many standard errors."""
    gains = trace.loss - more.loss
    error = float(np.sqrt(len(gains)) * np.std(gains, ddof=1))
    return float(gains.sum()) if float(gains.sum()) > errors * error else 0.0


def _dictionary(screen: Screen) -> tuple[FloatArray, list[tuple[Place, Feature]]]:
    """Return columns, shape (n_channels, n, m), and what each is."""
    signals, tire = screen.signals, screen.problem.simulator.tire
    even, odd = features(signals, tire)
    own = [f for f in even if f.written]
    pairs = [a * b for i, a in enumerate(own) for b in own[i:]]
    turned = [a * b for a in odd for b in own]
    at = {name: screen.problem.root * acts for name, acts in directions(screen).items()}
    what: list[tuple[Place, Feature]] = []
    for place in places_of(screen.problem.simulator.book):
        if not np.any(at[place.name]):
            continue
        allowed = [*even, *pairs] if place.how == "factor" else [*odd, *turned, *even]
        what += [(place, feature) for feature in allowed]
    columns = np.stack([at[place.name] * feature.values for place, feature in what], axis=-1)
    return columns, what


def _scores(screen: Screen, columns: FloatArray, residual: FloatArray | None = None) -> FloatArray:
    """Return how much of the squared residual each column explains by itself, the base's freedom allowed for."""
    rest = (screen.residual if residual is None else residual).ravel()
    flat = columns.reshape(len(rest), -1)
    tangent = screen.tangent.reshape(len(rest), -1)
    cross = tangent.T @ flat
    inner = screen.base.inverse @ cross
    power = np.einsum("nk,nk->k", flat, flat) - np.einsum("qk,qk->k", cross, inner)
    target = flat.T @ rest - inner.T @ (tangent.T @ rest)
    whole = np.einsum("nk,nk->k", flat, flat)
    seen = power > 1e-3 * whole
    return np.where(seen, target**2 / np.where(seen, power, 1.0), 0.0)
