"""The diagnosis as one HTML page: verdict, next measurement, curves, residuals, effects, fit error, equations."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from markupsafe import Markup

from ...boundary.errors import DataError, path_from
from ...drawing.page import page_text, write_page
from ...measurements import Recording, TableLike, recording_from
from ...measurements.provenance import provenance
from ...tires.tire import Tire
from ..explanations.answer import percent
from ..verdict.result import Diagnosis
from .effect_figures import form_figure, gain_figure, memory_figure
from .residual_figure import residual_location_figure

#: The parts of a recording in the words of the page.
ROWS = {"train": "fitted rows", "cv": "cross-validation", "holdout": "hold-out set"}


@dataclass(frozen=True)
class ChangedLine:
    """An equation of the model before and after an effect was added; `mathml` has the latter for a page."""

    number: str
    description: str
    before: str
    after: str
    mathml: str


def write_report(
    diagnosis: Diagnosis,
    recording: TableLike,
    path: str | Path,
    simulated: Mapping[str, Any] | None = None,
    *,
    command: str = "",
) -> Path:
    """Write the page of a diagnosis.

    Parameters
    ----------
    diagnosis : Diagnosis
    recording : path, DataFrame or Recording
        The diagnosed recording.
    path : str or Path
    simulated : mapping, optional
        Result of `export_and_simulate`.
    command : str
        The command line, for the provenance.

    Returns
    -------
    Path

    Raises
    ------
    DataError
        If the file cannot be written.
    """
    path = path_from(path)
    page = report_page(diagnosis, recording_from(recording, parameter="recording"), simulated, command)
    try:
        write_page(page, path)
    except OSError as error:
        raise DataError(f"{path}: cannot be written ({error.strerror or error})") from error
    return path


def report_page(
    diagnosis: Diagnosis, recording: Recording, simulated: Mapping[str, Any] | None = None, command: str = ""
) -> str:
    """Return the HTML text of the page, figures included."""
    return page_text(
        "tirefmu.diagnosis.reporting",
        {
            "number": lambda value: "-" if value is None or value != value else f"{value:.4g}",
            "percent": percent,
            "typeset": Markup,  # MathML of the program, with escaped texts
            "rows": ROWS.__getitem__,
            "rating": {"green": "good", "amber": "limited", "red": "bad"}.__getitem__,
        },
        diagnosis=diagnosis,
        maps=[residual_location_figure(diagnosis, channel) for channel in diagnosis.time_course],
        gain=gain_figure(diagnosis),
        memory=[memory_figure(diagnosis, name) for name in _with_memory(diagnosis)],
        form=[form_figure(diagnosis)] if diagnosis.form.delivered else [],
        changes=changed_lines(diagnosis.base_tire, diagnosis.tire),
        recording=recording,
        simulated=simulated or {},
        origin=provenance([recording], command),
    )


def changed_lines(before: Tire, after: Tire) -> tuple[ChangedLine, ...]:
    """Return the equations with effects that only the second tire has.

    >>> small = {"FNOMIN": 4000.0, "UNLOADED_RADIUS": 0.3}
    >>> plain = Tire("mf61", small, effects=["load_friction"])
    >>> richer = Tire("mf61", small, effects=["load_friction", "camber_friction"])
    >>> [line.after for line in changed_lines(plain, richer)][0]
    'mu_x = LMUX_star*(PDX1 + PDX2*dfz)*(-PDX3*gamma_in**2 + 1)'
    """
    from ...symbolic.printers.pages.mathml import equation_mathml  # loads SymPy

    gained = after.has - before.has
    old = after.symbolic_model.as_written(before.has & after.symbolic_model.effects.keys())
    new = after.symbolic_model.as_written(after.has)
    effects = {line.name: line.effects for line in after.symbolic_model.structure.lines}
    changed = []
    for line in after.symbolic_model.equations:
        name = line.symbol.name
        if gained.intersection(effects[name]) and old[name] != new[name] and not line.variant:
            written = line.acts_for or name
            first, second = (f"{written} = {lines[name]}" for lines in (old, new))
            changed.append(
                ChangedLine(line.number, line.description, first, second, equation_mathml(written, new[name]))
            )
    return tuple(changed)


def _with_memory(diagnosis: Diagnosis) -> list[str]:
    """Return the channels that the effects with states of the improved tire change most; none without such effects."""
    stateful = {effect.name for effect in diagnosis.tire.added if effect.states}
    channels = [finding.channels[0] for finding in diagnosis.found if finding.effect in stateful and finding.channels]
    if not diagnosis.tire.states or "t" not in diagnosis.rows or not channels:
        return []
    return list(dict.fromkeys(channels))
