"""FSAE Tire Test Consortium (Calspan) files in ASCII format."""

from __future__ import annotations

import re
from pathlib import Path

from ...boundary.errors import DataError
from .columns.cells import has_decimal_commas, is_number, rows_of_cells, with_point
from .columns.content import DECIMAL_COMMAS, Column, Content
from .columns.layout import SAMPLED
from .encoding import encoding_of
from .ttc_channels import bench_content, has_bench_names

_TITLE_LINES = 20  # upper limit; the names of the channels are in the second line or shortly after
_AXES = re.compile(r"\bISO\W*(?P<answer>true|false)\b", re.IGNORECASE)
_UNIT_OF_TWO_WORDS = re.compile(r"\bdeg(?:rees?)? +(?=[CFK]\b)", re.IGNORECASE)


def read_ttc_dat(path: Path) -> Content:
    """Return the content of a ``.dat`` file of the FSAE TTC: a title, names, units, rows.

    Cells are separated by blanks or tabs, or as another program saved them: by commas or semicolons, in quotes.

    `signs` are those of the title (``ISO True``), otherwise sae; ``about["tireid"]`` is the title. Raises `DataError`
    if no line has the names of the channels, or rows differ in length.
    """
    lines = _lines(path)
    begun = enumerate(lines[:_TITLE_LINES])
    headers = ((n, mark) for n, line in begun for mark in (None, ";", ",") if has_bench_names(_cells(line, mark)))
    at, separator = next(headers, (None, None))
    if at is None:
        raise DataError(
            f"{path}: no line has the channel names (ET ... SA IA ... FZ): not a bench file of the FSAE TTC"
        )
    names = _cells(lines[at], separator)
    numbers = [number for number in range(at + 1, len(lines)) if lines[number].strip()]
    units = _units(lines[numbers[0]], names, separator, f"{path}: line {numbers[0] + 1}") if numbers else {}
    numbers = numbers[bool(units) :]
    rows = ((number + 1, _cells(lines[number], separator)) for number in numbers)
    commas = has_decimal_commas(_cells(lines[number], separator) for number in numbers[:SAMPLED])
    cells = rows_of_cells(rows, names, str(path), commas=commas)
    title = " ".join(" ".join(line.split()) for line in lines[:at])
    axes = _AXES.search(title)
    iso = axes is not None and axes["answer"].casefold() == "true"
    columns = tuple(Column(name, cells[:, i], units.get(name, "")) for i, name in enumerate(names))
    about = {"tireid": title, "testid": "", "credit": "", **(DECIMAL_COMMAS if commas else {})}
    content = Content(columns, lambda row: f"line {numbers[row] + 1}", signs="iso" if iso else "sae", about=about)
    return bench_content(content, path.name)


def _lines(path: Path) -> list[str]:
    text = path.read_text(encoding=encoding_of(path))
    if not text.strip():
        raise DataError(f"{path}: the file is empty")
    return text.splitlines()


def _cells(line: str, separator: str | None) -> list[str]:
    """Return the cells of a line without quotes, between separators; None: between blanks."""
    return [cell.strip() for cell in line.replace('"', "").split(separator)]


def _units(line: str, names: list[str], separator: str | None, where: str) -> dict[str, str]:
    """Return units by name from the line below the names; none if that line is a row of data."""
    # "deg F" is one unit, although blanks separate the cells as well.
    cells = _cells(_UNIT_OF_TWO_WORDS.sub("deg", line), separator)
    if not cells or all(is_number(with_point(cell)) for cell in cells):
        return {}
    if len(cells) != len(names):
        raise DataError(f"{where}: {len(cells)} units for {len(names)} channels")
    return dict(zip(names, cells, strict=True))
