"""The text of a .tir file as sections, entries and rows of tables, independent of the meaning of keys.

The format is TeimOrbit: ``[SECTION]``, ``KEY = value``, comments after ``$`` or ``!`` outside quotes, tables of plain
lines below a heading in braces. Files have line ends of any system, also mixed, in UTF-8, Latin-1 or UTF-16 with a
mark; keys and sections in any case; numbers in Fortran's notation.
"""

from __future__ import annotations

import math
import re
from dataclasses import dataclass
from pathlib import Path

from ...boundary.bounded_file import read_bounded
from ...boundary.errors import TirError, reading
from ...boundary.escaping import excerpt, quoted

#: The largest file that is read, bytes, and the most lines; files in use have a few hundred lines, those with long
#: tables about ten thousand. The longest line, characters: an added effect's file is one line.
MAX_BYTES, MAX_LINES, LONGEST_LINE = 10_000_000, 50_000, 200_000
#: The longest text of a number, characters. The exact decimals of the smallest doubles have 1,077.
LONGEST_NUMBER = 1500

_PADDING = "\x1a\0"  # Ctrl-Z and zeros, which programs of DOS write at the end
_LINE_END = re.compile(r"\r\n|\n|\r")
_SECTION = re.compile(r"\[([^\[\]]*)\](.*)")
_KEY = re.compile(r"[A-Za-z]\w*", re.ASCII)
# There is only one way to match given digits, so the time is proportional to the length.
_NUMBER = re.compile(r"([+-]?(?:\d+(?:\.\d*)?|\.\d+))(?:[eEdD]([+-]?\d+))?", re.ASCII)
_BARE_EXPONENT = re.compile(r"([+-]?(?:\d+\.\d*|\.\d+))([+-]\d+)", re.ASCII)  # Fortran's 1.5+3
_QUOTED = re.compile(r"(['\"])([^'\"]*)\1([^'\"]*)")
_BYTE_ORDER_MARKS = {b"\xef\xbb\xbf": "utf-8-sig", b"\xff\xfe": "utf-16", b"\xfe\xff": "utf-16"}


@dataclass(frozen=True)
class Entry:
    """A line ``KEY = value``: section and key in upper case, the value as written, without its comment."""

    section: str
    key: str
    value: str
    line: int


@dataclass(frozen=True)
class Row:
    """A line that is not an entry, unchanged: of a table if a heading in braces is above it."""

    section: str
    text: str
    line: int
    in_table: bool


def read_lines(path: Path) -> list[Entry | Row]:
    """Read the entries and rows of a .tir file.

    The result is in the file's order; comments, blank lines and prose before the first section are skipped. Raises
    `TirError` if the file cannot be read, is larger than `MAX_BYTES`, `MAX_LINES` or `LONGEST_LINE`, or a section's
    name is broken.
    """
    with reading(path, TirError):
        content = read_bounded(path, MAX_BYTES)
    text = _decoded(content).rstrip(_PADDING)
    if "\0" in text:
        raise TirError(f"{path}: not a text: not a .tir file")
    if text.lstrip().startswith("{"):
        raise TirError(f"{path}: a JSON file, as of TMeasy: not a .tir file")
    return parse_lines(text, path)


def parse_lines(text: str, path: Path) -> list[Entry | Row]:
    r"""Return the entries and rows of a text, as `read_lines` does.

    >>> parse_lines("[vertical] $ comment\r\nfnomin=4.D3 ! N", Path("tire.tir"))
    [Entry(section='VERTICAL', key='FNOMIN', value='4.D3', line=2)]
    """
    lines: list[Entry | Row] = []
    section, in_table = "", False
    raw_lines = _LINE_END.split(text)
    if len(raw_lines) > MAX_LINES:
        raise TirError(f"{path}: more than {MAX_LINES} lines: not a .tir file")
    for number, raw in enumerate(raw_lines, start=1):
        if len(raw) > LONGEST_LINE:
            raise TirError(f"{path}:{number}: longer than {LONGEST_LINE} characters: not a .tir file")
        line = without_comment(raw).strip()
        if not line:
            continue
        if line.startswith("["):
            section, in_table = _section(line, f"{path}:{number}"), False
            continue
        key, equals, value = (part.strip() for part in line.partition("="))
        if equals and _KEY.fullmatch(key):
            in_table = False
            lines.append(Entry(section, key.upper(), value, number))
        elif section:
            in_table = in_table or line[0] in "{("
            lines.append(Row(section, raw, number, in_table))
    return lines


def without_comment(line: str) -> str:
    """Return a line up to its comment; a quote that is not closed is an apostrophe.

    >>> without_comment("NAME = 'Q$' $ quick"), without_comment("AREA = driver's ! side")
    ("NAME = 'Q$' ", "AREA = driver's ")
    """
    i = 0
    while i < len(line):
        if line[i] in "'\"":
            closing = line.find(line[i], i + 1)
            i = max(i, closing)
        elif line[i] in "$!":
            return line[:i]
        i += 1
    return line


def unquoted(value: str) -> str:
    """Return a value without the quotes around it and without text behind them.

    >>> unquoted("'PAC2002'"), unquoted("kg"), unquoted("'LEFT' mounted")
    ('PAC2002', 'kg', 'LEFT')
    """
    return _opened(value)[0]


def number_and_rest(value: str) -> tuple[float, str]:
    """Return the number that a value begins with, and the text behind it.

    `value`: also ``.5``, ``5.``, and Fortran's ``1.5D+03`` and ``1.5+3``; in quotes or not. Returns: NaN if there is no
    finite number, it is longer than `LONGEST_NUMBER`, or a blank does not end it.

    >>> number_and_rest("1.5D+03"), number_and_rest("'.5'"), number_and_rest("4 per cent"), number_and_rest("'4' kN")
    ((1500.0, ''), (0.5, ''), (4.0, 'per cent'), (4.0, 'kN'))
    >>> number_and_rest("1,5")[0]
    nan
    """
    inner, behind = _opened(value)
    word, _, rest = inner.partition(" ")
    if len(word) > LONGEST_NUMBER:
        return math.nan, " ".join(f"{rest} {behind}".split())
    match = _NUMBER.fullmatch(word) or _BARE_EXPONENT.fullmatch(word)
    number = float(f"{match[1]}e{match[2] or 0}") if match else math.nan
    return (number if math.isfinite(number) else math.nan), " ".join(f"{rest} {behind}".split())


def _opened(value: str) -> tuple[str, str]:
    """Return the text in a value's quotes and the text behind them; a value without quotes unchanged."""
    match = _QUOTED.fullmatch(value.strip())
    return (match[2].strip(), match[3].strip()) if match else (" ".join(value.split()), "")


def _decoded(content: bytes) -> str:
    for mark, encoding in _BYTE_ORDER_MARKS.items():
        if content.startswith(mark):
            return content.decode(encoding, errors="replace")
    try:
        return content.decode("utf-8")
    except UnicodeDecodeError:
        return content.decode("latin-1")  # written by common tools: a degree sign, an umlaut


def _section(line: str, where: str) -> str:
    match = _SECTION.fullmatch(line)
    if match is None:
        raise TirError(f"{where}: section {quoted(line)} is not closed by ']'")
    if match[2].strip():
        raise TirError(f"{where}: text behind section [{excerpt(match[1].strip())}]: {quoted(match[2].strip())}")
    return match[1].strip().upper()
