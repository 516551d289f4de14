"""Rows and files that occur twice."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import combinations

import numpy as np
import pandas as pd

from ..channels import CHANNELS, OUTPUTS
from ..recording import Recording
from ..thresholds import MOST_REPEATED_ROWS, SERIOUS_REPEATED_ROWS, SHORTEST_REPETITION
from .finding import Finding


def repeated_rows(recording: Recording) -> Iterator[Finding]:
    """Yield a finding if a stretch of rows repeats an earlier one in every channel but time.

    Single rows, and a sweep back that repeats the sweep there, may be equal without noise.

    Parameters
    ----------
    recording : Recording

    Yields
    ------
    Finding

    Examples
    --------
    >>> alpha = np.tile(np.linspace(-0.1, 0.1, 50), 2)
    >>> rows = pd.DataFrame({"alpha": alpha, "Fz": 900.0, "Fy": -9e3 * alpha})
    >>> print(*repeated_rows(Recording(rows, "iso", "a.csv")))
    a.csv: 50 of 100 rows repeat earlier rows in every channel but t, the first at row 51
    """
    earlier, _ = pd.factorize(_keys(recording))  # the first row with the same numbers, as a count of different rows
    repeated = _keys(recording).duplicated().to_numpy()
    follows = np.diff(earlier, prepend=-1) == 1
    edges = np.flatnonzero(np.diff(np.concatenate([[False], repeated & follows, [False]])))
    stretches = [(start, stop) for start, stop in edges.reshape(-1, 2) if stop - start >= SHORTEST_REPETITION - 1]
    # The first row of a stretch follows on no row before it.
    stretches = [(start - (start > 0 and repeated[start - 1]), stop) for start, stop in stretches]
    rows = sum(stop - start for start, stop in stretches)
    if rows > MOST_REPEATED_ROWS * len(recording):
        yield Finding(
            "repeated rows",
            f"{recording.source}: {rows} of {len(recording)} rows repeat earlier rows in every channel but t, the "
            f"first at row {stretches[0][0] + 1}",
            serious=rows > SERIOUS_REPEATED_ROWS * len(recording),
        )


def repeated_files(recordings: Sequence[Recording]) -> Iterator[Finding]:
    """Yield a finding for each pair of recordings with common rows: a file that was given twice.

    Parameters
    ----------
    recordings : sequence of Recording

    Yields
    ------
    Finding
    """
    keys = [set(_keys(recording)) for recording in recordings]
    for (one, first), (other, second) in combinations(zip(recordings, keys, strict=True), 2):
        common = len(first & second)
        if common > MOST_REPEATED_ROWS * min(len(first), len(second)):
            same = "is given twice" if first == second else f"shares {common} rows with {other.source}"
            yield Finding(
                "repeated rows",
                f"{one.source} {same}: these rows have twice the weight",
                serious=common > SERIOUS_REPEATED_ROWS * min(len(first), len(second)),
            )


def _keys(recording: Recording) -> pd.Series:
    """Return a hash of each row over all channels but the clock; empty without a measured output.

    Signs are converted, so that a file in two conventions is recognized.
    """
    table = recording.with_signs("iso").table
    names = [name for name in CHANNELS if name in table and name != "t"]
    if not any(name in OUTPUTS and table[name].notna().any() for name in names):
        return pd.Series([], dtype=np.uint64)
    return pd.util.hash_pandas_object(table[names] + 0.0, index=False)  # + 0.0: no -0
