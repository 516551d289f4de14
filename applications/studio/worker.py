"""The process of long work: loaded before it is needed, it waits for one command line, runs it, and ends.

Its standard input has one line of JSON: the arguments, and the file to which a fit writes its tire while it runs.
It ends when its standard input is closed: with the window.
"""

from __future__ import annotations

import json
import os
import signal
import sys
import threading
from collections.abc import Callable
from importlib import import_module
from time import monotonic
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from ...tires import Tire

#: What a fit imports; loading it takes longer than its first stage.
LOADED = (
    "tirefmu.commands.cli", "tirefmu.applications.batch.intervals", "tirefmu.fitting.reporting.report",
    "tirefmu.diagnosis.diagnose", "tirefmu.applications.project.run",
)  # fmt: skip
#: s between two tires of a running fit.
INTERVAL = 0.1


def run() -> int:
    """Wait for a command line, run it and return its exit code."""
    for name in LOADED:
        import_module(name)
    from ...tires.code.printed import sources_digest

    sources_digest()
    line = sys.stdin.readline()
    if not line:
        return 0
    threading.Thread(target=_end_with_the_window, daemon=True).start()
    signal.signal(signal.SIGTERM, lambda *_: os._exit(143))  # the button ends a fit, which would otherwise finish
    arguments, tire_file = json.loads(line)
    import_module("tirefmu.commands.progress").follower.set(_written_to(tire_file))
    return int(import_module("tirefmu.commands.cli").main(arguments))


def _written_to(tire_file: str) -> Callable[[Tire], None]:
    """Return what writes a tire to a file, unless the latest one was written just before."""
    latest = -INTERVAL

    def write(tire: Tire) -> None:
        nonlocal latest
        if monotonic() - latest >= INTERVAL:
            tire.save(tire_file)
            latest = monotonic()

    return write


def _end_with_the_window() -> None:
    sys.stdin.read()
    if hasattr(os, "killpg"):
        os.killpg(os.getpid(), signal.SIGKILL)  # also processes that it has started: it leads their group
    os._exit(130)


if __name__ == "__main__":
    sys.exit(run())
