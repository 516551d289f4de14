"""Score of a diagnosis of a simulated recording: effects, error, intervals, confounded effects, unknown structure."""

from __future__ import annotations

import re
from dataclasses import dataclass

from diagnosis.case import Case
from discovery_delivered import Delivered, delivered
from discovery_suites import NAMED, Suite

from tirefmu.diagnosis import Diagnosis
from tirefmu.tires.tire import Tire

#: The reported variables of an unknown effect are right from this ratio of common to all reported or true variables.
RIGHT_VARIABLES = 0.5


@dataclass(frozen=True)
class Posed:
    """A case of a suite: its kind and number there, its name, what it hides, and the rows of its recording."""

    kind: str
    number: int
    name: str
    hidden: tuple[str, ...]
    rows: int

    @classmethod
    def of(cls, kind: str, number: int, case: Case) -> Posed:
        """Return what an outcome keeps of a case."""
        return cls(kind, number, case.name, (case.unknown,) if case.unknown else case.hidden, len(case.table))


@dataclass(frozen=True)
class NamedOthers:
    """Of confounded effects: whether all are reported, and the measurement that separates them."""

    reported: bool = False
    next_test: bool = False


@dataclass(frozen=True)
class NamedVariables:
    """Of an unknown effect: its reported variables, whether they are right, and whether its formula was added."""

    depends_on: tuple[str, ...] = ()
    right: bool = False
    added: bool = False


@dataclass(frozen=True)
class Outcome:
    """The outcome of a case; the defaults are those of a diagnosis that failed.

    - `seconds`: CPU time.
    - `first`: whether the first identified effect is right.
    - `extra`: identified effects that are not hidden.
    - `exact`: whether the identified effects are the hidden ones.
    - `closed`: relative reduction of the squared error on other manoeuvres, in units of the noise variance of each
      channel.
    - `covered`, `intervals`: true values within their 95 % intervals, and their number.
    - `delivered`: the delivered tire; None if there is none.
    - `claims`: for each candidate and UNKNOWN, its probability and whether it is missing (1 or 0).
    - `failed`: exception and reason if there is no diagnosis.
    """

    case: Posed
    seconds: float
    found: tuple[str, ...] = ()
    first: bool = False
    extra: tuple[str, ...] = ()
    exact: bool = False
    closed: float = 0.0
    covered: int = 0
    intervals: int = 0
    others: NamedOthers = NamedOthers()
    unknown: NamedVariables = NamedVariables()
    delivered: Delivered | None = None
    claims: tuple[tuple[float, float], ...] = ()
    failed: str = ""

    @property
    def right(self) -> bool:
        """Whether the diagnosis is right."""
        if self.failed:
            return False
        if self.case.kind == "confounded":
            return self.first and not self.extra and self.others.reported and self.others.next_test
        if self.case.kind == "unknown":
            return self.exact and self.unknown.right
        return self.exact

    @property
    def line(self) -> str:
        """The outcome in one line."""
        case, unknown, hidden = self.case, self.unknown, "+".join(self.case.hidden) or "nothing"
        if self.failed:
            return f"{case.kind}:{case.number} FAILED {hidden}: {self.failed}, {self.seconds:.1f} s"
        summary = f"{hidden} -> {'+'.join(self.found) or 'nothing'}"
        more = f" [{' '.join(unknown.depends_on)}{', added' if unknown.added else ''}]" if unknown.depends_on else ""
        if case.kind == "confounded":
            reported, next_test = (
                "reported" if self.others.reported else "NOT REPORTED",
                "right" if self.others.next_test else "WRONG",
            )
            more += f" others {reported}, next test {next_test}"
        mark = "right" if self.right else "first" if self.first else "WRONG"
        return f"{case.kind}:{case.number} {mark:5} {summary}{more}; closed {self.closed:.3f}, {self.seconds:.1f} s"


def score(suite: Suite, kind: str, number: int, case: Case, result: Diagnosis, seconds: float) -> Outcome:
    """Return the outcome of a diagnosis."""
    found = tuple(one.effect for one in result.found)
    hidden = (NAMED.get(case.unknown, "UNKNOWN"),) if case.unknown else case.hidden
    allowed, confounded_effects, words = set(hidden), set[str](), ""
    if kind == "confounded":
        _, _, others, confounded, words = suite.confounded[number]
        allowed |= set(others.split())
        confounded_effects = {*confounded.split(), *hidden}
    before, after = (squared_error(tire, case, result) for tire in (result.base_tire, result.tire))
    covered, intervals = _covered(case, result) if kind in ("single", "double", "triple") else (0, 0)
    named = {*found, *result.confounded_with.get(found[0], ())} if found else set()
    named = named.union(*(one.effects for one in result.one_of if found[0] in one.effects))
    depends = result.unknown[0].depends_on if result.unknown else ()
    true = suite.unknown.get(case.unknown, frozenset())
    variables_right = bool(set(hidden) & set(NAMED.values()) & set(found)) or (
        bool(depends) and (not true or _share(true, set(depends)) >= RIGHT_VARIABLES)
    )
    return Outcome(
        Posed.of(kind, number, case), seconds, found,
        first=bool(found) and found[0] in allowed,
        extra=tuple(name for name in found if name not in allowed),
        exact=set(found) == set(hidden),
        closed=1.0 - after / before,
        covered=covered, intervals=intervals,
        others=NamedOthers(
            confounded_effects <= named,
            bool(words) and any(re.search(words, text) for text in result.next_measurement),
        ),
        unknown=NamedVariables(depends, variables_right, any(one.added for one in result.unknown)),
        delivered=delivered(case, result),
        claims=tuple((value, float(one in hidden)) for one, value in result.answer.probabilities.items()),
    )  # fmt: skip


def _share(true: frozenset[str], reported: set[str]) -> float:
    """Return the number of common variables over that of all."""
    return len(true & reported) / len(true | reported)


def squared_error(tire: Tire, case: Case, result: Diagnosis) -> float:
    """Return the squared error of a tire on other manoeuvres, in units of the noise variance of each channel."""
    computed = tire.evaluate(case.test.drop(columns=list(result.gap["train"])), signs=case.signs)
    parts = (((computed[name] - case.test[name]) ** 2).mean() / one["floor"] ** 2
             for name, one in result.gap["train"].items())  # fmt: skip
    return float(sum(parts))


def _covered(case: Case, result: Diagnosis) -> tuple[int, int]:
    """Return the number of true values within their intervals, and the number of intervals."""
    comparable = [one for one in result.found if one.effect in case.same_form]
    true = case.tire.in_signs(result.signs).values if comparable else {}
    inside = [
        one.lower <= true[name] <= one.upper
        for finding in comparable
        for name, one in finding.coefficients.items()
    ]  # fmt: skip
    return sum(inside), len(inside)
