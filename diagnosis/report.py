"""The diagnosis as one HTML page: verdict, where, what, alternatives, how much, next measurement, the equation."""

from __future__ import annotations

import base64
import os
import tempfile
from collections.abc import Mapping
from dataclasses import dataclass
from importlib.resources import files
from pathlib import Path
from typing import Any

from jinja2 import Environment, StrictUndefined

from tirefmu.measurements import Recording
from tirefmu.symbolic.errors import DataError
from tirefmu.symbolic.notation import Switch
from tirefmu.tires.tire import Tire

from .verdict import Diagnosis
from .where_figure import draw_where


@dataclass(frozen=True)
class ChangedLine:
    """A line of the book before and after an effect was added."""

    number: str
    description: str
    before: str
    after: str


def write_report(
    diagnosis: Diagnosis, recording: Recording, path: str | Path, simulated: Mapping[str, Any] | None = None
) -> Path:
    """Write the page of a diagnosis.

    Parameters
    ----------
    diagnosis : Diagnosis
    recording : Recording
        What was diagnosed.
    path : str or Path
    simulated : mapping, optional
        What `export_and_simulate` returned.

    Returns
    -------
    Path

    Raises
    ------
    DataError
        If the file cannot be written.
    """
    path = Path(path)
    with tempfile.TemporaryDirectory() as folder:
        images = _maps(diagnosis, Path(folder))
    environment = Environment(autoescape=True, undefined=StrictUndefined, trim_blocks=True, lstrip_blocks=True)
    environment.filters["number"] = lambda value: "-" if value is None or value != value else f"{value:.4g}"
    template = environment.from_string((files("tirefmu.diagnosis") / "report.html").read_text(encoding="utf-8"))
    page = template.render(
        diagnosis=diagnosis,
        images=images,
        changes=changed_lines(diagnosis.base_tire, diagnosis.tire),
        recording=recording,
        simulated=simulated or {},
    )
    scratch = path.with_name(f".{path.name}.part")
    try:
        scratch.write_text(page, encoding="utf-8")
        os.replace(scratch, path)
    except OSError as error:
        scratch.unlink(missing_ok=True)
        raise DataError(f"{path}: cannot be written ({error.strerror or error})") from error
    return path


def changed_lines(before: Tire, after: Tire) -> tuple[ChangedLine, ...]:
    """Return the lines of the book in which effects stand that one tire has and the other lacks.

    Parameters
    ----------
    before, after : Tire

    Returns
    -------
    tuple of ChangedLine

    Examples
    --------
    >>> small = {"FNOMIN": 4000.0, "UNLOADED_RADIUS": 0.3}
    >>> plain = Tire("mf61", small, effects=["load_friction"])
    >>> richer = Tire("mf61", small, effects=["load_friction", "camber_friction"])
    >>> [line.after for line in changed_lines(plain, richer)][0]
    'mu_x = LMUX_star*(PDX1 + PDX2*dfz)*(-PDX3*gamma_in**2 + 1)'
    """
    more = after.has - before.has
    old = after.book.as_written(before.has & after.book.effects.keys())
    new = after.book.as_written(after.has)
    changed = []
    for line in after.book.equations:
        stands = {str(place.args[0]) for place in line.expression.atoms(Switch)}
        name = line.symbol.name
        if stands & more and old[name] != new[name] and not line.variant:
            told = [f"{line.acts_for or name} = {lines[name]}" for lines in (old, new)]
            changed.append(ChangedLine(line.number, line.description, *told))
    return tuple(changed)


def _maps(diagnosis: Diagnosis, folder: Path) -> list[tuple[str, str]]:
    """Draw where each channel is missed before and after, and return channels and images."""
    images = []
    for channel, course in diagnosis.time_course.items():
        before, after = (
            [one for one in maps if one["channel"] == channel] for maps in (diagnosis.where, diagnosis.where_after)
        )
        drawn = draw_where(before, after, course, folder / f"{channel}.png")
        images.append((channel, base64.b64encode(drawn.read_bytes()).decode("ascii")))
    return images
