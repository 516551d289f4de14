"""The result of a diagnosis and its JSON."""

from __future__ import annotations

import json
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Annotated, Any, ClassVar

import numpy as np
import numpy.typing as npt
import pandas as pd

from ...boundary.errors import DataError, UnknownName, path_from
from ...boundary.json_schema import document, json_value, schema_of, write_toml
from ...numerics.ties import graded
from ...symbolic.added import AddedEffect, effect_schema, effect_text
from ...tires.signs import reversed_columns
from ...tires.tire import Tire
from ..explanations.answer import Answer, OneOf
from ..explanations.effect_evidence import Evidence
from ..unexplained.formula_proposal import Unknown
from .adequacy import Adequacy
from .extrapolation import Extrapolation
from .findings import FormCorrection, FoundEffect, turned_sign
from .parts import DiagnosisRun, Identifiability, Improvement, Misfit, WrittenFiles
from .summary import diagnosis_html, diagnosis_text
from .verdict import headline_text

#: The errors of a recording that have a sign, and its waves, whose amplitudes have none.
SIGNED = ("offset", "removed", "removed_base", "cross_talk", "cross_talk_base")
WAVES = ("periodic", "periodic_base")


@dataclass(frozen=True, eq=False, repr=False)
class Diagnosis:
    """Result of a diagnosis: missing effects, evidence, fit errors and the improved tire.

    What its parts contain is also an attribute of the diagnosis: `gap`, `delivered`, `not_identifiable`, ...

    Attributes
    ----------
    sentences : tuple of str
        The verdict; `verdict` has them in one line, `headline` what is missing in a few words.
    found : tuple of FoundEffect
        In order of probability.
    answer : Answer
        The compared explanations with their probabilities.
    confounded_with : mapping of str to mapping of str to float
        By identified effect: other explanations and their correlation with it.
    unknown : tuple of Unknown
    evidence : mapping of str to Evidence
        For each identified effect, in the final fit.
    adequacy : tuple of Adequacy
        By channel: residual over noise floor, and where the residual is largest.
    recording : mapping
        Errors of the recording: offsets, drift, cross-talk, ripple, quantisation, outliers, noise of the inputs,
        smoothing windows, excluded channels with the reason, ignored columns; ``removed``: what is subtracted from the
        residuals, by channel.
    base_tire, tire : Tire
        The baseline model, and the improved one if it is delivered, fitted to the training rows.
    signs : str
        Sign convention of coefficients, of ``recording`` (offset, cross-talk) and of residuals (``where``): "iso",
        as the tire file, unless changed by `in_signs`. Root mean squares and amplitudes have no sign.
    identifiability : Identifiability
        What the recording can show.
    misfit : Misfit
        Residuals before and after: sizes, places, times.
    improvement : Improvement
        The improved model beside its effects, and why it is not delivered.
    run : DiagnosisRun
        Rows, hold-out set, duration, files.
    """

    #: Version of diagnosis.json. New keys increment the second number, changed meanings the first.
    version: ClassVar[str] = "5.0"
    JSON_KEYS: ClassVar = (
        "version", "headline", "verdict", "found", "answer.reported as explanations", "one_of", "answer.probabilities",
        "confounded as confounded_with", "confounded_with as correlation", "next_measurement", "unknown",
        "identifiability.names as not_identifiable", "not_identifiable as not_identifiable_because", "refined", "gap",
        "adequacy_by_channel as adequacy", "delivered", "not_delivered_because", "evidence as confirmed", "detectable",
        "where", "where_after", "time_course", "recording", "extrapolation", "holdout_rows", "signs",
        "recording_signs", "run.files.tire", "run.files.fmu", "run.files.base_tire", "run.files.base_fmu", "seconds",
        "form", "stopped",
    )  # fmt: skip

    sentences: tuple[str, ...]
    found: Annotated[tuple[FoundEffect, ...], "in falling order of probability"]
    answer: Answer
    confounded_with: Mapping[str, Mapping[str, float]]
    unknown: tuple[Unknown, ...]
    evidence: Mapping[str, Evidence]
    adequacy: tuple[Adequacy, ...]
    recording: Annotated[Mapping[str, Any], "errors of the recording"]
    base_tire: Tire
    tire: Tire
    signs: str
    identifiability: Identifiability
    misfit: Misfit
    improvement: Improvement
    run: DiagnosisRun

    def in_signs(self, signs: str) -> Diagnosis:
        """Return the same diagnosis in another sign convention.

        Parameters
        ----------
        signs : {"iso", "adapted-sae"}

        Returns
        -------
        Diagnosis
            With the same tires.

        Raises
        ------
        UnknownName
            If this is not a sign convention of coefficients.
        """
        if signs not in ("iso", "adapted-sae"):
            raise UnknownName("sign convention of coefficients", signs, ("iso", "adapted-sae"))
        reversed_names = reversed_columns(self.signs, signs)
        if not reversed_names:
            return self
        turned = {key: _turned(self.recording[key], reversed_names) for key in SIGNED}
        for key in WAVES:
            waves = self.recording[key]
            turned[key] = [_turned(wave, reversed_names) | {"amplitude": wave["amplitude"]} for wave in waves]
        return replace(
            self,
            signs=signs,
            found=tuple(finding.mirrored() for finding in self.found),
            misfit=replace(
                self.misfit,
                where=[_turned_map(shown, reversed_names) for shown in self.where],
                where_after=[_turned_map(shown, reversed_names) for shown in self.where_after],
            ),
            recording={**self.recording, **turned},
        )

    @property
    def verdict(self) -> str:
        """The verdict in one line."""
        return ". ".join(self.sentences)

    @property
    def headline(self) -> str:
        """What is missing, in a few words."""
        return headline_text(self.found, self.adequacy, self.delivered, bool(self.stopped), self.one_of)

    @property
    def one_of(self) -> tuple[OneOf, ...]:
        """Effects of which one is missing, which the recording does not separate: one of them is in `found`."""
        return self.answer.one_of(finding.effect for finding in self.found)

    @property
    def confounded(self) -> dict[str, list[str]]:
        """The explanations that each identified effect is confounded with, the most similar one first."""
        return {
            name: sorted(others, key=lambda other: -graded(others[other]))
            for name, others in self.confounded_with.items()
        }

    @property
    def adequacy_by_channel(self) -> dict[str, Adequacy]:
        """The residual of each channel compared with its noise floor."""
        return {rated.channel: rated for rated in self.adequacy}

    @property
    def delivered(self) -> bool:
        """Whether the improved tire is delivered; otherwise `tire` is the baseline tire."""
        return not self.not_delivered_because

    @property
    def detectable(self) -> Mapping[str, Mapping[str, float]]:
        """The smallest change of the force that would have been identified, root mean square, by effect and channel."""
        return self.identifiability.detectable

    @property
    def not_identifiable(self) -> Mapping[str, str]:
        """Effects that this recording cannot identify, and the reason."""
        return self.identifiability.not_identifiable

    @property
    def next_measurement(self) -> tuple[str, ...]:
        """Measurements that separate confounded explanations."""
        return self.identifiability.next_measurement

    @property
    def gap(self) -> Mapping[str, Mapping[str, Mapping[str, float]]]:
        """Root mean square residuals by rows (train, cv, holdout) and channel, N and N m.

        before, after, floor: of the fitted tires over the compared rows with all errors of the recording removed
        (`recording`), and the noise floor (`tirefmu.numerics.noise_floor`). ``after`` is the residual of the delivered
        tire.
        """
        return self.misfit.gap

    @property
    def where(self) -> list[dict[str, Any]]:
        """Residuals of the baseline model over noise, by channel and pairs of inputs.

        See `residual_location.residual_maps`.
        """
        return self.misfit.where

    @property
    def where_after(self) -> list[dict[str, Any]]:
        """Residuals of the improved model over noise, by channel and pairs of inputs."""
        return self.misfit.where_after

    @property
    def time_course(self) -> Mapping[str, Mapping[str, list[float]]]:
        """Misfit over noise by channel and time block (`residual_location.time_course`)."""
        return self.misfit.time_course

    @property
    def refined(self) -> tuple[str, ...]:
        """Finer forms that the recording needs, of effects that the baseline model already had."""
        return self.improvement.refined

    @property
    def form(self) -> FormCorrection:
        """The correction of the formula's own form, effect form of the tire."""
        return self.improvement.form

    @property
    def extrapolation(self) -> tuple[Extrapolation, ...]:
        """Measured ranges of the inputs of identified effects, and the change of the effects outside them."""
        return self.improvement.extrapolation

    @property
    def not_delivered_because(self) -> tuple[str, ...]:
        """Why `tire` is the baseline tire; empty if it is the improved one."""
        return self.improvement.not_delivered_because

    @property
    def rows(self) -> pd.DataFrame:
        """The rows of the recording, in its signs."""
        return self.run.rows

    @property
    def recording_signs(self) -> str:
        """Sign convention of the recording."""
        return self.run.recording_signs

    @property
    def holdout_rows(self) -> tuple[Sequence[int], ...]:
        """First and last row, counted from 0, of each stretch of the hold-out set, which no fit uses."""
        return self.run.holdout_rows

    @property
    def seconds(self) -> float:
        """Wall time, s."""
        return self.run.seconds

    @property
    def stopped(self) -> str:
        """Why explanations that remained were not compared, or empty."""
        return self.run.stopped

    @property
    def rating(self) -> str:
        """The worst rating of a channel: "green", "amber" or "red"; amber at best if the tire is not delivered."""
        ratings = {rated.rating for rated in self.adequacy} | ({"amber"} if not self.delivered else set())
        return next((color for color in ("red", "amber") if color in ratings), "green")

    @property
    def proposed(self) -> tuple[AddedEffect, ...]:
        """The effects that the diagnosis wrote itself."""
        return tuple(part.effect for part in self.unknown if part.effect is not None)

    def __repr__(self) -> str:
        """Return the verdict, the findings with their evidence, and the hold-out error before and after."""
        return diagnosis_text(self)

    def _repr_html_(self) -> str:
        """Return the summary with a table of coefficients, for a notebook."""
        return diagnosis_html(self)

    def holdout_mask(self, n: int) -> npt.NDArray[np.bool_]:
        """Return which of a recording's n rows are in the hold-out set.

        Parameters
        ----------
        n : int
        """
        rows = np.zeros(n, dtype=bool)
        for first, last in self.holdout_rows:
            rows[first : last + 1] = True
        return rows

    def to_json(self, *, tire: str = "", base_tire: str = "", fmu: str = "", base_fmu: str = "") -> dict[str, Any]:
        """Return the contents of diagnosis.json.

        Parameters
        ----------
        tire, base_tire, fmu, base_fmu : str
            Paths of the written files, relative to the folder.

        Returns
        -------
        dict
            JSON types only; a number that does not exist is null.
        """
        files = WrittenFiles(tire, fmu, base_tire, base_fmu)
        return dict(json_value(replace(self, run=replace(self.run, files=files))))

    def save(self, folder: str | Path) -> Path:
        """Write diagnosis.json, both tires and proposed effects (NAME.toml) into a folder, created if necessary.

        Parameters
        ----------
        folder : str or Path

        Returns
        -------
        Path
            Path of diagnosis.json.

        Raises
        ------
        DataError
            If the folder cannot be written.
        """
        path = path_from(folder, "folder")
        try:
            path.mkdir(parents=True, exist_ok=True)
            self.tire.save(path / "improved.tir")
            self.base_tire.save(path / "base.tir")
            for proposed in self.proposed:
                write_toml(path / f"{proposed.name}.toml", effect_text(proposed), effect_schema())
            content = self.to_json(tire="improved.tir", base_tire="base.tir")
            (path / "diagnosis.json").write_text(json.dumps(content, indent=1) + "\n", encoding="utf-8")
        except OSError as error:
            raise DataError(f"{path}: cannot be written ({error.strerror or error})") from None
        return path / "diagnosis.json"


def _turned(value: Any, reversed_names: Collection[str], turned: bool = False) -> Any:
    """Return numbers by channel, those of reversed channels with the opposite sign.

    The share of one force in another, Fx_in_Fy, has it if one of the two is reversed.
    """
    if isinstance(value, Mapping):
        both = {name: len({*reversed_names}.intersection(name.split("_in_"))) == 1 for name in value}
        return {name: _turned(item, reversed_names, turned != both[name]) for name, item in value.items()}
    if isinstance(value, list):
        return [_turned(item, reversed_names, turned) for item in value]
    return turned_sign(value, turned) if isinstance(value, float) else value


def _turned_map(shown: dict[str, Any], reversed_names: Collection[str]) -> dict[str, Any]:
    """Return a map of `residual_location.residual_maps`, that of a reversed channel with the opposite sign."""
    turned = shown["channel"] in reversed_names
    worst = {**shown["worst"], "mean": turned_sign(shown["worst"]["mean"], turned)}
    return {**shown, "mean": _turned(shown["mean"], (), turned), "worst": worst}


def diagnosis_schema() -> dict[str, Any]:
    """Return the JSON Schema of diagnosis.json; not all of its writers write the last keys."""
    schema = schema_of(Diagnosis, missing=True)
    schema["properties"] |= {
        "ok": schema_of(
            Annotated[bool, "of the command's --json only: whether each FMU agrees with direct evaluation"]
        ),
        "simulated": schema_of(Annotated[dict[str, Any], "errors of both FMUs over the recordings"]),
    }
    return document("diagnosis", Diagnosis.version, "Result of a diagnosis", schema)
