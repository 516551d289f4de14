"""Rows without an input: excluded up to a share of the rows, and counted."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from ....boundary.errors import DataError
from ....symbolic.channels import INPUTS
from ...recording import Recording
from ...thresholds import MAX_INCOMPLETE


def without_incomplete_rows(recording: Recording) -> Recording:
    """Return a recording without the rows in which an input is NaN; the same one if every row is complete.

    ``about["incomplete"]`` has the numbers of rows. Raises `DataError` if more than `MAX_INCOMPLETE` of the rows are
    incomplete.
    """
    present = [name for name in INPUTS if name in recording.table]
    unknown = recording.table[present].isna()
    incomplete = unknown.any(axis=1).to_numpy(dtype=np.bool_)
    if not incomplete.any():
        return recording
    channels = ", ".join(f"{name} ({count})" for name, count in unknown.sum().items() if count)
    text = (
        f"{incomplete.sum()} of {len(recording)} rows lack an input: NaN in {channels}, "
        f"the first in row {np.flatnonzero(incomplete)[0] + 1}"
    )
    if incomplete.mean() > MAX_INCOMPLETE:
        raise DataError(f"{recording.source}: {text}: up to {100.0 * MAX_INCOMPLETE:g} % are excluded")
    table = recording.table[~incomplete].reset_index(drop=True)
    return replace(recording, table=table, about={**recording.about, "incomplete": text})
