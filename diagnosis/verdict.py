"""What a diagnosis says: the result object and its JSON."""

from __future__ import annotations

import json
import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import pandas as pd

from tirefmu.symbolic.added import AddedEffect
from tirefmu.symbolic.errors import DataError
from tirefmu.tires.tire import Tire

#: Version of diagnosis.json: a new key raises the second number, a changed meaning the first.
VERSION = "1.1"


@dataclass(frozen=True)
class Interval:
    """A coefficient's value and the 95 % interval under coloured noise."""

    value: float
    lower: float
    upper: float


@dataclass(frozen=True)
class Finding:
    """A missing effect.

    Attributes
    ----------
    effect : str
        Its name, or "UNKNOWN".
    channels : tuple of str
        Those in which it shows.
    coefficients : mapping of str to Interval
        In the recording's signs.
    p : float
        Probability of such a trace by chance, under coloured noise, adjusted for everything tried.
    cv_gain, cv_gain_se : float
        Share of the squared misfit that it takes away in blocked cross-validation, and its standard error.
    when : tuple of (float, float)
        The stretches of time, s, that carry most of the evidence.
    """

    effect: str
    channels: tuple[str, ...]
    coefficients: Mapping[str, Interval]
    p: float
    cv_gain: float
    cv_gain_se: float
    when: tuple[tuple[float, float], ...] = ()


@dataclass(frozen=True)
class Unknown:
    """Structure that no known effect explains.

    Attributes
    ----------
    depends_on : tuple of str
    formula : str
        As it would stand in an effect file: "quantity: factor or term".
    added : bool
        Whether the improved tire has it: only if the untouched hold-out improves.
    effect : AddedEffect or None
        The proposed effect file.
    not_added_because : str
        "" where it was added.
    next_measurement : str
        What would show its form.
    """

    depends_on: tuple[str, ...]
    formula: str
    added: bool
    effect: AddedEffect | None = None
    not_added_because: str = ""
    next_measurement: str = ""


@dataclass(frozen=True, eq=False)
class Diagnosis:
    """The answer to the question which effect is missing.

    Attributes
    ----------
    verdict : str
        One line.
    found : tuple of Finding
        In order of evidence.
    confounded_with : mapping of str to mapping of str to float
        By finding: other explanations and their correlation with it.
    next_measurement : tuple of str
        What would tell them apart.
    unknown : tuple of Unknown
    not_identifiable : mapping of str to str
        Effects that this recording could not have shown, and why.
    refined : tuple of str
        Finer forms of effects that the model had already.
    gap : mapping
        train, cv, holdout -> channel -> before, after, floor: root mean squares, N and N m, with the recording's
        disturbances taken out.
    detectable : mapping of str to mapping of str to float
        By effect and channel: the smallest trace, root mean square, that would have been named.
    where : list of dict
        Residuals of the start model over noise, by channel and pairs of inputs (`where.residual_maps`).
    recording : mapping
        What belongs to the recording: offsets, drift, cross-talk, ripple, outliers, noise of inputs.
    base_tire, tire : Tire
        The start model and the improved one, fitted to the training rows.
    signs : str
        The recording's.
    seconds : float
    """

    verdict: str
    found: tuple[Finding, ...]
    confounded_with: Mapping[str, Mapping[str, float]]
    next_measurement: tuple[str, ...]
    unknown: tuple[Unknown, ...]
    not_identifiable: Mapping[str, str]
    refined: tuple[str, ...]
    gap: Mapping[str, Mapping[str, Mapping[str, float]]]
    detectable: Mapping[str, Mapping[str, float]]
    where: list[dict[str, Any]]
    recording: Mapping[str, Any]
    base_tire: Tire
    tire: Tire
    signs: str
    seconds: float
    rows: pd.DataFrame = field(repr=False)

    def to_json(self, *, tire: str = "", base_tire: str = "", fmu: str = "", base_fmu: str = "") -> dict[str, Any]:
        """Return what diagnosis.json holds.

        Parameters
        ----------
        tire, base_tire, fmu, base_fmu : str
            Paths of what was written, relative to the folder.

        Returns
        -------
        dict
            Only what JSON knows; a number that does not exist is null.
        """
        told = {
            "version": VERSION,
            "verdict": self.verdict,
            "found": [
                {
                    "effect": one.effect,
                    "channels": list(one.channels),
                    "coefficients": {name: vars(value) for name, value in one.coefficients.items()},
                    "p": one.p,
                    "cv_gain": one.cv_gain,
                    "cv_gain_se": one.cv_gain_se,
                    "when": [list(stretch) for stretch in one.when],
                }
                for one in self.found
            ],
            "confounded_with": {
                name: sorted(others, key=lambda x: -others[x]) for name, others in self.confounded_with.items()
            },
            "correlation": {name: dict(others) for name, others in self.confounded_with.items()},
            "next_measurement": list(self.next_measurement),
            "unknown": [
                {
                    "depends_on": list(one.depends_on),
                    "formula": one.formula,
                    "added": one.added,
                    "not_added_because": one.not_added_because,
                }
                for one in self.unknown
            ],
            "not_identifiable": sorted(self.not_identifiable),
            "not_identifiable_because": dict(self.not_identifiable),
            "refined": list(self.refined),
            "gap": self.gap,
            "detectable": self.detectable,
            "where": self.where,
            "recording": self.recording,
            "signs": self.signs,
            "tire": tire,
            "fmu": fmu,
            "base_tire": base_tire,
            "base_fmu": base_fmu,
            "seconds": round(self.seconds, 2),
        }
        return dict(_plain(told))

    def save(self, folder: str | Path) -> Path:
        """Write diagnosis.json and both tires into a folder, which is made where it is missing.

        Parameters
        ----------
        folder : str or Path

        Returns
        -------
        Path
            Of diagnosis.json.

        Raises
        ------
        DataError
            If the folder cannot be written.
        """
        place = Path(folder)
        try:
            place.mkdir(parents=True, exist_ok=True)
            self.tire.save(place / "improved.tir")
            self.base_tire.save(place / "base.tir")
            told = self.to_json(tire="improved.tir", base_tire="base.tir")
            (place / "diagnosis.json").write_text(json.dumps(told, indent=1) + "\n", encoding="utf-8")
        except OSError as error:
            raise DataError(f"{place}: cannot be written ({error.strerror or error})") from None
        return place / "diagnosis.json"


def _plain(value: Any) -> Any:
    """Return a value in JSON's own types."""
    if isinstance(value, Mapping):
        return {str(key): _plain(item) for key, item in value.items()}
    if isinstance(value, (list, tuple)):
        return [_plain(item) for item in value]
    if isinstance(value, (bool, int, str)) or value is None:
        return value
    return float(value) if math.isfinite(float(value)) else None
