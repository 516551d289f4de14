"""Report of a fit as one HTML file: status, goodness of fit, figures, coefficients, constraints, stages."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import replace
from functools import partial
from itertools import takewhile, zip_longest
from pathlib import Path

import numpy as np
import pandas as pd

from ...boundary.errors import FitError, path_from
from ...drawing.figure import Figure
from ...drawing.page import page_text, write_page
from ...measurements import DataFinding, TableLike, recordings_from
from ...measurements.provenance import provenance
from ...numerics.ties import graded
from ..checks.residuals import condition_text
from ..results.fitted import Fitted
from ..results.intervals import listed_intervals
from ..results.verdict import verdict_of
from .figures import figures_of
from .load_table import load_rows, stiffness_by_load
from .report_text import (
    CONSTRAINT_SIGNS,
    SIGNIFICANT,
    bootstrap_summary,
    bootstrap_text,
    extrapolation_text,
    interval_text,
    ripple_texts,
    significant_differences,
    worst_text,
)

#: Magnitude from which a correlation of two coefficients is listed, and the largest number of listed pairs.
CORRELATED, MAX_PAIRS = 0.9, 20
#: The figures whose first panels begin the report, by title.
OVERVIEW = {
    "Forces at all measured loads": ("pure_Fy", "pure_Fx"),
    "Moments at all measured loads": ("pure_Mz", "pure_Mx"),
}


def write_report(
    result: Fitted,
    recordings: TableLike | Iterable[TableLike],
    path: str | Path,
    figures: Sequence[Figure] | None = None,
    *,
    findings: Sequence[DataFinding] = (),
    command: str = "",
) -> None:
    """Write the report of a fit.

    Parameters
    ----------
    result : FitResult
        The fit.
    recordings : path, DataFrame or Recording, or a sequence of them
        The fitted recordings, for the figures and the provenance.
    path : str or Path
        The HTML file to write.
    figures : sequence of Figure, optional
        `figures_of` them; made if absent.
    findings : sequence of DataFinding
        About the data, and about what the tire leaves in the residual.
    command : str
        The command line, for the provenance.

    Raises
    ------
    FitError
        If the file cannot be written.
    """
    path = path_from(path)
    given = recordings_from(recordings)
    shown = figures_of(result, given) if figures is None else figures
    try:
        write_page(report_page(result, shown, provenance(given, command), findings), path)
    except OSError as error:
        raise FitError(f"{path}: cannot be written ({error.strerror or error})") from error


def report_page(
    result: Fitted, figures: Sequence[Figure], origin: Sequence[tuple[str, str]] = (),
    findings: Sequence[DataFinding] = (),
) -> str:  # fmt: skip
    """Return the page's text.

    `origin`: the provenance.
    """
    filters: dict[str, Callable[..., object]] = {
        "number": lambda value: f"{value:.5g}",
        "known": interval_text,
        "condition": condition_text,
        "bootstrap": partial(bootstrap_text, result),
    }
    errors = [(c.recording, c.channel, worst_text(result, c.recording, c.channel)) for c in result.channels]
    largest = [error for error in errors if error[2]]
    return page_text(
        "tirefmu.fitting.reporting", filters, result=result, verdict=verdict_of(result), overview=overview(figures),
        figures=figures, loads=list(load_rows(result)), stiffnesses=list(stiffness_by_load(result.findings)),
        consequences={bound.name: bound.text() for bound in result.bounds},
        largest=largest, findings=findings,
        differences=significant_differences(result), significant=SIGNIFICANT,
        intervals=[interval for interval in listed_intervals(result) if set(interval["at"]) == {"Fz"}],
        bootstrap=bootstrap_summary(result.bootstrap) if result.bootstrap else "",
        ripples=ripple_texts(result.findings.ripples), extrapolation=extrapolation_text(result),
        sense=CONSTRAINT_SIGNS, correlations=correlated_pairs(result.correlation), correlated=CORRELATED, origin=origin,
    )  # fmt: skip


def overview(figures: Sequence[Figure]) -> list[Figure]:
    """Return the curves in pure slip at all measured loads, side by side: those of forces, and those of moments."""
    first = {figure.name: figure for figure in figures if figure.panels}
    overview_figures = []
    for title, names in OVERVIEW.items():
        shown = [first[name] for name in names if name in first]
        if shown:
            panels = tuple(
                replace(panel, series=tuple(series for series in panel.series if series.kind != "band"))
                for panel in (figure.panels[0] for figure in shown)
            )
            overview_figures.append(Figure("overview", title, (panels,), _joint_note(shown)))
    return overview_figures


def _joint_note(figures: Sequence[Figure]) -> str:
    """Return what the notes of figures ``pure_Fy``, ... have in common at their begin, then the rest by channel.

    >>> _joint_note([Figure("pure_Fy", "", (), "points: data; data: a.csv"), Figure("pure_Fx", "", (), "points: data")])
    'points: data; Fy: data: a.csv'
    """
    notes = [figure.note.split("; ") for figure in figures]
    common = list(takewhile(lambda parts: len(set(parts)) == 1, zip_longest(*notes)))
    rest = {figure.name.removeprefix("pure_"): note[len(common) :] for figure, note in zip(figures, notes, strict=True)}
    by_channel = [f"{channel}: {'; '.join(parts)}" for channel, parts in rest.items() if parts]
    return "; ".join([*(parts[0] for parts in common), *by_channel])


def correlated_pairs(correlation: pd.DataFrame) -> list[tuple[str, str, float]]:
    """Return the pairs of coefficients with the largest correlations, from `CORRELATED` in magnitude.

    `correlation`: as in `FitResult.correlation`; NaN for unknown ones. The result is in decreasing magnitude.

    >>> names = ["PKY1", "PKY2", "PDY1"]
    >>> correlated_pairs(pd.DataFrame([[1, 0.95, 0.2], [0.95, 1, -0.3], [0.2, -0.3, 1]], names, names))
    [('PKY1', 'PKY2', 0.95)]
    """
    names = list(correlation.index)
    values = correlation.to_numpy(dtype=float)
    pairs = [
        (names[i], names[j], float(values[i, j]))
        for i, j in zip(*np.triu_indices(len(names), 1), strict=True)
        if abs(values[i, j]) >= CORRELATED
    ]
    return sorted(pairs, key=lambda pair: -graded(abs(pair[2])))[:MAX_PAIRS]
