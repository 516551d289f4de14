"""A recording in a file that is too large for the memory: screened, weighted and read part by part.

A part is treated as a recording of its length: levels, transitions and outliers are found in it, and its end is the end
of a segment. Weights by operating condition are those of the whole recording.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt
import pandas as pd

from tirefmu.measurements import Recording, exclude_rows, group_by_condition
from tirefmu.measurements.channels import INPUTS
from tirefmu.measurements.large_table import LargeTable
from tirefmu.measurements.operating_conditions.grouping import Grouping, weights_of_parts
from tirefmu.measurements.operating_conditions.phases import motions_of

FloatArray = npt.NDArray[np.float64]

#: Rows of a part: 40 minutes at 100 Hz, many sweeps at each level, and 100 MB while they are screened.
PART = 250_000


@dataclass(frozen=True, eq=False)
class StoredRecording:
    """A recording in a file and the result of its screening; four bytes for each row are in memory.

    Attributes
    ----------
    table : LargeTable
    number : int
        Of the recording in a fit.
    conditions : tuple of ndarray of int, shape (n,)
        By part, the operating condition of each row; -1 for an excluded row.
    weights : tuple of ndarray
        By part, the weight of a row of each condition.
    unfitted : tuple of str
        Channels that are not fitted.
    counts : dict of str to int
        Excluded rows by reason.
    limits : dict of str to (float, float)
        Smallest and largest value of each input in the included rows, in adapted SAE.
    drawn : pandas.DataFrame
        Random ones of the included rows, with the columns of `parts`.
    """

    table: LargeTable
    number: int
    conditions: tuple[npt.NDArray[np.int32], ...]
    weights: tuple[FloatArray, ...]
    unfitted: tuple[str, ...]
    counts: dict[str, int]
    limits: dict[str, tuple[float, float]]
    drawn: pd.DataFrame

    @classmethod
    def screened(
        cls, table: LargeTable, number: int, unfitted: Sequence[str], *, screening: bool, rows: str, share: float
    ) -> StoredRecording:
        """Read the file once: exclude rows, find operating conditions, and draw random rows.

        Parameters
        ----------
        table : LargeTable
        number : int
        unfitted : sequence of str
        screening : bool
        rows : {"condition", "independent", "equal"}
            As for `tirefmu.fitting.data.fit_data.prepare`.
        share : float
            Share of the rows that is drawn.
        """
        random, drawn = np.random.default_rng(number), list[tuple[pd.DataFrame, npt.NDArray[np.int32]]]()
        groupings: list[Grouping] = []
        conditions: list[npt.NDArray[np.int32]] = []
        counts: dict[str, int] = {}
        limits: dict[str, tuple[float, float]] = {}
        for part in table.parts(PART):
            recording = Recording(part, table.signs, table.name)
            motions = motions_of(recording) if screening or rows != "equal" else None
            included = np.ones(len(part), dtype=np.bool_)
            if screening:
                found = exclude_rows(recording, warm_up=not groupings, motions=motions)
                included = found.included
                for reason, count in found.counts.items():
                    counts[reason] = counts.get(reason, 0) + count
            grouping = Grouping(np.zeros(len(part), dtype=np.intp), ((),))
            if rows != "equal":
                grouping = group_by_condition(recording, motions=motions)
            conditions.append(np.where(included, grouping.labels, -1).astype(np.int32))
            groupings.append(replace(grouping, labels=np.zeros(0, dtype=np.intp)))
            converted = recording.with_signs("adapted-sae").table
            _widen(limits, converted[included])
            chosen = np.flatnonzero(included & (random.random(len(part)) < share))
            drawn.append((converted.iloc[chosen].assign(segment=len(drawn)), conditions[-1][chosen]))
        numbers = [
            np.bincount(own[own >= 0], minlength=len(grouping.conditions))
            for own, grouping in zip(conditions, groupings, strict=True)
        ]
        weights = weights_of_parts(groupings, numbers)
        rows_drawn = pd.concat(
            [part.assign(weight=weight[own]) for (part, own), weight in zip(drawn, weights, strict=True)]
        ).assign(recording=number, included=True, **dict.fromkeys(unfitted, np.nan))
        return cls(table, number, tuple(conditions), tuple(weights), tuple(unfitted), counts, limits, rows_drawn)

    def parts(self) -> Iterator[pd.DataFrame]:
        """Yield the rows in their order, with the columns of `tirefmu.fitting.data.fit_data.FitData.table`."""
        segments = 0
        for part, condition, weight in zip(self.table.parts(PART), self.conditions, self.weights, strict=True):
            recording = Recording(part, self.table.signs, self.table.name)
            segment = recording.segment_numbers() + segments
            segments = int(segment[-1]) + 1
            yield recording.with_signs("adapted-sae").table.assign(
                recording=self.number, segment=segment, included=condition >= 0, weight=weight[condition],
                **dict.fromkeys(self.unfitted, np.nan),
            )  # fmt: skip


def _widen(limits: dict[str, tuple[float, float]], table: pd.DataFrame) -> None:
    """Extend the range of each input to the values of a table."""
    for name in INPUTS:
        if name in table and len(table):
            least, most = limits.get(name, (np.inf, -np.inf))
            limits[name] = min(least, float(table[name].min())), max(most, float(table[name].max()))
