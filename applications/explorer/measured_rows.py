"""Rows of recordings for the page: by operating condition, compact, with an upper limit."""

from __future__ import annotations

import base64
from collections.abc import Collection, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import pandas as pd

from ...boundary.escaping import excerpt
from ...measurements import CHANNELS, INPUTS, OUTPUTS, Recording, exclude_rows, group_by_condition
from .tire_data import shown, zero_of

#: Upper limit of the rows on a page; of more, a random selection of each condition.
MAX_ROWS = 20_000
#: Conditions with fewer rows are not listed.
MIN_ROWS = 5


@dataclass(frozen=True)
class MeasuredRows:
    """Rows of a recording at one operating condition.

    - `texts`: the recording and what is swept as "sweep", and each level with its unit.
    - `slip`: the swept slip; empty for none or both.
    - `levels`: of the held inputs, in SI units.
    - `table`: in ISO-W.
    """

    title: str
    texts: dict[str, str]
    slip: str
    levels: dict[str, float]
    table: pd.DataFrame


def measured_rows(recordings: Sequence[Recording], inputs: Collection[str]) -> list[MeasuredRows]:
    """Return the rows that a fit would use, by operating condition.

    `inputs`: those that the tire reads. The result is in the order of the recordings; those with the most rows first.
    Raises `DataError` if a recording has no measured output, or an input is not finite.
    """
    conditions = []
    for recording in recordings:
        recording = recording.with_signs("iso")
        outputs = recording.measured()
        columns = [name for name in INPUTS if name in recording.table and name in inputs] + list(outputs)
        included = exclude_rows(recording).included
        grouping = group_by_condition(recording)
        order = np.argsort(-grouping.counts, kind="stable")
        for label in order:
            rows = recording.table.loc[included & (grouping.labels == label), columns]
            if len(rows) >= MIN_ROWS:
                held = dict(grouping.conditions[label])
                conditions.append(_condition(recording.source, held, grouping.moving[label], rows))
    return conditions


def _condition(source: str, held: dict[str, float], moving: tuple[str, ...], rows: pd.DataFrame) -> MeasuredRows:
    slips = [name for name in moving if name in ("kappa", "alpha")]
    sweep = f"{excerpt(source, 40)}: {' and '.join(slips)} swept" if slips else f"{excerpt(source, 40)}: points"
    texts = {name: _level(name, level) for name, level in held.items()}
    acting = [f"{name} {texts[name]}" for name, level in held.items() if abs(level) > (CHANNELS[name].tolerance or 0.0)]
    title = ", ".join([sweep, *acting, f"{len(rows)} rows"])
    return MeasuredRows(title, {"sweep": sweep, **texts}, slips[0] if len(slips) == 1 else "", held, rows)


def _level(name: str, level: float) -> str:
    """Return a level with its unit; one within its tolerance of 0 is 0."""
    unit, scale = shown(CHANNELS[name].unit)
    value = (level - zero_of(CHANNELS[name].unit)) * scale if abs(level) > (CHANNELS[name].tolerance or 0.0) else 0.0
    return f"{float(f'{value:.3g}'):g} {unit}".strip()


def rows_data(conditions: Sequence[MeasuredRows], most: int = MAX_ROWS) -> dict[str, Any]:
    """Return conditions as JSON values; columns are base64 texts of little-endian 32-bit floats.

    `most`: upper limit of the rows. Returns: ``total``: number of all rows; ``conditions``: title, texts, slip,
    levels, number of rows and columns of each.
    """
    total = sum(len(condition.table) for condition in conditions)
    return {"total": total, "conditions": [_encoded(condition) for condition in sampled(conditions, most)]}


def sampled(conditions: Sequence[MeasuredRows], most: int) -> list[MeasuredRows]:
    """Return conditions with at most a number of rows: of more, a random selection of each, at least one row."""
    share = most / max(sum(len(condition.table) for condition in conditions), 1)
    if share >= 1.0:
        return list(conditions)
    # Every n-th row would alias with the sweeps.
    numbers = [max(1, int(share * len(condition.table))) for condition in conditions]
    return [
        replace(condition, table=condition.table.sample(number, random_state=0))
        for condition, number in zip(conditions, numbers, strict=True)
    ]


def _encoded(condition: MeasuredRows) -> dict[str, Any]:
    rows = condition.table
    return {
        "title": condition.title,
        "texts": condition.texts,
        "slip": condition.slip,
        "levels": condition.levels,
        "rows": len(rows),
        "columns": {
            name: base64.b64encode(rows[name].to_numpy(dtype="<f4").tobytes()).decode("ascii") for name in rows
        },
        "outputs": [name for name in OUTPUTS if name in rows],
    }
