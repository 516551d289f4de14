"""The content of plan.json, from which its JSON Schema follows."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Annotated, Any, TypedDict

from tirefmu.boundary.json_schema import document, schema_of

#: Version of plan.json. New keys increment the second number, changed meanings the first.
VERSION = "1.0"


class TimedIntervals(TypedDict):
    """The predicted intervals after a bench time, s."""

    seconds: float
    intervals: dict[str, float]


class ComparedProgram(TypedDict):
    """The program of `--compare`, and after which bench time the planned one equals it."""

    name: str
    seconds: float
    intervals: dict[str, float]
    equal_after: Annotated[float | None, "s; null if it does not"]


@dataclass(frozen=True)
class Separation:
    """How well a program separates an effect from another one.

    - `effect`, `rival`: if the tire has the effect, and the rival is fitted instead.
    - `evidence`: expected logarithm of the likelihood ratio, for the form of the effect that is hardest to separate.
    - `alone`: the same against a tire whose coefficients are known and that lacks the effect, for the strongest form.
    """

    effect: str
    rival: str
    evidence: float
    alone: float


class PlanContent(TypedDict):
    """The keys of plan.json; see `PlanResult`."""

    version: str
    ok: bool
    seconds: Annotated[float, "bench time"]
    steps: int
    aims: list[str]
    intervals: Annotated[dict[str, float], "relative half widths of the predicted 95 % intervals by quantity"]
    over_time: list[TimedIntervals]
    undetermined: Annotated[dict[str, str], "coefficients that remain undetermined, and why"]
    compared: ComparedProgram | None
    separations: Sequence[Separation]


def plan_schema() -> dict[str, Any]:
    """Return the JSON Schema of plan.json."""
    return document("plan", VERSION, "Planned test program", schema_of(PlanContent, missing=True))
