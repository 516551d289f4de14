"""The encoding of text files of any program."""

from __future__ import annotations

from codecs import BOM_UTF16_BE, BOM_UTF16_LE, getincrementaldecoder
from pathlib import Path

from ...boundary.errors import DataError

#: Bytes from the begin of a file that decide.
EXAMINED = 1 << 20


def encoding_of(path: Path) -> str:
    """Return UTF-8, UTF-16 of a file with a byte order mark, or Latin-1, in which Windows programs write degree signs.

    Raises `DataError` if the file is no text.
    """
    with path.open("rb") as file:
        start = file.read(EXAMINED)
    if start.startswith((BOM_UTF16_LE, BOM_UTF16_BE)):
        return "utf-16"
    if b"\0" in start:
        raise DataError(f"{path}: not a text file")
    try:
        getincrementaldecoder("utf-8")().decode(start)
    except UnicodeDecodeError:
        return "latin-1"
    return "utf-8-sig"
