"""Files read by native code, in a process of its own: one that breaks that code is a clear line, not a crash."""

from __future__ import annotations

import atexit
import os
import pickle
import subprocess
import sys
import threading
from pathlib import Path
from typing import Any

from tirefmu.symbolic.errors import DataError

from . import reader_process
from .reader_process import MissingPackage

__all__ = ["MissingPackage", "close", "load"]

#: Memory that reading may take: so much, and so much for each byte of the file, which may be compressed.
MEMORY, MEMORY_PER_BYTE = 4 << 30, 100
#: Bytes that a file may turn out to hold: so many, and so many for each byte, which is what compression can reach.
CONTENT, CONTENT_PER_BYTE = 64 << 20, 1000
#: Seconds that reading may take: so many, and so many for each byte.
SECONDS, SECONDS_PER_BYTE = 60.0, 1e-6


class _Process:
    """A process that reads files until one of them breaks it."""

    def __init__(self) -> None:
        self._owner = os.getpid()
        # One thread each: these have address space of their own, which counts against the limit.
        alone = {"OPENBLAS_NUM_THREADS": "1", "OMP_NUM_THREADS": "1", "ARROW_DEFAULT_MEMORY_POOL": "system"}
        self._popen = subprocess.Popen(
            [sys.executable, "-P", reader_process.__file__],
            stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, env={**os.environ, **alone},
        )  # fmt: skip

    @property
    def usable(self) -> bool:
        """Whether it lives and belongs to this process, not to one that this was forked from."""
        return self._owner == os.getpid() and self._popen.poll() is None

    def ask(self, request: tuple[str, str, int, int], seconds: float) -> tuple[str, Any]:
        """Return the answer to a request.

        Raises
        ------
        TimeoutError, EOFError
            If there is none in time, or none at all.
        """
        assert self._popen.stdin is not None
        assert self._popen.stdout is not None
        late = threading.Event()

        def stop() -> None:
            late.set()
            self._popen.kill()

        timer = threading.Timer(seconds, stop)
        timer.start()
        try:
            self._popen.stdin.write(pickle.dumps(request))
            self._popen.stdin.flush()
            word, content = pickle.load(self._popen.stdout)
        except BaseException as error:  # Ctrl-C too: the answer that comes later would be taken for the next one
            self.close()
            if late.is_set():
                raise TimeoutError from error
            if isinstance(error, Exception):  # no answer, half of one, or none that can be understood
                raise EOFError from error
            raise
        finally:
            timer.cancel()
        return word, content

    def close(self) -> None:
        """End the process."""
        if self._owner == os.getpid():
            self._popen.kill()
            self._popen.communicate()


_lock = threading.Lock()
_running: _Process | None = None


def load(form: str, path: Path) -> Any:
    """Return what native code reads in a file.

    Parameters
    ----------
    form : {"matlab", "parquet"}
    path : pathlib.Path

    Returns
    -------
    dict of str to Any, or pandas.DataFrame
        The variables of a ``.mat`` file, or the table.

    Raises
    ------
    OSError
        If the file cannot be opened.
    MissingPackage
        If the package that reads such files is not installed.
    DataError
        If the file is no such file, or breaks the code that reads it.
    """
    global _running
    with path.open("rb") as file:
        size = os.fstat(file.fileno()).st_size
    memory, most = MEMORY + MEMORY_PER_BYTE * size, CONTENT + CONTENT_PER_BYTE * size
    request = (form, os.path.abspath(path), memory, most)
    with _lock:
        if _running is None or not _running.usable:
            _running = _Process()
        try:
            word, content = _running.ask(request, SECONDS + SECONDS_PER_BYTE * size)
        except TimeoutError:
            word, content = "refused", "reading takes too long"
        except EOFError:
            word, content = "refused", "it is damaged so that its reader crashes"
    if word == "missing":
        raise MissingPackage(content)
    if word == "refused":
        kind = {"matlab": "a MATLAB file", "parquet": "Parquet"}[form]
        raise DataError(f"{path}: cannot be read as {kind}: {content}")
    return content


@atexit.register
def close() -> None:
    """End the process that reads, if there is one; the next file starts another."""
    global _running
    if _running is not None:
        _running.close()
        _running = None
