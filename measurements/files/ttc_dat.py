"""FSAE Tire Test Consortium (Calspan) files in ASCII format."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from tirefmu.boundary.errors import DataError

from ..recording import Recording
from .ttc_channels import bench_recording, has_bench_names

_TITLE_LINES = 20  # upper limit; the names of the channels are in the second line or soon after
_AXES = re.compile(r"\bISO\W*(?P<answer>true|false)\b", re.IGNORECASE)
_UNIT_OF_TWO_WORDS = re.compile(r"\bdeg(?:rees?)? +(?=[CFK]\b)", re.IGNORECASE)


def read_ttc_dat(path: Path, signs: str) -> Recording:
    """Read a ``.dat`` file of the FSAE TTC: a title, names, units, and rows separated by blanks or tabs.

    `signs`: the convention of the file; Calspan writes sae. ``about["signs"]`` has that of the title (``ISO True``), if
    any. Returns: the available channels of ``t kappa alpha gamma Fz p V T Fx Fy Mz Mx My``. ``about`` has the title as
    ``tireid``. Raises `DataError` if no line has the names of the channels, rows differ in length, or a cell is not a
    number (with the line). Also if a channel is missing or cannot be used, as for ``.mat`` files.
    """
    source = str(path)
    lines = _lines(path)
    at = next((number for number, line in enumerate(lines[:_TITLE_LINES]) if has_bench_names(line.split())), None)
    if at is None:
        raise DataError(
            f"{source}: no line has the channel names (ET ... SA IA ... FZ): not a bench file of the FSAE TTC"
        )
    names = lines[at].split()
    numbers = [number for number in range(at + 1, len(lines)) if lines[number].strip()]
    units = _units(lines[numbers[0]], names, f"{source}: line {numbers[0] + 1}") if numbers else {}
    numbers = numbers[bool(units) :]
    table = _numbers(lines, numbers, names, source)
    title = " ".join(" ".join(line.split()) for line in lines[:at])
    about = {"tireid": title, "testid": "", "credit": ""}
    axes = _AXES.search(title)
    if axes is not None:
        about["signs"] = "iso" if axes["answer"].casefold() == "true" else "sae"
    vectors = dict(zip(names, table.T, strict=True))
    return bench_recording(path, vectors, units, signs, about, lambda row: f"line {numbers[row] + 1}")


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
    if not cells or all(_is_number(cell) for cell in cells):
        return {}
    if len(cells) != len(names):
        raise DataError(f"{where}: {len(cells)} units for {len(names)} channels")
    return dict(zip(names, cells, strict=True))


def _numbers(lines: list[str], numbers: list[int], names: list[str], source: str) -> NDArray[np.float64]:
    if not numbers:
        raise DataError(f"{source}: no rows")
    rows = [lines[number].split() for number in numbers]
    for number, cells in zip(numbers, rows, strict=True):
        if len(cells) != len(names):
            raise DataError(f"{source}: line {number + 1}: {len(cells)} cells for {len(names)} channels")
    try:
        return np.array(rows, dtype=np.float64)
    except ValueError:
        number, name, cell = next(
            (number, name, cell)
            for number, cells in zip(numbers, rows, strict=True)
            for name, cell in zip(names, cells, strict=True)
            if not _is_number(cell)
        )
        raise DataError(f"{source}: line {number + 1}: channel {name}: {cell!r} is not a number") from None


def _is_number(cell: str) -> bool:
    try:
        float(cell)
    except ValueError:
        return False
    return True
