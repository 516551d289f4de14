"""The user's cache of compiled libraries and printed code. Every entry is checked before it is used.

An entry is a folder ``NAME-DIGEST`` with its files and a record of their sizes and SHA-256 digests. It is written to a
temporary folder and renamed in one step, so another process finds all of it or nothing. An entry that is damaged, or
that another user could have written, is built again. If several processes need the same entry, one builds it and the
others wait. If the cache cannot be trusted or written, a private temporary folder replaces it until this process ends.
On Windows only the user can access the cache folder, so only the digests are checked.
"""

from __future__ import annotations

import atexit
import contextlib
import hashlib
import logging
import os
import shutil
import stat
import tempfile
import time
from collections.abc import Callable, Iterator
from functools import lru_cache
from pathlib import Path

import filelock
import platformdirs

from ...boundary.escaping import visible

#: The file of an entry that holds the digests of the others.
RECORD = "sha256sums"
#: Size above which the entries that were not used for the longest time are removed, bytes.
MAX_BYTES = 500_000_000
#: An entry used within this time may still be in use in another process and stays, s.
IN_USE = 86_400.0
#: Longest wait for another process that builds the same entry, s; afterwards it is built here, too.
LONGEST_BUILD = 600.0
#: Attempts to store an entry while other processes store theirs.
ATTEMPTS = 5

#: The prefix of the name of an unfinished or a removed entry, and of a lock.
_SCRATCH = ".scratch-"
#: Entries that this process uses.
_used: set[Path] = set()
#: The folder that replaces the cache in this process, if it needs one.
_private: list[Path] = []


def cache_folder() -> Path:
    """Return the folder of the cache: TIREFMU_CACHE, or the user's cache folder."""
    if given := os.environ.get("TIREFMU_CACHE"):
        return Path(given)
    return platformdirs.user_cache_path("tirefmu", appauthor=False, opinion=False)


def cached(name: str, make: Callable[[Path], None], *, rebuild: bool = False) -> Path:
    """Return the folder of an entry, which is built if it is missing or damaged.

    `name`: a file name that identifies the content: equal names mean equal entries. `make`: writes the files into an
    empty folder. `rebuild`: make the entry again: its content is as recorded, but of no use here. The folder is in the
    cache, or in a private temporary folder that goes with this process. Raises `OSError` if it can be written nowhere.

    >>> folder = cached("example", lambda folder: folder.joinpath("text").write_text("made once"))
    >>> folder.joinpath("text").read_text()
    'made once'
    """
    cache = _trusted_cache()
    stored = None if rebuild else _found(cache, name)
    if stored or not cache:
        return stored or _built(None, name, make, rebuild)
    with _locked(cache, name):
        # Another process may have built it in the meantime.
        return (None if rebuild else _found(cache, name)) or _built(cache, name, make, rebuild)


def intact_entry(name: str) -> Path | None:
    """Return the folder of an entry that exists and is intact, or None.

    `name`: as for `cached`.

    >>> print(intact_entry("never-made"))
    None
    """
    return _found(_trusted_cache(), name)


def _found(cache: Path | None, name: str) -> Path | None:
    """Return an entry that exists and is intact."""
    for folder in (cache, *_private):
        if folder and _is_intact(folder / name):
            return _in_use(folder / name)
    return None


@contextlib.contextmanager
def _locked(cache: Path, name: str) -> Iterator[None]:
    """Wait until no other process builds an entry, and let others wait; without a lock if none is possible.

    The lock only saves work: entries are stored in one step, so two builds do no harm. The lock file can therefore be
    removed although another process may wait for it.
    """
    path = cache / f"{_SCRATCH}{name}"
    with contextlib.ExitStack() as stack:
        with contextlib.suppress(OSError, NotImplementedError):
            stack.enter_context(filelock.FileLock(path, timeout=LONGEST_BUILD))
            stack.callback(_remove, path)
        yield


def _remove(path: Path) -> None:
    with contextlib.suppress(OSError):  # on Windows an open file cannot be removed; filelock does it
        path.unlink()


def _built(cache: Path | None, name: str, make: Callable[[Path], None], rebuild: bool) -> Path:
    """Build an entry and return its folder, a private one if it cannot be stored in the cache."""
    with tempfile.TemporaryDirectory(prefix="tirefmu-") as scratch:
        made = Path(scratch) / name
        made.mkdir()
        make(made)
        (made / RECORD).write_text(_record(made, any_writer=True), encoding="utf-8")
        if cache:
            try:
                _store(made, cache / name, rebuild)
            except OSError as error:
                _warn(f"{cache}: cannot be written ({error.strerror or error})")
            else:
                with contextlib.suppress(OSError):  # another process may also be removing it
                    _prune(cache)
                return _in_use(cache / name)
        target = _private_folder() / name
        _store(made, target, rebuild)
    return _in_use(target)


def _trusted_cache() -> Path | None:
    """Return the cache's folder, created if it is missing; None, with a warning, if others could write into it."""
    folder = Path(os.path.realpath(cache_folder()))
    try:
        folder.mkdir(mode=0o700, parents=True, exist_ok=True)
        doubt = _doubt(folder)
    except OSError as error:
        doubt = f"{folder}: cannot be used ({error.strerror or error})"
    if doubt:
        _warn(doubt)
    return None if doubt else folder


def _doubt(folder: Path) -> str:
    """Return why files in a folder could be another user's, or nothing.

    A user who can write into one of the folders above can replace it, unless the sticky bit is set.
    """
    for place in (folder, *folder.parents):
        status = place.stat()
        if not _ours(status):
            return f"{place}: belongs to another user"
        if _others_write(status) and (place == folder or not status.st_mode & stat.S_ISVTX):
            return f"{place}: other users can write into it"
    return ""


def _ours(status: os.stat_result) -> bool:
    """Return whether a file is this user's or the system's."""
    return not hasattr(os, "geteuid") or status.st_uid in (0, os.geteuid())


def _others_write(status: os.stat_result) -> bool:
    """Return whether others may write; a group with the user's own number has no other members."""
    if not hasattr(os, "geteuid"):
        return False
    alone = status.st_gid == os.getegid() == os.geteuid()
    return bool(status.st_mode & (stat.S_IWOTH if alone else stat.S_IWOTH | stat.S_IWGRP))


def _warn(doubt: str) -> None:
    _warn_once(f"{visible(doubt)}: compiled code is not stored beyond this run")


@lru_cache(maxsize=16)
def _warn_once(text: str) -> None:
    logging.getLogger("tirefmu").warning("tirefmu: %s", text)


def _private_folder() -> Path:
    """Return a folder that only this user can enter; it is removed when the process ends."""
    if not _private:
        folder = tempfile.mkdtemp(prefix="tirefmu-")
        atexit.register(shutil.rmtree, folder, ignore_errors=True)
        _private.append(Path(folder))
    return _private[0]


def _is_intact(target: Path) -> bool:
    """Return whether an entry exists with the recorded content, and only this user could write it.

    The checked content is loaded afterwards: in a folder that only this user can write, no other user can exchange a
    file in between.
    """
    try:
        return _record(target) == _content(target / RECORD).decode()
    except (OSError, UnicodeDecodeError):
        return False


def _record(target: Path, any_writer: bool = False) -> str:
    """Return digest, size and name of every file of an entry.

    Raises `OSError` if it contains anything but files and folders, or, unless `any_writer` is set, others could have
    written it.
    """
    lines = []
    for path in (target, *sorted(target.rglob("*"))):
        status = path.lstat()
        if not any_writer and (not _ours(status) or _others_write(status)):
            raise PermissionError(f"{path}: other users can write it")
        if stat.S_ISDIR(status.st_mode) or path == target / RECORD:
            continue
        content = _content(path)
        lines.append(f"{hashlib.sha256(content).hexdigest()} {len(content)} {path.relative_to(target).as_posix()}\n")
    return "".join(lines)


def _content(path: Path) -> bytes:
    """Return the bytes of a regular file; a symbolic link or a device is refused."""
    flags = [getattr(os, name, 0) for name in ("O_NOFOLLOW", "O_NONBLOCK", "O_BINARY")]  # 0 if the system lacks one
    with open(os.open(path, os.O_RDONLY | sum(flags)), "rb") as file:
        if not stat.S_ISREG(os.fstat(file.fileno()).st_mode):
            raise PermissionError(f"{path}: not a regular file")
        return file.read()


def _in_use(target: Path) -> Path:
    """Record that an entry is used, now and by this process."""
    _used.add(target)
    with contextlib.suppress(OSError):  # a cache that may only be read
        os.utime(target)
    return target


def _store(made: Path, target: Path, rebuild: bool) -> None:
    """Store an entry in one step; an entry that another process has stored in the meantime is not replaced."""
    scratch = Path(tempfile.mkdtemp(prefix=_SCRATCH, dir=target.parent))
    try:
        copy = scratch / target.name
        for path in (made, *sorted(made.rglob("*"))):
            copied = copy / path.relative_to(made)
            if path.is_dir():
                copied.mkdir(mode=0o700)
            else:
                copied.write_bytes(path.read_bytes())
                copied.chmod(0o600)
        for attempt in range(ATTEMPTS):
            try:
                os.rename(copy, target)
                return
            except OSError:  # the entry already exists
                if attempt == ATTEMPTS - 1:
                    raise
            if _is_intact(target) and (attempt or not rebuild):
                return
            with contextlib.suppress(FileNotFoundError):  # another process is doing the same
                os.rename(target, scratch / f"damaged-{attempt}")
    finally:
        shutil.rmtree(scratch, ignore_errors=True)


def _prune(cache: Path) -> None:
    """Remove the least recently used entries if the cache is too large."""
    entries = [path for path in cache.iterdir() if path.name.startswith(_SCRATCH) or (path / RECORD).is_file()]
    sizes = {path: _size(path) for path in entries if path.is_dir()}
    total = sum(sizes.values())
    for path in sorted(entries, key=lambda path: path.lstat().st_mtime):
        if total <= MAX_BYTES or time.time() - path.lstat().st_mtime < IN_USE:
            return
        if path not in _used:
            removed = Path(tempfile.mkdtemp(prefix=_SCRATCH, dir=cache))
            os.rename(path, removed / path.name)  # in one step: another process finds all of it or nothing
            shutil.rmtree(removed, ignore_errors=True)
            total -= sizes.get(path, 0)


def _size(folder: str | Path) -> int:
    """Return the size of everything below a folder, bytes; `Path.rglob` takes several times as long."""
    with os.scandir(folder) as entries:
        return sum(
            entry.stat(follow_symlinks=False).st_size
            + (_size(entry.path) if entry.is_dir(follow_symlinks=False) else 0)
            for entry in entries
        )
