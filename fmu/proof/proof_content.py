"""The content of proof.json, from which its JSON Schema follows."""

from __future__ import annotations

from typing import Annotated, Any, TypedDict

from ...boundary.json_schema import document, schema_of
from .layout import FORMAT


class ProofContent(TypedDict):
    """The keys of proof.json."""

    format: Annotated[int, {"const": FORMAT}]
    layout: Annotated[str, "the standard that the places of the files follow"]
    reference: Annotated[str, "what computed the reference"]
    inputs: Annotated[str, "kind of inputs of the FMU"]
    axes: Annotated[str, "signs of the outputs of the FMU"]
    tolerance: Annotated[float, "largest |FMU - reference| / (1 + |reference|)"]
    rows: int
    segments: Annotated[list[int], "first row of each segment; the FMU is reset there"]
    ranges: Annotated[list[tuple[str, float, float]], "name, smallest and largest value of each input, SI, ISO-W"]
    agreement: Annotated[
        list[tuple[str, int, float, str, float | None]], "channel, rows, RMSE, unit and R2 of measured channels"
    ]
    tire: Annotated[list[tuple[str, str]], "what the tire file states about itself"]
    provenance: list[tuple[str, str]]
    verdict: Annotated[list[str], "verdict on the fit, then its reasons; empty without a fit"]
    files: Annotated[dict[str, str], "SHA-256 of every other file of the FMU"]


def proof_schema() -> dict[str, Any]:
    """Return the JSON Schema of proof.json."""
    return document("proof", f"{FORMAT}.0", "Proof inside an FMU", schema_of(ProofContent))
