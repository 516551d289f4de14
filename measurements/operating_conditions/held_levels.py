"""Levels of held inputs: those that a test program set to a few values."""

from __future__ import annotations

import pandas as pd

from .levels import levels

#: Largest number of levels of a held input; with more levels it was swept in steps.
MOST_LEVELS = 12


def held_levels(column: pd.Series) -> list[float]:
    """Return the levels of a held channel; empty for a swept one.

    Parameters
    ----------
    column : pandas.Series
        Its name gives the tolerance.

    Returns
    -------
    list of float
    """
    found = levels(column)
    return found if len(found) <= MOST_LEVELS else []
