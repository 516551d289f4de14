"""FSAE Tire Test Consortium (Calspan) files in ASCII format."""

from __future__ import annotations

import re
from pathlib import Path

from ...boundary.errors import DataError
from ..interpretation import Interpretation
from ..recording import Recording
from .columns import is_number, rows_of_numbers
from .ttc_channels import bench_recording, has_bench_names

_TITLE_LINES = 20  # upper limit; the names of the channels are in the second line or shortly after
_AXES = re.compile(r"\bISO\W*(?P<answer>true|false)\b", re.IGNORECASE)
_UNIT_OF_TWO_WORDS = re.compile(r"\bdeg(?:rees?)? +(?=[CFK]\b)", re.IGNORECASE)


def read_ttc_dat(path: Path, signs: str, interpretation: Interpretation) -> Recording:
    """Read a ``.dat`` file of the FSAE TTC: a title, names, units, and rows separated by blanks or tabs.

    `signs`: the convention of the file; Calspan writes sae. ``about["signs"]`` has that of the title (``ISO True``), if
    any, and ``about["tireid"]`` the title. Raises `DataError` if no line has the names of the channels, rows differ in
    length, or a cell is not a number (with the line). Also raises what `bench_recording` raises.
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
    table = rows_of_numbers(((number + 1, lines[number].split()) for number in numbers), names, source)
    title = " ".join(" ".join(line.split()) for line in lines[:at])
    about = {"tireid": title, "testid": "", "credit": ""}
    axes = _AXES.search(title)
    if axes is not None:
        about["signs"] = "iso" if axes["answer"].casefold() == "true" else "sae"
    vectors = dict(zip(names, table.T, strict=True))
    return bench_recording(path, vectors, units, signs, about, lambda row: f"line {numbers[row] + 1}", interpretation)


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
