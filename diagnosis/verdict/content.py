"""The content of diagnosis.json, from which its JSON Schema follows."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Annotated, Any, NotRequired, TypedDict

from ...boundary.json_schema import document, schema_of
from ..explanations.answer import OneOf, RankedExplanation
from .findings import CoefficientInterval

#: Version of diagnosis.json. New keys increment the second number, changed meanings the first.
VERSION = "4.3"


class Size(TypedDict):
    """Change of a force by an effect in the recording, N and N m."""

    rms: float
    largest: float


class FoundContent(TypedDict):
    """An identified effect; see `FoundEffect`."""

    effect: Annotated[str, "name, or UNKNOWN for unexplained structure"]
    probability: Annotated[float, "of all compared explanations that contain it", {"minimum": 0, "maximum": 1}]
    channels: Sequence[str]
    coefficients: Mapping[str, CoefficientInterval]
    p: float
    cv_gain: float
    cv_gain_se: float
    when: Annotated[Sequence[Sequence[float]], "stretches of time with most of the evidence, s"]
    size: Mapping[str, Size]


class EvidenceContent(TypedDict):
    """Evidence for an effect in the final fit; see `Evidence`."""

    z: float
    stretches: int
    holdout_gain: float
    holdout_error: float


class UnknownContent(TypedDict):
    """Structure that no effect explains; see `Unknown`."""

    depends_on: Sequence[str]
    formula: str
    added: bool
    file: str | None
    not_added_because: str


class AdequacyContent(TypedDict):
    """Residual of a channel compared with its noise floor; see `Adequacy`."""

    ratio: float
    residual: float
    floor: float
    adequate: bool | None
    where: str
    memory: bool
    of_inputs: Annotated[float, "part of the residual that follows the recorded inputs"]
    of_past: Annotated[float, "part of the residual that follows the direction of slip or slow time"]
    lacks: Annotated[str, "where the tire gives too much or too little, in words, or empty"]


class ExtrapolationContent(TypedDict):
    """Change of an effect outside the measured range; see `Extrapolation`."""

    effect: str
    input: str
    lower: float
    upper: float
    change: float
    channel: str
    doubtful: bool


class FormContent(TypedDict):
    """The correction of the formula's own form."""

    channels: Annotated[Mapping[str, Size], "change of the forces by it"]
    delivered: bool


class DiagnosisContent(TypedDict):
    """The keys of diagnosis.json; `Diagnosis` explains those with its names."""

    version: str
    headline: Annotated[str, "what is missing, in a few words"]
    verdict: Annotated[str, "in one line"]
    found: Annotated[Sequence[FoundContent], "in falling order of probability"]
    explanations: Annotated[Sequence[RankedExplanation], "in falling order of probability"]
    one_of: Annotated[Sequence[OneOf], "effects of which one is missing, where the recording does not tell which"]
    probabilities: Annotated[Mapping[str, float], "of each candidate and of UNKNOWN"]
    confounded_with: Mapping[str, Sequence[str]]
    correlation: Mapping[str, Mapping[str, float]]
    next_measurement: Sequence[str]
    unknown: Sequence[UnknownContent]
    not_identifiable: Sequence[str]
    not_identifiable_because: Mapping[str, str]
    refined: Sequence[str]
    gap: Annotated[Mapping[str, Mapping[str, Mapping[str, float]]], "train, cv, holdout, then channels: N and N m"]
    adequacy: Mapping[str, AdequacyContent]
    delivered: Annotated[bool, "whether the improved tire differs from the baseline"]
    not_delivered_because: Sequence[str]
    confirmed: Mapping[str, EvidenceContent]
    detectable: Mapping[str, Mapping[str, float]]
    where: Sequence[dict[str, Any]]
    where_after: Sequence[dict[str, Any]]
    time_course: Mapping[str, Mapping[str, Sequence[float]]]
    recording: Annotated[Mapping[str, Any], "errors of the recording"]
    extrapolation: Sequence[ExtrapolationContent]
    holdout_rows: Annotated[Sequence[Sequence[int]], "first and last row of each stretch, from 0"]
    signs: str
    recording_signs: str
    tire: Annotated[str, "path of the improved tire, relative to the folder; as the following paths"]
    fmu: str
    base_tire: str
    base_fmu: str
    seconds: float
    form: Annotated[FormContent, "the correction of the formula's own form, effect form of the tire"]
    stopped: Annotated[str, "why explanations that remained were not compared, or empty"]
    ok: NotRequired[Annotated[bool, "of the command's --json only: whether each FMU agrees with direct evaluation"]]
    simulated: NotRequired[Annotated[dict[str, Any], "errors of both FMUs over the recordings"]]


def diagnosis_schema() -> dict[str, Any]:
    """Return the JSON Schema of diagnosis.json."""
    return document("diagnosis", VERSION, "Result of a diagnosis", schema_of(DiagnosisContent, missing=True))
