"""The parts of a diagnosis. Their fields are attributes of `Diagnosis`, too, and described there."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Annotated, Any

import pandas as pd

from ...numerics.arrays import IntArray
from ...symbolic.added import AddedEffect
from .extrapolation import Extrapolation
from .findings import FormCorrection


@dataclass(frozen=True)
class Identifiability:
    """What a recording can show."""

    detectable: Mapping[str, Mapping[str, float]]
    not_identifiable: Mapping[str, str]
    next_measurement: tuple[str, ...]

    @property
    def names(self) -> tuple[str, ...]:
        """Effects that this recording cannot identify."""
        return tuple(sorted(self.not_identifiable))


@dataclass(frozen=True, eq=False)
class Misfit:
    """The residuals of the baseline model and of the improved one: sizes, places, times."""

    gap: Mapping[str, Mapping[str, Mapping[str, float]]]
    where: list[dict[str, Any]]
    where_after: list[dict[str, Any]]
    time_course: Mapping[str, Mapping[str, list[float]]]


@dataclass(frozen=True)
class Improvement:
    """What the improved model has beside the identified effects, and why it is not delivered."""

    refined: tuple[str, ...]
    form: FormCorrection
    extrapolation: tuple[Extrapolation, ...]
    not_delivered_because: tuple[str, ...]


@dataclass(frozen=True)
class WrittenFiles:
    """Paths of the files of a diagnosis; '' without a file."""

    tire: Annotated[str, "path of the improved tire, relative to the folder; as the following paths"] = ""
    fmu: str = ""
    base_tire: str = ""
    base_fmu: str = ""


@dataclass(frozen=True, eq=False)
class DiagnosisRun:
    """What was diagnosed, and how.

    `computed`: outputs and states of the baseline tire and of the delivered one in all rows. `compared`: numbers of the
    rows of `Evidence.change`. `tested`: the effects in the equations of all fits.
    """

    rows: pd.DataFrame
    recording_signs: str
    computed: tuple[pd.DataFrame, pd.DataFrame]
    compared: IntArray
    tested: tuple[AddedEffect, ...]
    holdout_rows: tuple[Sequence[int], ...]
    seconds: float
    stopped: str
    files: WrittenFiles = WrittenFiles()
