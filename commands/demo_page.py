"""The page of the demo: what was measured, fitted, exported, missing and found, each with a picture and its files."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from urllib.parse import quote

from ..boundary.errors import writing
from ..drawing.figure import Figure
from ..drawing.page import page_text, write_page


@dataclass(frozen=True)
class DemoStep:
    """A step of the demo.

    - `texts`: the first one is the result, with which the page begins.
    - `files`: in or below the folder of the page, which links to them.
    """

    title: str
    texts: tuple[str, ...]
    figures: tuple[Figure, ...] = ()
    files: tuple[Path, ...] = ()


def write_demo_page(chapters: Sequence[DemoStep], folder: Path, ok: bool, seconds: float) -> Path:
    """Write the page ``index.html``.

    `ok`: whether every check passed. `seconds`: time of the steps. Raises `TirefmuError` if the file cannot be written.
    """
    path = folder / "index.html"
    filters = {"address": lambda file: "./" + quote(file.relative_to(folder).as_posix())}
    text = page_text("tirefmu.commands", filters, template="demo.html", chapters=chapters, ok=ok, seconds=seconds)
    with writing(path):
        write_page(text, path)
    return path
