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
class Outcome:
    """The outcome of a case.

    - `first`: whether the first identified effect is right.
    - `extra`: identified effects that are not hidden.
    - `exact`: whether the identified effects are the hidden ones.
    - `closed`: relative reduction of the squared error on other manoeuvres, in units of the noise variance of each
      channel.
    - `covered`, `intervals`: true values within their 95 % intervals, and their number.
    - `reported`, `next_test`: confounded effects: whether all are reported, and the measurement that separates them.
    - `variables`, `added`: unknown effect: whether its variables are right, and whether its formula was added.
    - `seconds`: CPU time.
    - `rows`: rows of the recording.
    - `delivered`: the delivered tire; None if there is none.
    - `claims`: for each candidate and UNKNOWN, its probability and whether it is missing (1 or 0).
    - `failed`: exception and reason if there is no diagnosis.
    """

    kind: str
    number: int
    name: str
    hidden: tuple[str, ...]
    found: tuple[str, ...]
    first: bool
    extra: tuple[str, ...]
    exact: bool
    closed: float
    covered: int
    intervals: int
    reported: bool
    next_test: bool
    depends_on: tuple[str, ...]
    variables: bool
    added: bool
    seconds: float
    rows: int
    delivered: Delivered | None
    claims: tuple[tuple[float, float], ...] = ()
    failed: str = ""

    @property
    def right(self) -> bool:
        """Whether the diagnosis is right."""
        if self.failed:
            return False
        if self.kind == "confounded":
            return self.first and not self.extra and self.reported and self.next_test
        if self.kind == "unknown":
            return self.exact and self.variables
        return self.exact

    @property
    def line(self) -> str:
        """The outcome in one line."""
        if self.failed:
            hidden = "+".join(self.hidden) or "nothing"
            return f"{self.kind}:{self.number} FAILED {hidden}: {self.failed}, {self.seconds:.1f} s"
        summary = f"{'+'.join(self.hidden) or 'nothing'} -> {'+'.join(self.found) or 'nothing'}"
        more = f" [{' '.join(self.depends_on)}{', added' if self.added else ''}]" if self.depends_on else ""
        if self.kind == "confounded":
            reported, next_test = (
                "reported" if self.reported else "NOT REPORTED",
                "right" if self.next_test else "WRONG",
            )
            more += f" others {reported}, next test {next_test}"
        mark = "right" if self.right else "first" if self.first else "WRONG"
        return f"{self.kind}:{self.number} {mark:5} {summary}{more}; closed {self.closed:.3f}, {self.seconds:.1f} s"


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
    depends = result.unknown[0].depends_on if result.unknown else ()
    true = suite.unknown.get(case.unknown, frozenset())
    return Outcome(
        kind=kind, number=number, name=case.name, hidden=_hidden(case), found=found,
        first=bool(found) and found[0] in allowed,
        extra=tuple(name for name in found if name not in allowed),
        exact=set(found) == set(hidden),
        closed=1.0 - after / before,
        covered=covered, intervals=intervals,
        reported=confounded_effects <= named,
        next_test=bool(words) and any(re.search(words, text) for text in result.next_measurement),
        depends_on=depends,
        variables=bool(set(hidden) & set(NAMED.values()) & set(found))
        or (bool(depends) and (not true or _share(true, set(depends)) >= RIGHT_VARIABLES)),
        added=any(one.added for one in result.unknown),
        seconds=seconds,
        rows=len(case.table),
        delivered=delivered(case, result),
        claims=tuple((value, float(one in hidden)) for one, value in result.answer.probabilities.items()),
    )  # fmt: skip


def failed(suite: Suite, kind: str, number: int, case: Case, error: Exception, seconds: float) -> Outcome:
    """Return the outcome of a diagnosis that raised an exception: nothing is found and no tire delivered."""
    return Outcome(
        kind=kind, number=number, name=case.name, hidden=_hidden(case), found=(), first=False, extra=(), exact=False,
        closed=0.0, covered=0, intervals=0, reported=False, next_test=False, depends_on=(), variables=False,
        added=False, seconds=seconds, rows=len(case.table), delivered=None, failed=f"{type(error).__name__}: {error}",
    )  # fmt: skip


def _hidden(case: Case) -> tuple[str, ...]:
    return (case.unknown,) if case.unknown else case.hidden


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
