"""The page of the demo: what was measured, fitted, exported, missing and found, each with a picture and its files."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from urllib.parse import quote

import numpy as np

from tirefmu.symbolic.errors import TirefmuError
from tirefmu.tires.drawing.own_matplotlib import Figure, own_settings
from tirefmu.tires.drawing.page import page_text, write_page
from tirefmu.tires.drawing.shown_figure import shown_image
from tirefmu.tires.drawing.style import LETTER, drawn_unit, png, write_whole

#: Rows of `Diagnosis.gap` and the bars that show them.
BARS = (("before", "baseline tire", "C3"), ("after", "improved tire", "C0"), ("floor", "noise floor", "0.6"))


@dataclass(frozen=True)
class Chapter:
    """A step of the demo.

    Attributes
    ----------
    title : str
    texts : tuple of str
    figures : tuple of Path
        PNG files; the page contains them.
    files : tuple of Path
        In or below the folder of the page, which links to them.
    """

    title: str
    texts: tuple[str, ...]
    figures: tuple[Path, ...] = ()
    files: tuple[Path, ...] = ()


def write_demo_page(chapters: Sequence[Chapter], folder: Path, ok: bool, seconds: float) -> Path:
    """Write the page ``index.html``.

    Parameters
    ----------
    chapters : sequence of Chapter
    folder : Path
    ok : bool
        Whether every check passed.
    seconds : float
        Time of the steps.

    Returns
    -------
    Path

    Raises
    ------
    TirefmuError
        If the file cannot be written.
    """
    path = folder / "index.html"
    filters = {
        "image": shown_image,
        "address": lambda file: "./" + quote(file.relative_to(folder).as_posix()),
    }
    text = page_text("tirefmu", filters, template="demo.html", chapters=chapters, ok=ok, seconds=seconds)
    try:
        write_page(text, path)
    except OSError as error:
        raise TirefmuError(f"{path}: cannot be written ({error.strerror or error})") from error
    return path


@own_settings()
def draw_gap(gap: Mapping[str, Mapping[str, float]], path: Path) -> Path:
    """Draw the error of each channel on the hold-out set before and after the diagnosis, with the noise floor.

    Parameters
    ----------
    gap : mapping of str to mapping of str to float
        ``before``, ``after`` and ``floor`` by channel, as in `Diagnosis.gap`.
    path : Path
        PNG file.

    Returns
    -------
    Path
    """
    figure = Figure(figsize=(3.0 * len(gap) + 1.0, 3.2), layout="constrained")
    figure.suptitle("Error on the hold-out set", fontweight="bold")
    for ax, (channel, errors) in zip(np.ravel(figure.subplots(1, len(gap), squeeze=False)), gap.items(), strict=True):
        for place, (name, _, color) in enumerate(BARS):
            ax.bar(place, errors[name], color=color)
            ax.text(place, errors[name], f"{errors[name]:.3g}", ha="center", va="bottom", fontsize=9)
            ax.margins(y=0.15)
        ax.set_xticks(range(len(BARS)), [label.replace(" ", "\n") for _, label, _ in BARS], fontsize=8)
        ax.set_ylabel(f"RMSE of {LETTER[channel]} ({drawn_unit(channel)})")
    return write_whole(path, png(figure))
