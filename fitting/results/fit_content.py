"""The content of fit.json, from which its JSON Schema follows."""

from __future__ import annotations

from typing import Annotated, Any, TypedDict

from ...boundary.json_schema import document, schema_of
from ...measurements import DataFinding
from ..checks.diagnostics import Findings
from ..constraints.verification import Margin
from ..data.fit_data import ExcludedRows
from ..temperature.fitted_temperature import FittedTemperature
from ..uncertainty.sandwich import Direction
from .intervals import ListedInterval
from .records import BoundConsequence, ChannelFit, FittedCoefficient, HeldOut
from .resampled import Bootstrap
from .stages import StageResult

#: Version of fit.json. New keys increment the second number, changed meanings the first.
VERSION = "2.0"


class Covariance(TypedDict):
    """Covariance of the coefficients with a finite interval."""

    coefficients: list[str]
    matrix: list[list[float]]


class FitContent(TypedDict):
    """The keys of fit.json; `FitResult` explains those with its names."""

    version: str
    ok: Annotated[bool, "whether the tire is usable, possibly with limits"]
    verdict: Annotated[str, "good, usable with limits, or not usable"]
    reasons: Annotated[list[str], "of the verdict, in order of weight"]
    status: str
    recipe: str
    method: str
    seconds: float
    model: str
    effects: list[str]
    signs: str
    values: Annotated[dict[str, float], "all coefficients of the tire, in ISO-W"]
    coefficients: tuple[FittedCoefficient, ...]
    channels: tuple[ChannelFit, ...]
    stages: tuple[StageResult, ...]
    margins: tuple[Margin, ...]
    margins_signs: str
    directions: tuple[Direction, ...]
    bounds: Annotated[tuple[BoundConsequence, ...], "what changes beyond the bound of a coefficient at one"]
    set_aside: Annotated[tuple[ExcludedRows, ...], "rows that were not fitted"]
    held_out: tuple[HeldOut, ...]
    findings: Findings
    covariance: Covariance
    intervals: Annotated[list[ListedInterval], "95 % intervals of quantities and forces over the measured range"]
    bootstrap: Bootstrap | None
    temperature: FittedTemperature | None
    notes: tuple[str, ...]
    data_findings: tuple[DataFinding, ...]
    interrupted: Annotated[str, "where the fit was stopped; empty if it is complete"]


def fit_schema() -> dict[str, Any]:
    """Return the JSON Schema of fit.json."""
    return document("fit", VERSION, "Result of a fit", schema_of(FitContent, missing=True))
