"""Drift of a channel within an operating condition."""

from __future__ import annotations

import numpy as np
import pandas as pd
from numpy.typing import NDArray

#: Channels that a bench holds or that follow the test, and whose slow change is of interest.
DRIFTING = ("p", "V", "T")
#: Fraction of the rows at either end.
END_SHARE = 0.1


def drift(column: pd.Series, rows: NDArray[np.intp]) -> float:
    """Return the change of a channel from the first to the last tenth of some rows.

    `column`, shape (n,). `rows`, shape (m,): in the order of time. Returns: difference of the medians, in the unit of
    the column; NaN without a number at either end.

    >>> round(drift(pd.Series(np.linspace(50.0, 60.0, 101)), np.arange(101)), 1)
    9.1
    """
    values = column.to_numpy(dtype=np.float64)[rows]
    count = max(1, round(END_SHARE * len(values)))
    ends = values[:count], values[-count:]
    if any(not np.isfinite(end).any() for end in ends):
        return np.nan
    return float(np.nanmedian(ends[1]) - np.nanmedian(ends[0]))
