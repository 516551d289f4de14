"""The content of drive.json, from which its JSON Schema follows."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Annotated, Any, TypedDict

from ...boundary.json_schema import document, schema_of
from .factors import Factor
from .verdict import CarFinding, EffectFinding, TireDifference

#: Version of drive.json. New keys increment the second number, changed meanings the first.
VERSION = "3.0"


class CarEntry(TypedDict):
    """An estimated entry of the car, in the unit of the car file, and what the file states."""

    value: float
    uncertainty: Annotated[float, "standard deviation"]
    given: float
    given_uncertainty: float


class ContradictionContent(TypedDict):
    """The joint deviation of the entries of the car from their file, in the estimate without an effect."""

    deviation: Annotated[float, "chi-squared"]
    degrees_of_freedom: int
    p: Annotated[float, "probability of a larger deviation if the file is right"]


class LeftOutContent(TypedDict):
    """Root mean squares of the errors of the simulated vehicle in parts that its estimate did not see, by signal."""

    before: Annotated[Mapping[str, float], "tires as given"]
    after: Annotated[Mapping[str, float], "new tires"]
    better: Annotated[bool, "whether the new tires are better, beyond the scatter over the parts"]


class CarContent(TypedDict):
    """Entries that contradict the car file, one by one and together, and all estimated entries by name."""

    found: Sequence[CarFinding]
    contradiction: ContradictionContent
    entries: dict[str, CarEntry]


class SimulationContent(TypedDict):
    """Root mean squares of the errors of the simulated vehicle by signal, as given and with the estimate."""

    before: Mapping[str, float]
    after: Mapping[str, float]
    fmus: Annotated[bool, "whether the tires of the vehicle were FMUs"]


class DriveContent(TypedDict):
    """The keys of drive.json; see `Drive`."""

    version: str
    ok: Annotated[bool, "whether the numbers can be used"]
    written: Annotated[bool, "whether there are new tires"]
    verdict: list[str]
    log: str
    duration: Annotated[float, "s"]
    factors: Annotated[Mapping[str, Mapping[str, Factor]], "scaling factors by axle and name"]
    found: Annotated[Sequence[TireDifference], "differences of the tires"]
    unknown: Annotated[bool, "whether the tires do not explain the side force of an axle"]
    unexplained: Annotated[dict[str, float], "deviation of the balance of forces per load by axle"]
    effect: Annotated[str | None, "of the library, that the new tires have"]
    effects: Annotated[Sequence[EffectFinding], "of the library, likely ones first"]
    lacking: Annotated[float, "probability that the tires lack an effect of the library"]
    car: CarContent
    axle_forces: Annotated[dict[str, dict[str, float]], "rms of lacking side force before and after, by axle, N"]
    correlations: Annotated[dict[str, dict[str, float]], "of determined factors with entries of the car, above 0.3"]
    simulation: SimulationContent
    left_out: LeftOutContent | None
    converged: bool


def drive_schema() -> dict[str, Any]:
    """Return the JSON Schema of drive.json."""
    return document("drive", VERSION, "Answer to a drive", schema_of(DriveContent, missing=True))
