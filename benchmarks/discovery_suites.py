"""The suites of made recordings."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

from diagnosis.case import Case
from diagnosis.independent import brush, brush_kinds, tmeasy
from diagnosis.independent import kinds as second
from diagnosis.independent import memory_kinds as memory
from diagnosis.independent.formulas import Core
from diagnosis.independent.unknown_kinds import UNKNOWN_VARIABLES
from diagnosis.suite import UNKNOWN

from diagnosis import kinds as first


@dataclass(frozen=True)
class Suite:
    """A suite of made recordings.

    - `number_of_cases`: by kind.
    - `case_of`: returns a case by kind and number.
    - `unknown`: variables of each structure that is not in the library; empty if any are right.
    - `confounded`: by number: program, hidden effect, other effects that may be identified first, effects that must be
      reported as confounded, and words of the separating measurement.
    """

    name: str
    number_of_cases: Mapping[str, int]
    case_of: Callable[[str, int], Case]
    unknown: Mapping[str, frozenset[str]]
    confounded: Sequence[tuple[str, str, str, str, str]]


#: Structures of the first and the second suite that effects with states describe.
NAMED = {"hysteresis": "hysteresis_force", "contact_heat": "heat_friction"}


#: Numbers of the confirmation suite, in multiples of the number of cases of the second suite. Whoever changes the
#: diagnosis after looking at single cases of this suite increases it, so that the recordings are new ones.
DRAW = 36


#: The same of the brush and the TMeasy suite. Draw 0 of brushes was examined: its cases are those of the tests.
BRUSH_DRAW = 5


#: The kinds of the second suite; unknown laws are a suite.
OF_SECOND = {kind: count for kind, count in second.NUMBER_OF_CASES.items() if kind != "law"}


def _drawn_again(kind: str, number: int) -> Case:
    return second.case_of(kind, number + DRAW * second.NUMBER_OF_CASES[kind])


def _of_core(core: Core) -> Callable[[str, int], Case]:
    return lambda kind, number: brush_kinds.case_of(kind, number + BRUSH_DRAW * brush_kinds.NUMBER_OF_CASES[kind], core)


def _of_law(kind: str, number: int) -> Case:
    return second.case_of("law", number)


SUITES = {
    "first": Suite("first", first.NUMBER_OF_CASES, first.case_of, UNKNOWN, first.CONFOUNDED),
    "second": Suite("second", OF_SECOND, second.case_of, second.UNKNOWN, second.CONFOUNDED),
    "memory": Suite("memory", memory.NUMBER_OF_CASES, memory.case_of, {}, memory.CONFOUNDED),
    "confirmation": Suite("confirmation", OF_SECOND, _drawn_again, second.UNKNOWN, second.CONFOUNDED),
    "brush": Suite("brush", brush_kinds.NUMBER_OF_CASES, _of_core(brush.forces), {}, ()),
    "tmeasy": Suite("tmeasy", brush_kinds.NUMBER_OF_CASES, _of_core(tmeasy.forces), {}, ()),
    "unknown": Suite("unknown", {"unknown": len(UNKNOWN_VARIABLES)}, _of_law, UNKNOWN_VARIABLES, ()),
}
