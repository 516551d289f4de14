"""Files read within limits, and written completely or not at all.

What is larger or deeper than any sensible file of its kind does not fill the memory.
`tomllib` stores every beginning of a dotted key, so its memory grows with the square of the depth: a key of 80 KB takes
6 GB. All TOML is therefore read here, and its depth is checked before it is parsed.
"""

from __future__ import annotations

import errno
import re
import tomllib
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from itertools import accumulate
from pathlib import Path
from typing import Any

from .errors import TirefmuError

#: Upper limits of TOML: bytes of a file; parts of a key and levels of arrays and tables in each other. A job list of
#: 10,000 tires has 1 MB; the keys and tables of effects, the deepest ones, have 4 levels.
MAX_BYTES, DEEPEST = 2_000_000, 20

_CHUNK = 1 << 20  # bytes read at a time: a read reserves as many

# Texts and comments, as `tomllib` finds their ends; one without an end, which is an error there, extends to the end. No
# character is tried twice: the time is proportional to the length.
_TEXT_OR_COMMENT = re.compile(
    r'''"""(?:[^"\\]+|\\.|"(?!""))*+(?:"{3,5})?|\'\'\'(?:[^']+|'(?!''))*+(?:'{3,5})?'''
    r"""|"(?:[^"\\\n]+|\\.)*+"?|'[^'\n]*'?|#[^\n]*""",
    re.DOTALL,
)
_DEEP_KEY = re.compile(rf"(?:\.[^.=,\[\]{{}}\n]*+){{{DEEPEST}}}")
_LEVEL = {"[": 1, "{": 1, "]": -1, "}": -1}


def read_bounded(path: Path, most: int) -> bytes:
    """Return the content of a file that is not larger than a limit.

    `most`: bytes; also of what has no size to ask for, such as a device. Raises `OSError` if it cannot be read; with
    EFBIG and the limit in words if it is larger.

    >>> import tempfile
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     file = Path(folder) / "file"
    ...     _ = file.write_bytes(bytes(2_000_001))
    ...     try:
    ...         read_bounded(file, 2_000_000)
    ...     except OSError as error:
    ...         print(error.strerror)
    larger than 2 MB
    """
    parts, left = [], most
    with path.open("rb") as file:
        while part := file.read(_CHUNK):
            left -= len(part)
            if left < 0:
                raise OSError(errno.EFBIG, f"larger than {most / 1e6:g} MB", str(path))
            parts.append(part)
    return b"".join(parts)


def toml_content(text: str, source: str, error: type[TirefmuError]) -> dict[str, Any]:
    r"""Return the content of a TOML text.

    `source`: its origin, for messages. `error`: raised if the text is invalid. Raises `TirefmuError` if the text is not
    TOML, or a key, or arrays and tables in each other, have more than `DEEPEST` levels.

    >>> toml_content('a.b = "dots ...... and [[[[["', "a.toml", TirefmuError)
    {'a': {'b': 'dots ...... and [[[[['}}
    >>> toml_content("a." * 20 + "b = 1", "a.toml", TirefmuError)
    Traceback (most recent call last):
    ...
    tirefmu.boundary.errors.TirefmuError: a.toml: a key or a value has more than 20 levels
    """
    structure = _TEXT_OR_COMMENT.sub("", text)
    levels = accumulate(_LEVEL[sign] for sign in re.findall(r"[\[\]{}]", structure))
    if _DEEP_KEY.search(structure) or max(levels, default=0) > DEEPEST:
        raise error(f"{source}: a key or a value has more than {DEEPEST} levels")
    try:
        return tomllib.loads(text)
    except ValueError as reason:  # also integers with thousands of digits
        raise error(f"{source}: is not TOML: {reason}") from None


def toml_file(path: Path, error: type[TirefmuError]) -> dict[str, Any]:
    """Return the content of a TOML file.

    `error`: raised if the file is invalid. Raises `TirefmuError`: as `toml_content`; also if the file cannot be read,
    is no text, or has more than `MAX_BYTES`.
    """
    return toml_content(text_file(path, error), str(path), error)


def text_file(path: Path, error: type[TirefmuError]) -> str:
    """Return the text of a file of `MAX_BYTES` at most.

    `error`: raised if the file cannot be read, is larger, or is no text.
    """
    try:
        return read_bounded(path, MAX_BYTES).decode("utf-8")
    except OSError as reason:
        raise error(f"{path}: cannot be read ({reason.strerror or reason})") from None
    except UnicodeDecodeError:
        raise error(f"{path}: not a text file (UTF-8)") from None


@contextmanager
def replacing(path: Path) -> Iterator[Path]:
    """Give a temporary file that replaces a file if nothing fails: no partial file ever has its name.

    Raises `OSError` if the file cannot be written.
    """
    part = path.parent / f".{path.name}.part"
    try:
        part.unlink(missing_ok=True)  # a link would point elsewhere
        yield part
        part.replace(path)
    finally:
        with suppress(OSError):
            part.unlink()


def write_whole(path: Path, content: bytes) -> Path:
    """Write a file so that no partial file ever has its name; return its path.

    Raises `OSError` if the file cannot be written.
    """
    with replacing(path) as part:
        part.write_bytes(content)
    return path
