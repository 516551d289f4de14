"""All findings about the recordings of one fit."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import combinations

from ...recording import Recording
from ...thresholds import FEW_ROWS, MAX_REPEATED_ROWS, SERIOUS_REPEATED_ROWS
from ..columns.check import column_notes
from ..rows.coverage import coverage_notes, outputs_without_curve
from .clock_and_units import clock_and_units
from .finding import DataFinding
from .one_recording import findings_of, row_keys
from .stiffness_between_files import stiffness_between_files
from .two_tires import two_tires


def data_findings(recordings: Sequence[Recording]) -> list[DataFinding]:
    """Return the problems in recordings of one tire.

    Parameters
    ----------
    recordings : sequence of Recording
        In any signs.

    Returns
    -------
    list of DataFinding
        The serious ones first, each group in the order of the recordings.

    Examples
    --------
    >>> import pandas as pd
    >>> rows = pd.DataFrame({"Fz": [500.0, 900.0] * 40, "Fy": [1.0, 2.0] * 40})
    >>> print(*data_findings([Recording(rows, "iso", "a.csv")])[:1])
    a.csv: NO COLUMN alpha (slip angle): Fy cannot be fitted, and every row counts as alpha = 0
    """
    findings = [DataFinding("two tires", note, serious=True) for note in two_tires(recordings)]
    findings += _repeated_files(recordings)
    findings += stiffness_between_files(recordings)
    for recording in recordings:
        findings += [DataFinding("columns", note, serious=True) for note in column_notes(recording)]
        findings += [DataFinding("coverage", note) for note in coverage_notes(recording)]
        findings += findings_of(recording, alone=len(recordings) == 1)
        findings += clock_and_units(recording)
    findings += [*_few_rows(recordings), *_nothing_to_fit(recordings)]
    return sorted(findings, key=lambda finding: not finding.serious)


def _few_rows(recordings: Sequence[Recording]) -> Iterator[DataFinding]:
    """Yield a finding if all recordings together have fewer rows than a fit of one force needs."""
    rows = sum(map(len, recordings))
    if 0 < rows < FEW_ROWS:
        source = recordings[0].source if len(recordings) == 1 else f"{len(recordings)} tables"
        yield DataFinding("few rows", f"{source}: {rows} rows are fewer than a fit of one force needs", serious=True)


def _nothing_to_fit(recordings: Sequence[Recording]) -> Iterator[DataFinding]:
    """Yield a finding if no output of any recording is measured over a varying slip."""
    if recordings and all(set(r.measured()) <= set(outputs_without_curve(r)) for r in recordings):
        yield DataFinding("nothing to fit", "no output is measured over a varying slip: nothing to fit", serious=True)


def _repeated_files(recordings: Sequence[Recording]) -> Iterator[DataFinding]:
    """Yield a finding for each pair of recordings with common rows: a file that was given twice."""
    keys = [set(row_keys(recording)) for recording in recordings] if len(recordings) > 1 else []
    for (recording, first), (other, second) in combinations(zip(recordings, keys, strict=False), 2):
        common = len(first & second)
        if common > MAX_REPEATED_ROWS * min(len(first), len(second)):
            same = "is given twice" if first == second else f"shares {common} rows with {other.source}"
            yield DataFinding(
                "repeated rows",
                f"{recording.source} {same}: these rows have twice the weight",
                serious=common > SERIOUS_REPEATED_ROWS * min(len(first), len(second)),
            )
