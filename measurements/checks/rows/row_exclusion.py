"""Excluded rows of a recording: rows that do not represent the steady, warm tire, each with the reason."""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ....boundary.errors import DataError
from ....numerics.arrays import BoolArray, FloatArray
from ....symbolic.channels import INPUTS
from ...operating_conditions.phases import transitions
from ...recording import Recording
from ...thresholds import (
    COLD_START,
    LATER_TEMPERATURE_QUANTILE,
    LIFTED_LOAD,
    LONGEST_WARM_UP,
    SETTLING_TIME,
    STANDING_SPEED,
    WARM_TREAD,
)
from .outliers import outliers

#: Reasons to exclude a row, with their meaning. If several apply to a row, the first one counts.
EXCLUSION_REASONS: Mapping[str, str] = {
    "lifted": "the wheel carries no load",
    "standing": "the wheel does not roll",
    "warm-up": "the tread is still cold",
    "transition": "a held input changes from one level to another, or the tire has not settled yet",
    "outlier": "a value is far from the running median of its channel",
}
_WARM_UP_NAME = re.compile(r"warm[\s_-]*up", re.IGNORECASE)


@dataclass(frozen=True, eq=False)
class RowExclusion:
    """A recording and its excluded rows.

    Parameters
    ----------
    recording : Recording
        As recorded, with all rows.
    reasons : ndarray of str, shape (n,)
        Why each row is excluded (a name of `EXCLUSION_REASONS`); "" if it is included.
    notes : tuple of str
        One sentence for each group of excluded rows: reason, number of rows, details.

    Examples
    --------
    >>> import pandas as pd
    >>> rows = pd.DataFrame({"alpha": [0.0, 0.1, 0.2, 0.3], "Fz": [900.0, 900.0, 0.0, 900.0], "Fy": -1.0})
    >>> result = exclude_rows(Recording(rows, "iso", "a.csv"))
    >>> result.included.tolist(), result.counts
    ([True, True, False, True], {'lifted': 1})
    """

    recording: Recording
    reasons: NDArray[np.object_]
    notes: tuple[str, ...]

    @property
    def included(self) -> BoolArray:
        """Which rows are included: ndarray of bool, shape (n,)."""
        return np.asarray(self.reasons == "", dtype=np.bool_)

    @property
    def counts(self) -> dict[str, int]:
        """The number of excluded rows by reason, in the order of `EXCLUSION_REASONS`."""
        counts = {reason: int(np.count_nonzero(self.reasons == reason)) for reason in EXCLUSION_REASONS}
        return {reason: count for reason, count in counts.items() if count}


def exclude_rows(recording: Recording) -> RowExclusion:
    """Return the rows of a recording that do not represent the steady, warm tire.

    Parameters
    ----------
    recording : Recording
        In any signs.

    Returns
    -------
    RowExclusion
        For each row whether a fit uses it, and the reason if not.

    Raises
    ------
    DataError
        If an input is not finite.
    """
    check_inputs(recording)
    reasons = np.full(len(recording), "", dtype=object)
    notes: list[str] = []

    def exclude(rows: BoolArray, reason: str, details: str) -> None:
        added = rows & (reasons == "")
        if added.any():
            reasons[added] = reason
            notes.append(f"{reason}: {added.sum()} of {len(recording)} rows{_row_range(added)}: {details}")

    exclude(_lifted(recording), "lifted", EXCLUSION_REASONS["lifted"])
    exclude(_standing(recording), "standing", EXCLUSION_REASONS["standing"])
    rows, details = _warm_up(recording)
    exclude(rows, "warm-up", details)
    changing = transitions(recording, settling=SETTLING_TIME)
    for name in INPUTS:
        exclude(changing == name, "transition", f"{name} changes from one level to another")
    for value in outliers(recording):
        if reasons[value.row] in ("", "outlier"):
            reasons[value.row] = "outlier"
            notes.append(f"outlier: {value}")
    return RowExclusion(recording, reasons, tuple(notes))


def check_inputs(recording: Recording) -> None:
    """Raise a DataError if an input is not finite."""
    for name in INPUTS:
        if name in recording.table:
            bad = np.flatnonzero(~np.isfinite(recording.table[name].to_numpy(dtype=np.float64)))
            if len(bad):
                row = f"{recording.source}: row {bad[0] + 1}"
                raise DataError(f"{row}: {name} is not finite ({len(bad)} of {len(recording)} rows)")


def _row_range(rows: BoolArray) -> str:
    """Return the first and the last row if the rows are consecutive."""
    at = np.flatnonzero(rows)
    return f" ({at[0] + 1} to {at[-1] + 1})" if len(at) > 1 and at[-1] - at[0] + 1 == len(at) else ""


def _load(recording: Recording) -> FloatArray:
    """Return the load, positive where the wheel is pressed to the ground."""
    load = recording.table["Fz"].to_numpy(dtype=np.float64)
    return -load if recording.signs == "sae" else load


def _lifted(recording: Recording) -> BoolArray:
    if "Fz" not in recording.table or not len(recording):
        return np.zeros(len(recording), dtype=np.bool_)
    load = _load(recording)
    return np.asarray(load <= LIFTED_LOAD * max(float(load.max()), 0.0))


def _standing(recording: Recording) -> BoolArray:
    if "V" not in recording.table:
        return np.zeros(len(recording), dtype=np.bool_)
    return np.asarray(np.abs(recording.table["V"].to_numpy(dtype=np.float64)) < STANDING_SPEED)


def _warm_up(recording: Recording) -> tuple[BoolArray, str]:
    """Return the rows of the warm-up, by the name of the recording or by the tread temperature, and the evidence."""
    rows = np.zeros(len(recording), dtype=np.bool_)
    for name in (recording.source, recording.about.get("testid", "")):
        if _WARM_UP_NAME.search(name):
            return ~rows, f"the recording is named {name!r}"
    if "T" not in recording.table or not len(recording):
        return rows, ""
    temperature = recording.table["T"].to_numpy(dtype=np.float64)
    later = float(np.quantile(temperature[len(rows) // 2 :], LATER_TEMPERATURE_QUANTILE))
    if temperature[0] >= later - COLD_START:
        return rows, ""
    # The first warm row is the end, although the tread cools again within a sweep.
    end = int(np.argmax(temperature >= later - WARM_TREAD))
    rows[:end] = end <= LONGEST_WARM_UP * len(rows)
    return rows, f"the tread warms from {temperature[0]:.0f} deg C to {later:.0f} deg C"
