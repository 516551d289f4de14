"""Fits that were made in the window: tire, result, project file and a note of each, in folders by number."""

from __future__ import annotations

import json
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from ...boundary.bounded_file import read_bounded, write_whole
from ...boundary.errors import TirefmuError
from ...boundary.escaping import excerpt

#: Files of a fit in its folder.
TIRE, RESULT, PROJECT, NOTE = "tire.tir", "fit.json", "tirefmu.toml", "note.txt"
LARGEST = 50_000_000
LONGEST_NOTE = 2000


@dataclass(frozen=True)
class Fits:
    """The fits in a folder.

    - `folder`: it has a folder for each fit, named by its number.
    """

    folder: Path

    def numbers(self) -> list[int]:
        """Return the numbers of the complete fits in their order."""
        folders = (path.parent for path in self.folder.glob(f"*/{RESULT}"))
        return sorted(int(path.name) for path in folders if path.name.isdecimal())

    def of(self, number: int) -> Path:
        """Return the folder of a fit. Raises `TirefmuError` if it does not exist."""
        if number not in self.numbers():
            raise TirefmuError(f"there is no fit {number}")
        return self.folder / f"{number:04}"

    def keep(self, results: Path, project_text: str) -> int | None:
        """Keep the fit in a folder of results, if it is not the latest one; return its number."""
        try:
            tire, result = ((results / name).read_bytes() for name in (TIRE, RESULT))
        except OSError:
            return None
        numbers = self.numbers()
        if numbers and (self.of(numbers[-1]) / RESULT).read_bytes() == result:
            return None
        number = max(numbers, default=0) + 1
        folder = self.folder / f"{number:04}"
        folder.mkdir(parents=True, exist_ok=True)
        # The result is last: a fit without it is incomplete and not listed.
        for name, content in ((TIRE, tire), (PROJECT, project_text.encode()), (RESULT, result)):
            write_whole(folder / name, content)
        return number

    def set_note(self, number: int, text: str) -> None:
        """Write the note of a fit."""
        if len(text) > LONGEST_NOTE:
            raise TirefmuError(f"a note has at most {LONGEST_NOTE} characters")
        write_whole(self.of(number) / NOTE, text.encode("utf-8", "replace"))

    def summaries(self) -> list[dict[str, Any]]:
        """Return what is shown of each fit, as JSON values."""
        return [self._summary(number) for number in self.numbers()]

    def _summary(self, number: int) -> dict[str, Any]:
        folder = self.folder / f"{number:04}"
        shown: dict[str, Any] = {"number": number, "note": ""}
        try:
            if (folder / NOTE).is_file():
                shown["note"] = (folder / NOTE).read_text(encoding="utf-8")[:LONGEST_NOTE]
            result = json.loads(read_bounded(folder / RESULT, LARGEST))
            channels = [
                {key: channel[key] for key in ("recording", "channel", "unit", "fitted_rmse", "fitted_r2")}
                for channel in result["channels"]
            ]
            return shown | {"model": result["model"], "verdict": result["verdict"], "channels": channels}
        except (OSError, ValueError, KeyError, TypeError) as error:
            return shown | {"model": "", "verdict": f"cannot be read: {excerpt(error)}", "channels": []}
