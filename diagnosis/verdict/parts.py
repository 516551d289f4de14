"""The parts of a diagnosis, of whose fields a `Diagnosis` consists beside its own."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Annotated, Any

import pandas as pd

from .extrapolation import Extrapolation
from .findings import FormCorrection


@dataclass(frozen=True, kw_only=True, eq=False)
class Identifiability:
    """What a recording can show."""

    detectable: Annotated[
        Mapping[str, Mapping[str, float]],
        "The smallest change of the force that would have been identified, root mean square, by effect and channel.",
    ]
    not_identifiable: Annotated[Mapping[str, str], "Effects that this recording cannot identify, and the reason."]
    next_measurement: Annotated[tuple[str, ...], "Measurements that separate confounded explanations."]

    @property
    def not_identifiable_names(self) -> tuple[str, ...]:
        """Effects that this recording cannot identify."""
        return tuple(sorted(self.not_identifiable))


@dataclass(frozen=True, kw_only=True, eq=False)
class Misfit:
    """The residuals of the baseline model and of the improved one: sizes, places, times.

    - `gap`: `fit_error.fit_errors` with the noise floor (`tirefmu.numerics.noise_floor`). ``after`` is the residual of
      the delivered tire; all errors of the recording are removed.
    - `where`, `where_after`: `residual_location.residual_maps`.
    - `time_course`: `residual_location.time_course`.
    """

    gap: Annotated[
        Mapping[str, Mapping[str, Mapping[str, float]]],
        "Root mean square residuals by rows (train, cv, holdout) and channel, N and N m.",
    ]
    where: Annotated[
        list[dict[str, Any]], "Residuals of the baseline model over noise, by channel and pairs of inputs."
    ]
    where_after: Annotated[
        list[dict[str, Any]], "Residuals of the improved model over noise, by channel and pairs of inputs."
    ]
    time_course: Annotated[Mapping[str, Mapping[str, list[float]]], "Misfit over noise by channel and time block."]


@dataclass(frozen=True, kw_only=True, eq=False)
class Improvement:
    """What the improved model has beside the identified effects, and why it is not delivered."""

    refined: Annotated[
        tuple[str, ...], "Finer forms that the recording needs, of effects that the baseline model already had."
    ]
    form: Annotated[FormCorrection, "The correction of the formula's own form, effect form of the tire."]
    extrapolation: Annotated[
        tuple[Extrapolation, ...],
        "Measured ranges of the inputs of identified effects, and the change of the effects outside them.",
    ]
    not_delivered_because: Annotated[
        tuple[str, ...], "Why `tire` is the baseline tire; empty if it is the improved one."
    ]

    @property
    def delivered(self) -> bool:
        """Whether the improved tire is delivered; otherwise `tire` is the baseline tire."""
        return not self.not_delivered_because


@dataclass(frozen=True)
class WrittenFiles:
    """Paths of the files of a diagnosis; '' without a file."""

    tire: Annotated[str, "path of the improved tire, relative to the folder; as the following paths"] = ""
    fmu: str = ""
    base_tire: str = ""
    base_fmu: str = ""


@dataclass(frozen=True, kw_only=True, eq=False)
class DiagnosisRun:
    """What was diagnosed, and how.

    - `rows`: of the recording, in its signs.
    """

    rows: pd.DataFrame
    recording_signs: Annotated[str, "Sign convention of the recording."]
    holdout_rows: Annotated[
        tuple[Sequence[int], ...],
        "First and last row, counted from 0, of each stretch of the hold-out set, which no fit uses.",
    ]
    seconds: Annotated[float, "Wall time, s."]
    stopped: Annotated[str, "Why explanations that remained were not compared, or empty."]
    files: WrittenFiles = WrittenFiles()
