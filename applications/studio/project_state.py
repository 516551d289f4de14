"""The state of the window: a project file that is changed line by line, and the earlier texts of it."""

from __future__ import annotations

import os
from collections.abc import Callable, Mapping, Sequence
from hashlib import sha256
from pathlib import Path
from typing import Any

import tomlkit
from tomlkit import TOMLDocument

from ...boundary.bounded_file import toml_content, toml_file, write_whole
from ...boundary.errors import TirefmuError
from ...boundary.escaping import quoted
from ...measurements.interpretation import Interpretation
from ...measurements.row_selection.expression import parse_selection
from ..project.project_file import SECTIONS, Project, checked_project

#: Folder of the window in that of the project: earlier project files, and the fits that were kept.
FOLDER, HISTORY = "studio", "history"
#: Upper limit of the earlier texts; the oldest are removed.
MAX_HISTORY = 500
#: Keys that the window does not change: results stay in the folder of the project.
FIXED = (("output", "folder"), ("data", "tables"), ("diagnose", "tables"))
#: Keys with expressions that select rows.
EXPRESSIONS = (("data", "exclude"), ("fit", "hold_out"))


class Stale(TirefmuError):
    """A change was made to an earlier state."""


class ProjectState:
    """The project file of a window. Every change is in the file when it is confirmed.

    `path`: of the project file, which may have no tables yet. Steps name their files as seen from the current folder:
    `tirefmu run` there finds the results of the window up to date. Raises `TirefmuError` if the file is invalid.
    """

    def __init__(self, path: Path) -> None:
        self.path, self.folder = path, path.parent
        self.history = self.folder / FOLDER / HISTORY
        self.history.mkdir(parents=True, exist_ok=True)
        self.project()

    def text(self) -> str:
        """Return the text of the file."""
        try:
            return self.path.read_text(encoding="utf-8")
        except (OSError, UnicodeDecodeError) as error:
            raise TirefmuError(f"{self.path}: cannot be read ({error})") from error

    def version(self) -> str:
        """Return a digest of the text: a change states the version that it was made to."""
        return sha256(self.text().encode()).hexdigest()[:16]

    def project(self) -> Project:
        """Return the project; raises `TirefmuError` for an invalid file."""
        return self._checked(self.text())

    def change(self, version: str, edit: Callable[[TOMLDocument], None]) -> None:
        """Apply an edit to the file. Comments and the order of lines remain.

        Raises `Stale` if the file has another version. Raises `TirefmuError` if the result is no valid project; then
        the file is as before.
        """
        before = self.text()
        if self.version() != version:
            raise Stale("the project was changed in another window or by another program: this is its present state")
        document = tomlkit.parse(before)
        edit(document)
        after = tomlkit.dumps(document)
        self._checked(after)
        if after == before:
            return
        earlier = self._earlier()
        number = int(earlier[-1].stem) + 1 if earlier else 1
        write_whole(self.history / f"{number:06}.toml", before.encode())
        for oldest in earlier[: len(earlier) + 1 - MAX_HISTORY]:
            oldest.unlink(missing_ok=True)
        write_whole(self.path, after.encode())

    def set_value(self, version: str, section: str, key: str, value: Any) -> None:
        """Set a key, or remove it if the value is None. Raises as `set_values`."""
        self.set_values(version, section, {key: value})

    def set_values(self, version: str, section: str, values: Mapping[str, Any]) -> None:
        """Set keys of a section in one change; None removes a key.

        Raises as `change`, and `UnknownName` for an unknown key, channel or unit.
        """
        given = {key: value for key, value in values.items() if value is not None}
        checked_project(self.path, {section: given}, empty=True)  # raises for an unknown name or a wrong kind
        for key, value in given.items():
            self._check(section, key, value)

        def edit(document: TOMLDocument) -> None:
            for key, value in values.items():
                _set(document, section, key, value)

        self.change(version, edit)

    def _check(self, section: str, key: str, value: Any) -> None:
        """Raise for a value of the right kind that the window does not set."""
        if (section, key) in FIXED:
            raise TirefmuError(f"[{section}] {key} is changed in the project file only")
        if (section, key) in EXPRESSIONS:
            for expression in value:
                parse_selection(expression)
        kind = SECTIONS[section][key].kind
        if kind == "name or file":
            self.check_inside(value)
        if kind == "texts":
            Interpretation(**{key: value})  # raises for an unknown channel or unit
            if wrong := [text for text in value.values() if not text.strip("- ") or "," in text]:
                raise TirefmuError(f"[{section}] {key}: {quoted(wrong[0])} is empty or has a comma")

    def set_tables(self, version: str, tables: Sequence[str]) -> None:
        """Set the tables: those of the project in another order, fewer, or files in its folder."""
        present = self.project().get("data", "tables", ())
        for table in tables:
            if table not in present:
                self.check_inside(table)
        self.change(version, lambda document: _set(document, "data", "tables", list(tables)))

    def restore_section(self, version: str, section: str, path: Path) -> None:
        """Take a section from another project file. Raises as `change`, also if that file is invalid."""
        values = checked_project(path, toml_file(path, TirefmuError), empty=True).sections.get(section, {})

        def edit(document: TOMLDocument) -> None:
            for key in {*document.get(section, {}), *values}:
                _set(document, section, key, values.get(key))

        self.change(version, edit)

    def add_named(self, tables: Sequence[str]) -> None:
        """Add tables that the user has named, wherever they are."""
        present = self.project().get("data", "tables", [])
        added = [table for table in dict.fromkeys(tables) if table not in present]
        if added:
            self.change(self.version(), lambda document: _set(document, "data", "tables", [*present, *added]))

    def undo(self, version: str) -> None:
        """Restore the text before the latest change. Raises `Stale`, or `TirefmuError` if there is none."""
        if self.version() != version:
            raise Stale("the project was changed meanwhile: this is its present state")
        present = self.text()
        for latest in reversed(self._earlier()):
            text = latest.read_text(encoding="utf-8")
            if text != present:  # equal if the program ended before it wrote the change
                self._checked(text)
                write_whole(self.path, text.encode())
                latest.unlink()
                return
            latest.unlink()
        raise TirefmuError("there is no earlier change")

    def undoable(self) -> int:
        """Return the number of changes that can be undone."""
        return len(self._earlier())

    def check_inside(self, name: str) -> None:
        """Raise if a text is the path of an existing file outside the folder of the project."""
        try:
            path = Path(os.path.realpath(self.folder / name))
            outside = path.exists() and not path.is_relative_to(os.path.realpath(self.folder))
        except (OSError, ValueError):
            return  # no path
        if outside:
            raise TirefmuError(f"{quoted(name)} is outside the folder of the project")

    def _earlier(self) -> list[Path]:
        return sorted(path for path in self.history.glob("*.toml") if path.stem.isdecimal())

    def _checked(self, text: str) -> Project:
        return checked_project(self.path, toml_content(text, str(self.path), TirefmuError), empty=True)


def _set(document: TOMLDocument, section: str, key: str, value: Any) -> None:
    if section not in document:
        document[section] = tomlkit.table()
    table: Any = document[section]
    if value is None:
        table.pop(key, None)
    elif isinstance(value, dict):
        inline = tomlkit.inline_table()
        inline.update(value)
        table[key] = inline
    elif isinstance(value, list):
        array = tomlkit.array()
        array.extend(value)
        table[key] = array.multiline(len(value) > 1)
    else:
        table[key] = value
