"""A command in a process of its own, which ends at a time limit."""

from __future__ import annotations

import subprocess
import sys
from collections.abc import Callable, Sequence
from threading import Event, Timer

from ...boundary.errors import TirefmuError

#: What an error of the command line begins with.
ERROR = "tirefmu: error: "


class TimeLimitReached(Exception):
    """The process was ended. It carries the last line of its progress."""


def run_limited(command: str, arguments: Sequence[str], seconds: float, report: Callable[[str], None]) -> int:
    """Run a command of the command line, and end it at a time limit, whatever it computes then.

    `report`: called with each line of its progress. Returns: its exit code, 0 or 1. Raises `TimeLimitReached` if it was
    ended. Raises `TirefmuError`: with its message, if it ended with an error.
    """
    line = [sys.executable, "-P", "-m", "tirefmu", command, *arguments]  # -P: no module of the current folder
    process = subprocess.Popen(line, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True, errors="replace")
    reached, last = Event(), ""

    def end() -> None:
        reached.set()
        process.kill()

    timer = Timer(seconds, end)
    timer.start()
    with process:
        try:
            for text in process.stderr or ():
                last = text.rstrip()
                if not last.startswith(ERROR):
                    report(last)
            status = process.wait()
        finally:
            timer.cancel()
            process.kill()
    if reached.is_set():
        raise TimeLimitReached(last)
    if status not in (0, 1):
        raise TirefmuError(last.removeprefix(ERROR) or f"ended with exit code {status}")
    return status
