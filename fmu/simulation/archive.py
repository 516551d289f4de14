"""Unpacking of an FMU: limited in size, and no entry is written outside the folder.

An archive is untrusted. Its size is checked before anything is written and again while it is written, as the sizes in
its directory can be wrong. Entries that no FMU needs are rejected: links, encryption, other compression than deflate,
names that are equal on some systems.
"""

from __future__ import annotations

import io
import os
import re
import stat
import tempfile
import unicodedata
import xml.parsers.expat
import zipfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from ...boundary.bounded_file import read_bounded
from ...boundary.errors import FmuError, reading
from ...boundary.escaping import visible

#: The largest archive, and its largest size when unpacked, bytes.
MAX_BYTES = 200_000_000
#: The largest single file in it, bytes.
LARGEST_FILE = 100_000_000
#: The largest number of files and folders in it.
MAX_ENTRIES = 10_000
#: The largest modelDescription.xml, bytes.
LARGEST_DESCRIPTION = 20_000_000
#: The longest path in it, characters.
LONGEST_NAME = 250
DESCRIPTION = "modelDescription.xml"

#: Signature of each entry in the directory of a zip file.
_ENTRY = b"PK\x01\x02"
#: Bytes unpacked per read.
_CHUNK = 1 << 20
#: Characters that at least one system does not allow in a file name.
_NOT_IN_NAMES = re.compile(r'[\x00-\x1f\x7f\\:*?"<>|]')


@contextmanager
def unpacked(path: str | os.PathLike[str]) -> Iterator[Path]:
    """Unpack an FMU into a temporary folder and remove the folder afterwards.

    Yields: the folder; it contains a modelDescription.xml without a document type. Raises `FmuError` if the file is
    missing, is not an FMU, exceeds a limit of this module, or has an entry that no FMU needs.

    >>> from tirefmu.tires import published
    >>> from tirefmu.fmu import export
    >>> with unpacked(export(published("trento_hoosier"), "tire.fmu")) as folder:
    ...     (folder / "resources" / "tire.tir").is_file()
    True
    """
    content = _content(Path(path))
    with tempfile.TemporaryDirectory(prefix="tirefmu-", ignore_cleanup_errors=True) as name:
        folder = Path(name)
        try:
            with zipfile.ZipFile(io.BytesIO(content)) as archive:
                entries = archive.infolist()
                _check(entries)
                _unpack(archive, entries, folder)
            _check_description(folder / DESCRIPTION)
        except Exception as error:  # zipfile raises many types for a broken archive
            raise FmuError(f"{path}: not a readable FMU ({visible(str(error))[:300]})") from error
        yield folder


def _content(path: Path) -> bytes:
    """Return the bytes of an archive within the size limit."""
    if not path.is_file():
        raise FmuError(f"{path}: no such file")
    with reading(path, FmuError):
        content = read_bounded(path, MAX_BYTES)
    # Reading a directory with millions of entries takes minutes, so they are counted first.
    if content.count(_ENTRY) > MAX_ENTRIES:
        raise FmuError(f"{path}: more than {MAX_ENTRIES} files")
    return content


def _check(entries: list[zipfile.ZipInfo]) -> None:
    """Raise if the directory of an archive has an entry that is not allowed."""
    total = 0
    earlier: dict[str, tuple[str, bool]] = {}
    for entry in entries:
        shown = f"'{visible(entry.orig_filename)[:60]}'"
        if _is_unsafe(entry):
            raise FmuError(f"the file name {shown} is not allowed")
        if stat.S_IFMT(entry.external_attr >> 16) not in (0, stat.S_IFREG, stat.S_IFDIR):
            raise FmuError(f"{shown} is a link or a device")
        if entry.flag_bits & 0x1:
            raise FmuError(f"{shown} is encrypted")
        if entry.compress_type not in (zipfile.ZIP_STORED, zipfile.ZIP_DEFLATED):
            raise FmuError(f"{shown} is compressed by another method than deflate")
        total += entry.file_size
        largest = LARGEST_DESCRIPTION if entry.filename == DESCRIPTION else LARGEST_FILE
        if entry.file_size > largest:
            raise FmuError(f"{shown} has {_megabytes(entry.file_size)} when unpacked; at most {_megabytes(largest)}")
        if total > MAX_BYTES:
            raise FmuError(f"it has more than {_megabytes(MAX_BYTES)} when unpacked")
        for path, is_folder in _paths(entry):
            key = unicodedata.normalize("NFC", path).casefold()
            if key in earlier and (not is_folder or earlier[key] != (path, is_folder)):
                raise FmuError(f"{shown} is a duplicate, or differs from another name only by case")
            earlier[key] = path, is_folder


def _paths(entry: zipfile.ZipInfo) -> Iterator[tuple[str, bool]]:
    """Yield the paths of an entry and of its parent folders, and whether each is a folder."""
    name = entry.filename.rstrip("/")
    yield name, entry.is_dir()
    while "/" in name:
        name = name.rpartition("/")[0]
        yield name, True


def _is_unsafe(entry: zipfile.ZipInfo) -> bool:
    """Return whether a name is not a plain relative path on every system."""
    name = entry.orig_filename.removesuffix("/")
    return (
        len(name) > LONGEST_NAME
        or name != entry.filename.removesuffix("/")
        or _NOT_IN_NAMES.search(name) is not None
        or any(part in ("", ".", "..") for part in name.split("/"))
    )


def _unpack(archive: zipfile.ZipFile, entries: list[zipfile.ZipInfo], folder: Path) -> None:
    """Write the files and check the real size."""
    total = 0
    for entry in entries:
        target = folder / entry.filename
        if entry.is_dir():
            target.mkdir(parents=True, exist_ok=True)
            continue
        target.parent.mkdir(parents=True, exist_ok=True)
        with archive.open(entry) as packed, target.open("xb") as file:
            while chunk := packed.read(_CHUNK):
                total += len(chunk)
                if total > MAX_BYTES:
                    raise FmuError(f"it has more than {_megabytes(MAX_BYTES)} when unpacked")
                file.write(chunk)


class _RootReached(Exception):
    """The parser has reached the root element: a document type would precede it."""


def _check_description(path: Path) -> None:
    """Raise if there is no model description, or it has a document type, whose entities can have any size."""
    if not path.is_file():
        raise FmuError(f"it has no {DESCRIPTION}")

    def refuse(*_: object) -> None:
        raise FmuError(f"{DESCRIPTION} has a document type (DOCTYPE)")

    def stop(*_: object) -> None:
        raise _RootReached

    parser = xml.parsers.expat.ParserCreate()
    parser.StartDoctypeDeclHandler = refuse
    parser.StartElementHandler = stop
    try:
        parser.Parse(path.read_bytes(), True)
    except _RootReached:
        return


def _megabytes(size: int) -> str:
    return f"{size / 1e6:,.0f} MB"
