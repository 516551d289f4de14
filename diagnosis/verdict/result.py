"""The result of a diagnosis and its JSON."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt
import pandas as pd

from ...boundary.errors import DataError, UnknownName, path_from
from ...boundary.json_schema import json_value, write_toml
from ...numerics.ties import graded
from ...symbolic.added import AddedEffect, effect_schema, effect_text
from ...tires.signs import reversed_columns
from ...tires.tire import Tire
from ..explanations.answer import Answer, OneOf
from ..explanations.effect_evidence import Evidence
from ..unexplained.formula_proposal import Unknown
from .adequacy import Adequacy
from .content import (
    VERSION,
    AdequacyContent,
    DiagnosisContent,
    EvidenceContent,
    ExtrapolationContent,
    FoundContent,
    Size,
    UnknownContent,
)
from .extrapolation import Extrapolation
from .findings import FormCorrection, FoundEffect, turned_sign
from .summary import diagnosis_html, diagnosis_text
from .verdict import headline_text

#: Of a diagnosis whose tires have no correction of the form.
NO_FORM = FormCorrection({}, False)


@dataclass(frozen=True, eq=False, repr=False)
class Diagnosis:
    """Result of a diagnosis: missing effects, evidence, fit errors and the improved tire.

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
    next_measurement : tuple of str
        Measurements that separate confounded explanations.
    unknown : tuple of Unknown
    not_identifiable : mapping of str to str
        Effects that this recording cannot identify, and the reason.
    refined : tuple of str
        Finer forms that the recording needs, of effects that the baseline model already had.
    gap : mapping
        train, cv, holdout -> channel -> before, after, floor, floor_with_history: root mean square residuals of the
        fitted tires over the compared rows, N and N m, with all errors of the recording removed (``recording``), and
        noise floors (`tirefmu.numerics.noise_floor`). ``after`` is the residual of the delivered tire.
    adequacy : tuple of Adequacy
        By channel: residual over noise floor, and where the residual is largest.
    delivered : bool
        Whether `tire` is the improved tire; otherwise it is the baseline tire.
    not_delivered_because : tuple of str
    evidence : mapping of str to Evidence
        For each identified effect, in the final fit.
    detectable : mapping of str to mapping of str to float
        By effect and channel: the smallest change of the force, root mean square, that would have been identified.
    where, where_after : list of dict
        Residuals of the baseline and the improved model over noise, by channel and pairs of inputs
        (`residual_location.residual_maps`).
    time_course : mapping
        Misfit over noise by channel and time block (`residual_location.time_course`).
    recording : mapping
        Errors of the recording: offsets, drift, cross-talk, ripple, quantisation, outliers, noise of the inputs,
        smoothing windows, excluded channels with the reason, ignored columns; ``removed``: what is subtracted from the
        residuals, by channel.
    extrapolation : tuple of Extrapolation
        Measured ranges of the inputs of identified effects, and the change of the effects outside them.
    holdout_rows : tuple of (int, int)
        First and last row, counted from 0, of each stretch of the hold-out set, which no fit uses.
    base_tire, tire : Tire
        The baseline model and the improved one, fitted to the training rows.
    signs : str
        Sign convention of coefficients, of ``recording`` (offset, cross-talk) and of residuals (``where``): "iso",
        as the tire file, unless changed by `in_signs`. Root mean squares and amplitudes have no sign.
    recording_signs : str
        Sign convention of the recording and of ``rows``.
    seconds : float
    stopped : str
        Why explanations that remained were not compared, or ''.
    form : FormCorrection
        The correction of the formula's own form in the delivered tire.
    """

    sentences: tuple[str, ...]
    found: tuple[FoundEffect, ...]
    answer: Answer
    confounded_with: Mapping[str, Mapping[str, float]]
    next_measurement: tuple[str, ...]
    unknown: tuple[Unknown, ...]
    not_identifiable: Mapping[str, str]
    refined: tuple[str, ...]
    gap: Mapping[str, Mapping[str, Mapping[str, float]]]
    adequacy: tuple[Adequacy, ...]
    delivered: bool
    not_delivered_because: tuple[str, ...]
    evidence: Mapping[str, Evidence]
    detectable: Mapping[str, Mapping[str, float]]
    where: list[dict[str, Any]]
    where_after: list[dict[str, Any]]
    time_course: Mapping[str, Mapping[str, list[float]]]
    recording: Mapping[str, Any]
    extrapolation: tuple[Extrapolation, ...]
    holdout_rows: tuple[tuple[int, int], ...]
    base_tire: Tire
    tire: Tire
    signs: str
    recording_signs: str
    seconds: float
    rows: pd.DataFrame
    stopped: str = ""
    form: FormCorrection = NO_FORM

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
        offset = {name: turned_sign(value, name in reversed_names) for name, value in self.recording["offset"].items()}
        turned: dict[str, Any] = {}
        for end in ("", "_base"):
            turned[f"removed{end}"] = {
                name: {
                    "offset": turned_sign(removed["offset"], name in reversed_names),
                    "drift": [turned_sign(value, name in reversed_names) for value in removed["drift"]],
                }
                for name, removed in self.recording[f"removed{end}"].items()
            }
            turned[f"periodic{end}"] = [
                wave
                | {
                    part: {name: turned_sign(value, name in reversed_names) for name, value in wave[part].items()}
                    for part in ("cosine", "sine")
                }
                for wave in self.recording[f"periodic{end}"]
            ]
            turned[f"cross_talk{end}"] = {  # the share of one force in another: Fx_in_Fy
                name: turned_sign(value, len(reversed_names & set(name.split("_in_"))) == 1)
                for name, value in self.recording[f"cross_talk{end}"].items()
            }
        return replace(
            self,
            signs=signs,
            found=tuple(finding.mirrored() for finding in self.found),
            where=[_mirrored_map(shown) if shown["channel"] in reversed_names else shown for shown in self.where],
            where_after=[
                _mirrored_map(shown) if shown["channel"] in reversed_names else shown for shown in self.where_after
            ],
            recording={**self.recording, "offset": offset, **turned},
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
        """Effects of which one is missing, where the recording does not tell which: one of them is in `found`."""
        return self.answer.one_of(finding.effect for finding in self.found)

    @property
    def rating(self) -> str:
        """The worst rating of a channel: "green", "amber" or "red"; amber at best if the tire is not delivered."""
        ratings = {rated.rating for rated in self.adequacy} | ({"amber"} if not self.delivered else set())
        return next((color for color in ("red", "amber") if color in ratings), "green")

    @property
    def proposed(self) -> tuple[AddedEffect, ...]:
        """The effects that the diagnosis wrote itself."""
        return tuple(part.effect for part in self.unknown if part.effect is not None)

    @property
    def _summarized(
        self,
    ) -> tuple[tuple[str, ...], tuple[FoundEffect, ...], Mapping[str, Mapping[str, float]], int, str]:
        return (self.headline, *self.sentences), self.found, self.gap["holdout"], len(self.rows), self.signs

    def __repr__(self) -> str:
        """Return the verdict, the findings with their evidence, and the hold-out error before and after."""
        return diagnosis_text(*self._summarized)

    def _repr_html_(self) -> str:
        """Return the summary with a table of coefficients, for a notebook."""
        return diagnosis_html(*self._summarized)

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
        content = _content(
            DiagnosisContent,
            self,
            version=VERSION,
            found=[_content(FoundContent, finding, size=_sizes(finding)) for finding in self.found],
            explanations=self.answer.reported,
            probabilities=self.answer.probabilities,
            confounded_with={
                name: sorted(others, key=lambda x: -graded(others[x])) for name, others in self.confounded_with.items()
            },
            correlation=self.confounded_with,
            unknown=[
                _content(UnknownContent, part, file=f"{part.effect.name}.toml" if part.effect else None)
                for part in self.unknown
            ],
            not_identifiable=sorted(self.not_identifiable),
            not_identifiable_because=self.not_identifiable,
            adequacy={rated.channel: _content(AdequacyContent, rated, where=rated.location) for rated in self.adequacy},
            confirmed={name: _content(EvidenceContent, evidence) for name, evidence in self.evidence.items()},
            extrapolation=[_content(ExtrapolationContent, part) for part in self.extrapolation],
            tire=tire,
            fmu=fmu,
            base_tire=base_tire,
            base_fmu=base_fmu,
            seconds=round(self.seconds, 2),
            form={
                "channels": {name: {"rms": rms, "largest": most} for name, (rms, most) in self.form.channels.items()},
                "delivered": self.form.delivered,
            },
        )
        return dict(json_value(content))

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


def _content(kind: type, result: object, **others: Any) -> dict[str, Any]:
    """Return the keys of a typed dictionary with other values, or the attributes of a result of the same names."""
    return {
        key: others.get(key, getattr(result, key, None))
        for key in kind.__annotations__
        if key in others or hasattr(result, key)
    }


def _sizes(finding: FoundEffect) -> dict[str, Size]:
    return {name: {"rms": rms, "largest": largest} for name, (rms, largest) in finding.size.items()}


def _mirrored_map(shown: dict[str, Any]) -> dict[str, Any]:
    """Return a map of `residual_location.residual_maps` with the opposite sign; cells without rows have no mean."""
    mean = [[None if cell is None else turned_sign(cell) for cell in row] for row in shown["mean"]]
    return {**shown, "mean": mean, "worst": {**shown["worst"], "mean": turned_sign(shown["worst"]["mean"])}}
