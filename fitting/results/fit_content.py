"""The content of fit.json: its keys with their types, from which its values and its JSON Schema follow."""

from __future__ import annotations

from operator import attrgetter
from typing import Annotated, Any, TypedDict

import numpy as np

from ...boundary.json_schema import document, json_value, schema_of
from ...measurements import DataFinding
from ..checks.diagnostics import Findings
from ..constraints.verification import Margin
from ..data.fit_data import ExcludedRows
from ..temperature.fitted_temperature import FittedTemperature
from ..uncertainty.sandwich import Direction
from .fitted import Fitted
from .intervals import ListedInterval, listed_intervals
from .records import Bootstrap, BoundConsequence, ChannelFit, FittedCoefficient, HeldOut
from .stages import StageResult
from .verdict import Verdict

#: Version of fit.json. New keys increment the second number, changed meanings the first.
VERSION = "2.0"
#: Where a result has what is called otherwise in the file.
_PLACES = {
    "recipe": "run.recipe", "method": "run.method", "seconds": "run.seconds", "interrupted": "run.interrupted",
    "model": "tire.model", "values": "tire.values", "set_aside": "excluded_rows",
}  # fmt: skip


class Covariance(TypedDict):
    """Covariance of the coefficients with a finite interval."""

    coefficients: list[str]
    matrix: list[list[float]]


class FitContent(TypedDict):
    """The keys of fit.json; those of `FitResult` have its values."""

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


def fit_content(result: Fitted, verdict: Verdict) -> dict[str, Any]:
    """Return a result as values of JSON; a number that does not exist, such as a missing bound, is null."""
    derived = {
        "version": VERSION, "ok": verdict.usable, "verdict": verdict.word, "reasons": verdict.reasons,
        "effects": sorted(result.tire.has), "margins_signs": "adapted-sae", "covariance": _covariance(result),
        "intervals": list(listed_intervals(result)),
    }  # fmt: skip
    return {
        name: json_value(derived[name] if name in derived else attrgetter(_PLACES.get(name, name))(result))
        for name in FitContent.__annotations__
    }


def _covariance(result: Fitted) -> Covariance:
    covariance = result.covariance
    determined = list(covariance.index[np.isfinite(np.diag(covariance))]) if len(covariance) else []
    return {"coefficients": determined, "matrix": covariance.loc[determined, determined].to_numpy().tolist()}


def fit_schema() -> dict[str, Any]:
    """Return the JSON Schema of fit.json."""
    return document("fit", VERSION, "Result of a fit", schema_of(FitContent, missing=True))
