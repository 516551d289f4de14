"""What is left when nothing known explains it: which variables it depends on, and a proposed formula."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from .features import PLACES, Feature, Place, directions, features
from .screening import Screen, Trace

FloatArray = npt.NDArray[np.float64]

#: Terms that a proposed formula has at most, and what a further term has to add: as a share of what the first ones
#: explain, and in standard errors.
MOST_TERMS = 3
WORTH = 0.01
WORTH_ERRORS = 1.5
#: What structure has to pass.
LARGEST_P = 1e-4
LARGEST_P_OF_BLOCKS = 1e-3
LEAST_ERRORS = 1.2
LEAST_GAIN = 0.03
#: Columns whose cross-validation is worked out, of the many that are correlated with the residual.
SHORTLIST = 12
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
    """

    place: Place
    terms: tuple[Feature, ...]
    trace: Trace
    gain: float
    gain_error: float
    gains: FloatArray
    p: float
    columns: FloatArray

    @property
    def passes(self) -> bool:
        """Whether it is more than noise; the many forms tried make the bar higher than that of a named effect."""
        significant = self.p < LARGEST_P and self.trace.p_blocks < LARGEST_P_OF_BLOCKS
        return significant and self.gain > max(LEAST_ERRORS * self.gain_error, LEAST_GAIN)

    @property
    def depends_on(self) -> tuple[str, ...]:
        """The variables, sorted."""
        return tuple(sorted(frozenset(self.place.carries).union(*(term.depends_on for term in self.terms))))

    @property
    def of_the_base(self) -> bool:
        """Whether it is another form of the steady core formula."""
        return set(self.depends_on) <= CORE_INPUTS

    @property
    def written(self) -> bool:
        """Whether an effect file can say it."""
        return all(term.written for term in self.terms)

    @property
    def formula(self) -> str:
        """The proposal as a reader sees it."""
        size = self.trace.estimate
        terms = " ".join(f"{value:+.3g}*{_told(term)}" for value, term in zip(size, self.terms, strict=True))
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
    return Structure(place, terms, trace, float(gains.sum()) / total, error, gains, p, plain)


def _grown(
    screen: Screen, columns: FloatArray, what: list[tuple[Place, Feature]], chosen: list[int], trace: Trace
) -> tuple[list[int], Trace]:
    """Add terms at the same place for as long as they are worth it."""
    place = what[chosen[0]][0]
    same = [i for i, (other, _) in enumerate(what) if other is place]
    start = float(screen.base.loss.sum())
    while len(chosen) < MOST_TERMS:
        fitted = columns[:, :, chosen] @ trace.estimate
        rest = screen.residual - screen.project(fitted[:, :, None])[:, :, 0]
        scores = _scores(screen, columns[:, :, same], rest)
        options = [same[k] for k in np.argsort(-scores)[:4] if same[k] not in chosen]
        traces = [(screen.trace(columns[:, :, [*chosen, i]]), i) for i in options]
        if not traces:
            break
        more, i = min(traces, key=lambda one: float(one[0].loss.sum()))
        gained = start - float(trace.loss.sum())
        adds = trace.loss - more.loss
        error = float(np.sqrt(len(adds)) * np.std(adds, ddof=1))
        if float(adds.sum()) < max(WORTH * gained, WORTH_ERRORS * error):
            break
        chosen, trace = [*chosen, i], more
    return chosen, trace


def _dictionary(screen: Screen) -> tuple[FloatArray, list[tuple[Place, Feature]]]:
    """Return columns, shape (n_channels, n, m), and what each is."""
    signals, tire = screen.signals, screen.problem.simulator.tire
    even, odd = features(signals, tire)
    own = [f for f in even if f.written]
    pairs = [a * b for i, a in enumerate(own) for b in own[i:]]
    turned = [a * b for a in odd for b in own]
    at = {name: screen.problem.root * acts for name, acts in directions(screen).items()}
    what: list[tuple[Place, Feature]] = []
    for place in PLACES:
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
