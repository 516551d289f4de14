"""The most probable meaning of the columns of a table, compared with what the table claims."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass

from ....numerics.ties import graded
from ...recording import Recording, once
from .hypotheses import CONVENTION_COST, Hypothesis, combined, hypotheses
from .sampled_rows import SampledRows
from .traits import ONE_SIDED, VANISHED, WRONG_THRUST, Traits, traits_of

#: Logarithms of odds, costs included: above the first, another reading of a table is clearly better than the claimed
#: one; below the second, two readings cannot be separated.
CLEARLY, HARDLY = 4.0, 3.0
#: Hypotheses of one fault each that are combined with a second and a third one.
COMBINED = 6
#: Largest number of faults of one table.
MAX_FAULTS = 3


@dataclass(frozen=True)
class TableReading:
    """A reading of a table with its traits. `score`: graded minus logarithm of its probability, but a constant."""

    hypothesis: Hypothesis
    traits: Traits
    score: float


@dataclass(frozen=True)
class Readings:
    """The claimed reading of a table, and better ones.

    `claimed`: the reading of the file. `better`: readings that are clearly better, the best one first, with those that
    cannot be separated from it; empty if the claim stands. `mirrored`: other signs of the same columns, which only the
    direction of the camber thrust excludes.
    """

    claimed: TableReading
    better: tuple[TableReading, ...] = ()
    mirrored: tuple[TableReading, ...] = ()


@once
def explanation(recording: Recording) -> Readings:
    """Return the best readings of a recording compared with the claimed one.

    `recording`: in the signs and units that its file or caller states. Returns: without better readings if none is
    clearly better.

    >>> import numpy as np, pandas as pd
    >>> alpha = np.linspace(-0.2, 0.2, 200)
    >>> table = pd.DataFrame({"alpha": alpha, "Fz": 900.0 / 4.448, "Fy": -1300.0 * np.tanh(14.0 * alpha)})
    >>> explanation(Recording(table, "iso", "a.csv")).better[0].hypothesis.advice("iso")
    "--units Fz=lbf, or the header 'Fz [lbf]'"
    """
    claim = Hypothesis(recording.signs)
    traits = _traits(recording)
    claimed = TableReading(claim, traits, graded(traits.penalty))
    # No reading is better than certain: a claim of a small penalty stands, without the search.
    if claimed.score < CLEARLY + CONVENTION_COST:
        return Readings(claimed)
    singles = _scored(recording, list(hypotheses(recording)), claimed)
    candidates = singles
    for faults in range(2, MAX_FAULTS + 1):
        if not candidates or min(candidates[0].score, claimed.score) < CLEARLY + faults * CONVENTION_COST:
            break
        pairs = [
            pair
            for candidate in candidates[:COMBINED]
            for single in singles[: 2 * COMBINED]
            if (pair := combined(candidate.hypothesis, single.hypothesis, recording.signs)) is not None
        ]
        candidates = sorted([*candidates, *_scored(recording, pairs, claimed)], key=_score)
    if not candidates:
        return Readings(claimed)
    best = candidates[0]
    if claimed.score - best.score < CLEARLY:
        return Readings(claimed)
    near = _distinct(candidate for candidate in candidates if candidate.score - best.score < HARDLY + WRONG_THRUST)
    better = [candidate for candidate in near if candidate.score - best.score < HARDLY]
    others = [
        candidate
        for candidate in near
        if candidate not in better and candidate.score < claimed.score and _differ_in_thrust(candidate, best)
    ]
    return Readings(claimed, tuple(better), tuple(others[:1]))


def _differ_in_thrust(candidate: TableReading, best: TableReading) -> bool:
    """Return whether two readings have the same contradictions but for the direction of the camber thrust."""
    mine, other = candidate.traits.contradictions, best.traits.contradictions
    units = {**candidate.hypothesis.interpretation.units, **best.hypothesis.interpretation.units}
    return not units and mine.keys() - {"gamma"} == other.keys() - {"gamma"}


def _traits(recording: Recording) -> Traits:
    return traits_of(SampledRows.of(recording.with_signs("iso").table))


def _scored(recording: Recording, readings: Sequence[Hypothesis], claimed: TableReading) -> list[TableReading]:
    """Return the readings with their scores, the best one first."""
    sample = SampledRows.thinned(recording)
    candidates = []
    for hypothesis in readings:
        traits = _traits(hypothesis.applied(sample))
        # The stiffness of one slip is part of that of both.
        present = traits.sizes.keys() | ({"C_x", "C_y"} if "C_xy" in traits.sizes else set())
        vanished = claimed.traits.sizes.keys() - present - ONE_SIDED
        score = traits.penalty + hypothesis.cost + VANISHED * len(vanished)
        candidates.append(TableReading(hypothesis, traits, graded(score)))
    return sorted(candidates, key=_score)


def _score(candidate: TableReading) -> float:
    return candidate.score


def _distinct(candidates: Iterable[TableReading]) -> list[TableReading]:
    """Return the candidates without those that do the same in another order, or do more than a better one."""
    kept: list[TableReading] = []
    for candidate in candidates:
        changes = _changes(candidate)
        if not any(_changes(other) <= changes for other in kept):
            kept.append(candidate)
    return kept


def _changes(candidate: TableReading) -> set[tuple[str, str, str]]:
    hypothesis = candidate.hypothesis
    parts = {("columns", *item) for item in hypothesis.interpretation.columns.items()}
    parts |= {("units", *item) for item in hypothesis.interpretation.units.items()}
    return parts | {("signs", hypothesis.signs, "")}
