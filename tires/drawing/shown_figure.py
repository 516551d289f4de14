"""Figures as pages and files have them."""

from __future__ import annotations

import json
from base64 import b64encode
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

from tirefmu.symbolic.escaping import script_json

from .own_matplotlib import Figure
from .panels_data import panels_of
from .style import DPI, png, write_whole


@dataclass(frozen=True)
class ShownFigure:
    """A rendered figure.

    Attributes
    ----------
    name : str
    image : bytes
        PNG.
    inches : float
        Width of the figure: its texts have the same size in all figures of a page.
    panels : str
        JSON text of `panels_of` for a script element; empty if a page shows the image only.
    """

    name: str
    image: bytes
    inches: float
    panels: str = ""

    @property
    def base64(self) -> str:
        """The image for a page."""
        return b64encode(self.image).decode("ascii")


def shown_figures(figures: Mapping[str, Figure]) -> list[ShownFigure]:
    """Render figures, and read the data of those that are lines and points.

    Parameters
    ----------
    figures : mapping of str to matplotlib.figure.Figure
        By name.

    Returns
    -------
    list of ShownFigure
    """
    return [shown_figure(name, figure) for name, figure in figures.items()]


def shown_figure(name: str, figure: Figure) -> ShownFigure:
    """Render a figure, and read its data if it is lines and points.

    Parameters
    ----------
    name : str
    figure : matplotlib.figure.Figure

    Returns
    -------
    ShownFigure

    Examples
    --------
    >>> figure = Figure()
    >>> _ = figure.subplots().plot([0.0, 1.0])
    >>> shown_figure("line", figure).panels[:20]
    '[{"title":"","x":"",'
    """
    panels = panels_of(figure)
    text = script_json(json.dumps(panels, allow_nan=False, separators=(",", ":"))) if panels else ""
    return ShownFigure(name, png(figure), figure.get_figwidth(), text)


def shown_image(path: Path) -> ShownFigure:
    """Return the figure of a PNG file; a page shows the image only.

    Parameters
    ----------
    path : Path
        Written by `write_figures`, or with the same resolution.

    Returns
    -------
    ShownFigure
    """
    image = path.read_bytes()
    return ShownFigure(path.stem, image, int.from_bytes(image[16:20], "big") / DPI)


def write_figures(figures: Sequence[ShownFigure], folder: Path, prefix: str = "") -> list[Path]:
    """Write figures as PNG files; each is written completely or not at all.

    Parameters
    ----------
    figures : sequence of ShownFigure
    folder : Path
        Created if it does not exist.
    prefix : str
        Of the file names.

    Returns
    -------
    list of Path

    Raises
    ------
    OSError
        If a file cannot be written.
    """
    folder.mkdir(parents=True, exist_ok=True)
    return [write_whole(folder / f"{prefix}{each.name}.png", each.image) for each in figures]
