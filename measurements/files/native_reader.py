"""Reading of files by native code in a separate process: a file that crashes it is an error message, not a crash."""

from __future__ import annotations

import atexit
import os
import pickle
import subprocess
import sys
import threading
from pathlib import Path
from typing import Any

from ...boundary.errors import DataError
from . import reader_process
from .reader_process import MissingPackage

__all__ = ["MissingPackage", "close", "load"]

#: Memory limit in bytes: a constant, and a factor for the size of the file, which may be compressed.
MEMORY, MEMORY_PER_BYTE = 4 << 30, 100
#: Limit of the content in bytes: a constant, and a factor for the size of the file, the largest compression ratio.
CONTENT, CONTENT_PER_BYTE = 64 << 20, 1000
#: Time limits in seconds: constants for the clock and for the processor, and a term for each byte of the file.
#: Compressed messages of ROS need the longest for a byte.
SECONDS, PROCESSOR_SECONDS, SECONDS_PER_BYTE = 60.0, 4.0, 2e-5


class _Process:
    """A process that reads files until a file crashes it."""

    def __init__(self) -> None:
        self._owner = os.getpid()
        # Single-threaded: the address space of further threads counts towards the memory limit.
        one_thread = {"OPENBLAS_NUM_THREADS": "1", "OMP_NUM_THREADS": "1", "ARROW_DEFAULT_MEMORY_POOL": "system"}
        self._popen = subprocess.Popen(
            [sys.executable, "-P", reader_process.__file__],
            stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, env={**os.environ, **one_thread},
        )  # fmt: skip

    @property
    def usable(self) -> bool:
        """Whether the process is running and was started by this process, not by a parent from which it was forked."""
        return self._owner == os.getpid() and self._popen.poll() is None

    def send(self, request: tuple[Any, ...], seconds: float) -> tuple[str, Any]:
        """Return the answer to a request; raise `TimeoutError` if it is late, `EOFError` if there is none."""
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
            status, content = pickle.load(self._popen.stdout)
        except BaseException as error:  # also for Ctrl-C: a late answer would be read as the next one
            self.close()
            if late.is_set():
                raise TimeoutError from error
            if isinstance(error, Exception):  # no answer, a partial or an unreadable one
                raise EOFError from error
            raise
        finally:
            timer.cancel()
        return status, content

    def close(self) -> None:
        """End the process."""
        if self._owner == os.getpid():
            self._popen.kill()
            self._popen.communicate()


_lock = threading.Lock()
_running: _Process | None = None


def load(wanted: str, path: Path, *arguments: Any) -> Any:
    """Return the content of a file, read by native code.

    `wanted`: a name of `reader_process.LOADERS`, whose function returns the content and takes the arguments. Raises
    `OSError` if the file cannot be opened, `MissingPackage` if the package that reads such files is not installed, and
    `DataError` if the file has another format, or the code that reads it crashes.
    """
    global _running
    size = _size(path)
    memory, largest = MEMORY + MEMORY_PER_BYTE * size, CONTENT + CONTENT_PER_BYTE * size
    more = SECONDS_PER_BYTE * size
    request = (wanted, os.path.abspath(path), memory, PROCESSOR_SECONDS + more, largest, arguments)
    with _lock:
        if _running is None or not _running.usable:
            _running = _Process()
        try:
            status, content = _running.send(request, SECONDS + more)
        except TimeoutError:
            status, content = "refused", "reading takes too long"
        except EOFError:
            status, content = "refused", "the file is damaged and crashes its reader"
    if status == "missing":
        raise MissingPackage(content)
    if status == "refused":
        kind = {"excel": "an Excel workbook", "matlab": "a MATLAB file", "log": f"a {path.suffix} log"}.get(
            wanted, "Parquet"
        )
        raise DataError(f"{path}: cannot be read as {kind}: {content}")
    return content


def _size(path: Path) -> int:
    """Return the bytes of a file that can be opened, or of the files in a folder."""
    if path.is_dir():
        return sum(entry.stat().st_size for entry in os.scandir(path) if entry.is_file())
    with path.open("rb") as file:
        return os.fstat(file.fileno()).st_size


@atexit.register
def close() -> None:
    """End the reading process, if there is one. The next file starts a new one."""
    global _running
    if _running is not None:
        _running.close()
        _running = None
