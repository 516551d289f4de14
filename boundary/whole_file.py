"""Files are written completely or not at all."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path


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
