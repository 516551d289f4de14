"""The answer to a drive as one HTML page."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from ...boundary.errors import TirefmuError, path_from
from ...drawing.page import page_text, write_page
from .figures import drive_figures
from .inputs.car_entries import ENTRIES
from .result import Drive

#: What is simulated, with its unit.
SIMULATED = {"yaw_rate": "yaw rate, rad/s", "ay": "lateral acceleration, m/s²", "vy": "lateral speed, m/s"}


def write_drive(answer: Drive, path: str | Path, *, command: str = "") -> None:
    """Write the page of an answer: verdict, factors, car, simulation, figures.

    `command`: the command line, for the provenance. Raises `TirefmuError` if the file cannot be written.
    """
    path = path_from(path)
    content: dict[str, Any] = answer.to_json()
    page = page_text(
        "tirefmu.applications.driving", {"short": _short}, answer=content, entries=ENTRIES, simulated=SIMULATED,
        figures=drive_figures(answer),
        origin=[("log", answer.log.source), ("car", answer.car.source), ("command", command or "tirefmu.drive")],
    )  # fmt: skip
    try:
        write_page(page, path)
    except OSError as error:
        raise TirefmuError(f"{path}: cannot be written ({error.strerror or error})") from None


def _short(number: float | None) -> str:
    return "-" if number is None else f"{number:.4g}"
