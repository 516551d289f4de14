"""Long work: one command at a time, in a process that can be stopped. The server only relays what it reports."""

from __future__ import annotations

import asyncio
import json
import os
import signal
import sys
from asyncio.subprocess import DEVNULL, PIPE, Process
from collections import deque
from collections.abc import Awaitable, Callable, Sequence
from contextlib import suppress
from pathlib import Path
from typing import Any

from ...boundary.errors import TirefmuError
from ...boundary.escaping import excerpt
from ..project.run import ERROR

#: Last lines of progress that a new window shows.
SHOWN_LINES = 8
#: s between a request to end and the end of a process that ignores it.
GRACE = 3.0
#: Longest line of progress, bytes.
LONGEST_LINE = 1 << 20
FORCED = getattr(signal, "SIGKILL", signal.SIGTERM)  # Windows lacks it
Report = Callable[[dict[str, Any]], Awaitable[None]]


class Work:
    """The work of a window: the running command, and a loaded process for the next one.

    `report`: called with ``{"event": "line" | "ended", ...}``. `running`:
    whether a command runs.
    """

    def __init__(self, report: Report) -> None:
        self._report = report
        self._next: Process | None = None
        self._process: Process | None = None
        self._task: asyncio.Task[None] | None = None
        self._stopped = self.running = False
        self.title = ""
        self.lines: deque[str] = deque(maxlen=SHOWN_LINES)

    async def prepare(self) -> None:
        """Start the process of the next command."""
        if self._next is None or self._next.returncode is not None:
            line = [
                sys.executable,
                "-P",
                "-m",
                "tirefmu.applications.studio.worker",
            ]  # -P: no module of the current folder
            self._next = await asyncio.create_subprocess_exec(
                *line,
                stdin=PIPE,
                stdout=DEVNULL,
                stderr=PIPE,
                limit=LONGEST_LINE,
                start_new_session=True,
            )

    async def start(self, title: str, arguments: Sequence[str], tire_file: Path) -> None:
        """Run a command line of tirefmu; a fit writes its tire to a file while it runs.

        Raises `TirefmuError` if another one runs.
        """
        if self.running:
            raise TirefmuError(f"{self.title} is running: stop it, or wait for its end")
        self.title, self._stopped, self.running = title, False, True
        self.lines.clear()
        await self.prepare()
        self._process, self._next = self._next, None
        assert self._process is not None
        self._task = asyncio.create_task(self._run(self._process, [list(arguments), str(tire_file)]))

    async def stop(self) -> None:
        """End the running command."""
        process = self._process
        if process is None or process.returncode is not None:
            return
        self._stopped = True
        _signal(process, signal.SIGTERM)
        with suppress(TimeoutError):
            await asyncio.wait_for(process.wait(), GRACE)
        _signal(process, FORCED)  # also what ignores the request, and processes that it has started

    async def close(self) -> None:
        """End all processes."""
        await self.stop()
        if self._task is not None:
            await asyncio.wait([self._task])
        if self._next is not None and self._next.returncode is None:
            self._next.kill()
            await self._next.wait()

    async def _run(self, process: Process, message: list[Any]) -> None:
        assert process.stdin is not None
        assert process.stderr is not None
        process.stdin.write(json.dumps(message).encode() + b"\n")
        last = ""
        async for line in process.stderr:
            last = excerpt(line.decode("utf-8", "replace").rstrip())
            self.lines.append(last)
            await self._report({"event": "line", "line": last})
        status = await process.wait()
        self._process, self.running = None, False
        await self.prepare()
        error = last.removeprefix(ERROR) if status not in (0, 1) else ""
        text = "stopped" if self._stopped else error or ("" if status in (0, 1) else f"ended with {status}")
        await self._report({"event": "ended", "title": self.title, "status": status, "message": text})


def _signal(process: Process, number: int) -> None:
    """Send a signal to a process and those that it has started; to it alone where there are no groups."""
    with suppress(ProcessLookupError):
        if hasattr(os, "killpg"):
            os.killpg(process.pid, number)
        else:
            process.send_signal(number)
