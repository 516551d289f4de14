"""All findings about the recordings of one fit."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from ..quality.coverage import coverage_notes
from ..quality.plausibility import convention_notes
from ..quality.tire_identity import identity_notes
from ..recording import Recording
from .channels_read import missing_slips, unread_channels
from .finding import Finding, headline_first


def data_findings(recordings: Sequence[Recording]) -> list[Finding]:
    """Return what recordings of one tire lack or contradict.

    Parameters
    ----------
    recordings : sequence of Recording

    Returns
    -------
    list of Finding
        The serious ones first, each group in the order of the recordings.

    Examples
    --------
    >>> import pandas as pd
    >>> rows = pd.DataFrame({"Fz": [500.0, 900.0] * 40, "Fy": [1.0, 2.0] * 40})
    >>> print(*data_findings([Recording(rows, "iso", "a.csv")])[:1])
    a.csv: NO COLUMN alpha (slip angle): Fy cannot be fitted, and every row counts as alpha = 0
    """
    found = [Finding("two tires", note, serious=True) for note in identity_notes(recordings)]
    for recording in recordings:
        found += _findings_of(recording)
    return headline_first(found)


def _findings_of(recording: Recording) -> Iterator[Finding]:
    yield from missing_slips(recording)
    for note in convention_notes(recording):
        yield Finding("sign convention", note, serious=True)
    for note in coverage_notes(recording):
        yield Finding("coverage", note)
    yield from unread_channels(recording)
