"""FSAE Tire Test Consortium (Calspan) files in ASCII format."""

from __future__ import annotations

import re
from pathlib import Path

from ...boundary.errors import DataError
from .columns.cells import is_number, rows_of_cells
from .columns.content import Column, Content
from .ttc_channels import bench_content, has_bench_names

_TITLE_LINES = 20  # upper limit; the names of the channels are in the second line or shortly after
_AXES = re.compile(r"\bISO\W*(?P<answer>true|false)\b", re.IGNORECASE)
_UNIT_OF_TWO_WORDS = re.compile(r"\bdeg(?:rees?)? +(?=[CFK]\b)", re.IGNORECASE)


def read_ttc_dat(path: Path) -> Content:
    """Return the content of a ``.dat`` file of the FSAE TTC: a title, names, units, rows separated by blanks or tabs.

    `signs` are those of the title (``ISO True``), otherwise sae; ``about["tireid"]`` is the title. Raises `DataError`
    if no line has the names of the channels, or rows differ in length.
    """
    lines = _lines(path)
    at = next((number for number, line in enumerate(lines[:_TITLE_LINES]) if has_bench_names(line.split())), None)
    if at is None:
        raise DataError(
            f"{path}: no line has the channel names (ET ... SA IA ... FZ): not a bench file of the FSAE TTC"
        )
    names = lines[at].split()
    numbers = [number for number in range(at + 1, len(lines)) if lines[number].strip()]
    units = _units(lines[numbers[0]], names, f"{path}: line {numbers[0] + 1}") if numbers else {}
    numbers = numbers[bool(units) :]
    cells = rows_of_cells(((number + 1, lines[number].split()) for number in numbers), names, str(path))
    title = " ".join(" ".join(line.split()) for line in lines[:at])
    axes = _AXES.search(title)
    iso = axes is not None and axes["answer"].casefold() == "true"
    columns = tuple(Column(name, cells[:, i], units.get(name, "")) for i, name in enumerate(names))
    about = {"tireid": title, "testid": "", "credit": ""}
    content = Content(columns, lambda row: f"line {numbers[row] + 1}", signs="iso" if iso else "sae", about=about)
    return bench_content(content, path.name)


def _lines(path: Path) -> list[str]:
    content = path.read_bytes()
    if b"\0" in content:
        raise DataError(f"{path}: not a text file")
    try:
        text = content.decode("utf-8-sig")
    except UnicodeDecodeError:
        text = content.decode("latin-1")  # the degree signs and umlauts of older titles
    if not text.strip():
        raise DataError(f"{path}: the file is empty")
    return text.splitlines()


def _units(line: str, names: list[str], where: str) -> dict[str, str]:
    """Return units by name from the line below the names; none if that line is a row of data."""
    # "deg F" is one unit, although blanks separate the cells as well.
    cells = _UNIT_OF_TWO_WORDS.sub("deg", line).split()
    if not cells or all(map(is_number, cells)):
        return {}
    if len(cells) != len(names):
        raise DataError(f"{where}: {len(cells)} units for {len(names)} channels")
    return dict(zip(names, cells, strict=True))
