"""A report as one HTML page that needs nothing else and runs nothing, whatever text stands in it."""

from __future__ import annotations

import base64
from collections.abc import Callable, Mapping
from importlib.resources import files
from pathlib import Path
from typing import Any

from jinja2 import Environment, StrictUndefined

from tirefmu.symbolic.escaping import visible
from tirefmu.tires.drawing.style import write_whole


def page_text(package: str, filters: Mapping[str, Callable[..., object]], **content: Any) -> str:
    """Return the text of a room's report.

    Every text is made visible (no control characters, no marks that turn the direction of writing) and escaped; the
    template's own policy lets a browser run nothing and load nothing but the images inside.

    Parameters
    ----------
    room : str
        Package with the template ``report.html``: "tirefmu.fitting.reporting", "tirefmu.diagnosis.reporting".
    filters : mapping of str to callable
        Of the template, by name.
    **content
        What the template shows.

    Returns
    -------
    str
    """
    environment = Environment(
        autoescape=True, undefined=StrictUndefined, trim_blocks=True, lstrip_blocks=True,
        finalize=lambda value: visible(str(value)),
    )  # fmt: skip
    environment.filters |= filters
    template = environment.from_string((files(package) / "report.html").read_text(encoding="utf-8"))
    return template.render(**content)


def inlined(images: list[Path]) -> list[tuple[str, str]]:
    """Return name and base64 text of each image."""
    return [(image.stem, base64.b64encode(image.read_bytes()).decode("ascii")) for image in images]


def write_page(page: str, path: Path) -> None:
    """Write a page, whole or not at all.

    Raises
    ------
    OSError
        If the file cannot be written.
    """
    write_whole(path, page.encode("utf-8"))
