"""All findings about the recordings of one fit."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from ..quality.convention import convention_notes
from ..quality.coverage import coverage_notes
from ..quality.tire_identity import identity_notes
from ..recording import Recording
from .channels_read import incomplete_rows, missing_slips, unread_channels
from .clock_and_units import clock_jumps, mixed_units, unlabelled_speed
from .equal_conditions import friction_differences, stiffness_differences
from .finding import Finding, headline_first
from .repetition import repeated_files, repeated_rows
from .run_order import confounded_with_order, warm_up


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
    found = found or list(friction_differences(recordings))
    found += repeated_files(recordings)
    found += stiffness_differences(recordings)
    for recording in recordings:
        found += _findings_of(recording, alone=len(recordings) == 1)
    return headline_first(found)


def _findings_of(recording: Recording, *, alone: bool) -> Iterator[Finding]:
    yield from missing_slips(recording)
    for note in convention_notes(recording):
        yield Finding("sign convention", note, serious=True)
    for note in coverage_notes(recording):
        yield Finding("coverage", note)
    yield from incomplete_rows(recording)
    yield from repeated_rows(recording)
    yield from warm_up(recording, alone=alone)
    yield from confounded_with_order(recording)
    yield from clock_jumps(recording)
    yield from mixed_units(recording)
    yield from unlabelled_speed(recording)
    yield from unread_channels(recording)
