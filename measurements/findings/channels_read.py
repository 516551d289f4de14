"""Slip columns that are missing, columns that are not read, rows that lack an input."""

from __future__ import annotations

from collections.abc import Iterator

from ..column_names import unread_columns
from ..recording import Recording
from .finding import Finding

#: The outputs that a slip causes.
_CAUSED = {"alpha": ("Fy", "Mz"), "kappa": ("Fx",)}
#: Names of columns in one line; more are counted.
MOST_NAMES = 8


def missing_slips(recording: Recording) -> Iterator[Finding]:
    """Yield a finding for each slip without a column, if an output was measured that it causes.

    Parameters
    ----------
    recording : Recording

    Yields
    ------
    Finding

    Examples
    --------
    >>> import pandas as pd
    >>> sweep = pd.DataFrame({"alpha": [-0.1, 0.1], "Fy": [900.0, -900.0]})
    >>> list(missing_slips(Recording(sweep, "iso", "a.csv")))
    []
    """
    table = recording.table
    for slip, outputs in _CAUSED.items():
        measured = [name for name in outputs if name in table and table[name].notna().any()]
        if slip not in table and measured:
            meaning = "slip angle" if slip == "alpha" else "longitudinal slip"
            yield Finding(
                "missing slip",
                f"{recording.source}: NO COLUMN {slip} ({meaning}): {' and '.join(measured)} cannot be fitted, "
                f"and every row counts as {slip} = 0",
                serious=True,
            )


def unread_channels(recording: Recording) -> Iterator[Finding]:
    """Yield a finding if a table has columns that are no channels.

    Parameters
    ----------
    recording : Recording

    Yields
    ------
    Finding

    Examples
    --------
    >>> import pandas as pd
    >>> print(*unread_channels(Recording(pd.DataFrame({"Fz": [900.0], "lap": 1, "RL": 0.2}), "iso", "a.csv")))
    a.csv: columns that are no channels are not fitted: lap, RL
    """
    names = unread_columns(recording.table.columns)
    if names:
        more = f" and {len(names) - MOST_NAMES} more" if len(names) > MOST_NAMES else ""
        yield Finding(
            "unread columns",
            f"{recording.source}: columns that are no channels are not fitted: {', '.join(names[:MOST_NAMES])}{more}",
        )


def incomplete_rows(recording: Recording) -> Iterator[Finding]:
    """Yield a finding if rows were excluded because an input is NaN.

    Parameters
    ----------
    recording : Recording

    Yields
    ------
    Finding
    """
    if text := recording.about.get("incomplete"):
        yield Finding("incomplete rows", f"{recording.source}: {text}: excluded, and rows are numbered without them")
