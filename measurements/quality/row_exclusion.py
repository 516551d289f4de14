"""Screening a recording: which rows are set aside before a fit, and why. Nothing is dropped unseen."""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from tirefmu.symbolic.errors import DataError

from ..channels import INPUTS, OUTPUTS
from ..operating_conditions.phases import transitions
from ..recording import Recording
from .outliers import outliers

#: Why a row is set aside, the first that holds; each with what it means.
EXCLUSION_REASONS: Mapping[str, str] = {
    "lifted": "the wheel carries no load",
    "standing": "the wheel stands",
    "warm-up": "the tread is still cold",
    "transition": "a held input goes from one level to another, or the tire has not settled since",
    "outlier": "a reading stands off the course of its channel",
}
_LIFTED = 0.02  # of the largest load
_STANDING = 0.5  # m/s
_COLDER = 15.0  # K below what the tread keeps later on: less is the swing within and between sweeps
_WARM = 5.0  # K below: from here on it is warm
_LONGEST_WARM_UP = 0.5  # of the rows; a tread that warms for longer was never warm
_SAYS_WARM_UP = re.compile(r"warm[\s_-]*up", re.IGNORECASE)


@dataclass(frozen=True, eq=False)
class RowExclusion:
    """What a screening found.

    Parameters
    ----------
    recording : Recording
        As it was recorded: scores count all of its rows.
    reasons : ndarray of str, shape (n,)
        Why each row is set aside (a name of `EXCLUSION_REASONS`); "" where it is kept.
    notes : tuple of str
        One sentence for each thing found: where, what, and how many rows.

    Examples
    --------
    >>> import pandas as pd
    >>> rows = pd.DataFrame({"alpha": [0.0, 0.1, 0.2, 0.3], "Fz": [900.0, 900.0, 0.0, 900.0], "Fy": -1.0})
    >>> result = exclude_rows(Recording(rows, "iso", "a.csv"))
    >>> result.included.tolist(), result.counts
    ([True, True, False, True], {'lifted': 1})
    >>> result.usable().table["Fy"].tolist()
    [-1.0, -1.0, nan, -1.0]
    """

    recording: Recording
    reasons: NDArray[np.object_]
    notes: tuple[str, ...]

    @property
    def included(self) -> NDArray[np.bool_]:
        """Which rows are kept: ndarray of bool, shape (n,)."""
        return np.asarray(self.reasons == "", dtype=np.bool_)

    @property
    def counts(self) -> dict[str, int]:
        """How many rows are set aside, by reason, in the order of `EXCLUSION_REASONS`."""
        found = {reason: int(np.count_nonzero(self.reasons == reason)) for reason in EXCLUSION_REASONS}
        return {reason: count for reason, count in found.items() if count}

    def usable(self) -> Recording:
        """Return the recording with the outputs of rows set aside as not measured.

        Inputs, clock and the number of rows stay, so that slips can lag and rows can be told.

        Returns
        -------
        Recording

        Raises
        ------
        DataError
            If no row is kept; says why.
        """
        if not self.included.any():
            why = ", ".join(f"{count} {reason} ({EXCLUSION_REASONS[reason]})" for reason, count in self.counts.items())
            raise DataError(
                f"{self.recording.source}: none of {len(self.recording)} rows can be used: {why or 'no rows'}"
            )
        table = self.recording.table
        measured = {name: table[name].where(self.included) for name in OUTPUTS if name in table}
        return replace(self.recording, table=table.assign(**measured))


def exclude_rows(
    recording: Recording,
    *,
    warm_up: bool = True,
    in_transit: bool = True,
    off_course: bool = True,
    settling: float = 0.3,
) -> RowExclusion:
    """Find the rows of a recording that say nothing of the steady, warm tire.

    Parameters
    ----------
    recording : Recording
    warm_up, in_transit, off_course : bool
        Whether to look for rows of a cold tread, for transitions between levels, for outliers.
    settling : float
        s after a transition until the tire has settled; three relaxation lengths of 0.5 m at 5 m/s.

    Returns
    -------
    RowExclusion

    Raises
    ------
    DataError
        If an input is not finite.
    """
    _check_inputs(recording)
    reasons = np.full(len(recording), "", dtype=object)
    findings: list[str] = []

    def set_aside(rows: NDArray[np.bool_], reason: str, sentence: str) -> None:
        fresh = rows & (reasons == "")
        if fresh.any():
            reasons[fresh] = reason
            findings.append(f"{reason}: {fresh.sum()} of {len(recording)} rows{_from_to(fresh)}: {sentence}")

    set_aside(_lifted(recording), "lifted", EXCLUSION_REASONS["lifted"])
    set_aside(_standing(recording), "standing", EXCLUSION_REASONS["standing"])
    if warm_up:
        rows, sentence = _warm_up(recording)
        set_aside(rows, "warm-up", sentence)
    if in_transit:
        moving = transitions(recording, settling=settling)
        for name in INPUTS:
            set_aside(moving == name, "transition", f"{name} goes from one level to another")
    for reading in outliers(recording) if off_course else ():
        if reasons[reading.row] in ("", "outlier"):
            reasons[reading.row] = "outlier"
            findings.append(f"outlier: {reading}")
    return RowExclusion(recording, reasons, tuple(findings))


def _check_inputs(recording: Recording) -> None:
    for name in INPUTS:
        if name in recording.table:
            bad = np.flatnonzero(~np.isfinite(recording.table[name].to_numpy(dtype=np.float64)))
            if len(bad):
                where = f"{recording.source}: row {bad[0] + 1}"
                raise DataError(f"{where}: {name} is not finite ({len(bad)} of {len(recording)} rows)")


def _from_to(rows: NDArray[np.bool_]) -> str:
    """Say where rows stand if they are one stretch."""
    at = np.flatnonzero(rows)
    return f" ({at[0] + 1} to {at[-1] + 1})" if len(at) > 1 and at[-1] - at[0] + 1 == len(at) else ""


def _load(recording: Recording) -> NDArray[np.float64]:
    """Return the load, positive where the wheel is pressed to the ground."""
    load = recording.table["Fz"].to_numpy(dtype=np.float64)
    return -load if recording.signs == "sae" else load


def _lifted(recording: Recording) -> NDArray[np.bool_]:
    if "Fz" not in recording.table or not len(recording):
        return np.zeros(len(recording), dtype=np.bool_)
    load = _load(recording)
    return np.asarray(load <= _LIFTED * max(float(load.max()), 0.0))


def _standing(recording: Recording) -> NDArray[np.bool_]:
    if "V" not in recording.table:
        return np.zeros(len(recording), dtype=np.bool_)
    return np.asarray(np.abs(recording.table["V"].to_numpy(dtype=np.float64)) < _STANDING)


def _warm_up(recording: Recording) -> tuple[NDArray[np.bool_], str]:
    """Return the leading rows of a cold tread, by what the file says of itself or by the tread's temperature."""
    rows = np.zeros(len(recording), dtype=np.bool_)
    for word in (recording.source, recording.about.get("testid", "")):
        if _SAYS_WARM_UP.search(word):
            return ~rows, f"the recording calls itself {word!r}"
    if "T" not in recording.table or not len(recording):
        return rows, ""
    temperature = recording.table["T"].to_numpy(dtype=np.float64)
    usual = float(np.quantile(temperature[len(rows) // 2 :], 0.05))
    if temperature[0] >= usual - _COLDER:
        return rows, ""
    # The end is the first warm row: within a sweep the tread cools again.
    end = int(np.argmax(temperature >= usual - _WARM))
    rows[:end] = end <= _LONGEST_WARM_UP * len(rows)
    return rows, f"the tread warms from {temperature[0]:.0f} to the {usual:.0f} deg C that it keeps"
