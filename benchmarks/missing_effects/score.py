"""The score of an entry: names, false names, probabilities, unknown effects, error on other maneuvers, cost."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from .answers import UNKNOWN, Answer, read_answer
from .generator.cases import Made

#: The variables of an unknown effect are right from this ratio of common to all reported or true variables.
RIGHT_VARIABLES = 0.5
#: Probabilities below this are not counted in the calibration; its groups have equal numbers of probabilities.
MIN_PROBABILITY, GROUPS = 0.01, 10


@dataclass(frozen=True)
class Outcome:
    """The outcome of a case: the answer, its truth, and the part of the squared error that the answer removes.

    - `closed`: NaN if nothing is hidden. The squared error in units of the noise variances, without noise, on other
      maneuvers, relative to that of the baseline model; a method without an answer removes nothing.
    """

    case: Made
    answer: Answer
    closed: float

    @property
    def truth(self) -> set[str]:
        """The names that a right answer has."""
        return {UNKNOWN} if self.case.truth.kind == "unknown" else set(self.case.truth.hidden)

    @property
    def exact(self) -> bool:
        """Whether exactly the hidden effects are found."""
        return set(self.answer.found) == self.truth and not self.answer.failed

    @property
    def variables(self) -> bool:
        """Whether an unknown effect is found with the right variables."""
        reported, true = set(self.answer.variables), set(self.case.truth.variables)
        return UNKNOWN in self.answer.found and len(reported & true) >= RIGHT_VARIABLES * len(reported | true)

    @property
    def claims(self) -> list[tuple[float, bool]]:
        """For each candidate and UNKNOWN, and each other name with a probability: probability and truth."""
        names = {*self.case.about["candidates"], UNKNOWN, *self.answer.probabilities}
        return [(self.answer.probabilities.get(name, 0.0), name in self.truth) for name in sorted(names)]


def outcome(case: Made, answer: Answer) -> Outcome:
    """Return the outcome of a case."""
    truth = case.truth

    def error(forces: Mapping[str, np.typing.ArrayLike]) -> float:
        return sum(
            float(np.mean(((np.asarray(forces[name]) - truth.forces[name]) / truth.noise[name]) ** 2))
            for name in truth.noise
        )

    if truth.kind == "null":
        return Outcome(case, answer, float("nan"))
    before = error(truth.reference())
    after = before if answer.forces is None else error({name: answer.forces[name].to_numpy() for name in truth.noise})
    return Outcome(case, answer, 1.0 - after / before)


def read_outcomes(cases: Sequence[Made], folder: Path) -> list[Outcome]:
    """Return the outcomes of the answers in a folder; raises `DataError` for an answer that is missing or wrong."""
    return [
        outcome(case, read_answer(folder, case.name, list(case.about["channels"]), len(case.other["t"])))
        for case in cases
    ]


def calibration_error(claims: Sequence[tuple[float, bool]]) -> float:
    """Return the expected calibration error over groups of equal size; 0 without claims.

    >>> round(calibration_error([(0.8, True), (0.8, True), (0.8, True), (0.8, False), (0.001, False)]), 3)
    0.05
    """
    counted = np.array([claim for claim in claims if claim[0] >= MIN_PROBABILITY], dtype=np.float64).reshape(-1, 2)
    if not len(counted):
        return 0.0
    edges = np.quantile(counted[:, 0], np.arange(1, GROUPS) / GROUPS)
    group = np.searchsorted(edges, counted[:, 0])  # equal probabilities are in one group
    excess = np.bincount(group, weights=counted[:, 0] - counted[:, 1])
    return float(np.abs(excess).sum() / len(counted))


def summary(outcomes: Sequence[Outcome]) -> dict[str, float | int | None]:
    """Return the score of an entry over cases; JSON types, None where no case counts.

    `exact` of `named`: cases with named effects and exactly these found; `extra`: of these, with other names.
    `false_names`, `false_unknown` of `nulls`. `unknown_found`, `variables` of `unknown`. `brier`: the sum of squared
    errors of the probabilities, per case. `calibration`: `calibration_error`. `closed`, `least_closed`: median, least.
    """
    by_kind = {kind: [judged for judged in outcomes if judged.case.truth.kind in kind.split()]
               for kind in ("single double", "null", "unknown")}  # fmt: skip
    named, nulls, unknown = by_kind.values()
    closed = [judged.closed for judged in outcomes if np.isfinite(judged.closed)]
    squares = [sum((p - true) ** 2 for p, true in judged.claims) for judged in outcomes]
    seconds = [judged.answer.cpu_seconds for judged in outcomes]
    return {
        "cases": len(outcomes), "failed": sum(bool(judged.answer.failed) for judged in outcomes),
        "named": len(named), "exact": sum(judged.exact for judged in named),
        "extra": sum(bool(set(judged.answer.found) - judged.truth) for judged in named),
        "nulls": len(nulls), "false_names": sum(bool(set(judged.answer.found) - {UNKNOWN}) for judged in nulls),
        "false_unknown": sum(UNKNOWN in judged.answer.found for judged in nulls),
        "unknown": len(unknown), "unknown_found": sum(judged.exact for judged in unknown),
        "variables": sum(judged.variables for judged in unknown),
        "brier": float(np.mean(squares)) if squares else None,
        "calibration": calibration_error([claim for judged in outcomes for claim in judged.claims]),
        "closed": float(np.median(closed)) if closed else None, "least_closed": min(closed, default=None),
        "cpu_seconds": float(np.median(seconds)) if seconds else None,
    }  # fmt: skip


def scores(outcomes: Sequence[Outcome]) -> dict[str, dict[str, float | int | None]]:
    """Return the `summary` of the recordings of tires and of those of other systems."""
    tiers = {"tires": [judged for judged in outcomes if judged.case.about["system"] == "tire"],
             "systems": [judged for judged in outcomes if judged.case.about["system"] != "tire"]}  # fmt: skip
    return {tier: summary(found) for tier, found in tiers.items() if found}


#: Columns of tables of scores, as `row` fills them.
HEAD = ("exact names", "other names", "null: names", "null: UNKNOWN", "unknown: found", "variables", "Brier",
        "calibration", "closed: median", "least", "CPU s", "failed")  # fmt: skip


def row(found: Mapping[str, float | int | None]) -> list[str]:
    """Return the columns `HEAD` of a `summary`."""

    def number(key: str, digits: int) -> str:
        value = found[key]
        return "-" if value is None else f"{value:.{digits}f}"

    of = {"exact": "named", "extra": "named", "false_names": "nulls", "false_unknown": "nulls",
          "unknown_found": "unknown", "variables": "unknown"}  # fmt: skip
    counts = [f"{found[key]} of {found[total]}" if found[total] else "-" for key, total in of.items()]
    digits = {"brier": 2, "calibration": 2, "closed": 2, "least_closed": 2, "cpu_seconds": 1}
    return [*counts, *(number(key, places) for key, places in digits.items()), str(found["failed"])]
