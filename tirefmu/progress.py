"""Progress of a command on standard error: a line that is rewritten on a terminal, otherwise a line for each stage."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from time import monotonic

from rich.console import Console

from tirefmu.symbolic.escaping import visible

#: Shares of a counted computation that have a line where there is no terminal.
REPORTED = (0.25, 0.5, 0.75, 1.0)


class StageLines:
    """Prints each stage when it has ended, with its seconds; nothing of a stage that raises.

    Parameters
    ----------
    write : callable
        Takes a line.
    clock : callable
        Returns seconds.

    Examples
    --------
    >>> seconds = iter([0.0, 1.5, 4.0])
    >>> lines = StageLines(print, lambda: next(seconds))
    >>> lines.begin("Fx")
    >>> lines.begin("Fy")
    Fx: 1.5 s
    >>> lines.end("12 iterations")
    Fy: 12 iterations, 2.5 s
    """

    def __init__(self, write: Callable[[str], None], clock: Callable[[], float] = monotonic) -> None:
        self._write, self._clock = write, clock
        self._stage, self._began = "", 0.0

    def begin(self, stage: str, detail: str = "") -> None:
        """Begin a stage; the one before, with a detail, has ended."""
        now = self._end(detail) if self._stage else self._clock()
        self._stage, self._began = stage, now

    def end(self, detail: str = "") -> None:
        """End the last stage."""
        self._end(detail)
        self._stage = ""

    def _end(self, detail: str) -> float:
        now = self._clock()
        self._write(f"{self._stage}: {f'{detail}, ' if detail else ''}{now - self._began:.1f} s")
        return now


def time_left(finished: int, parts: int, seconds: float) -> str:
    """Return the time that the other parts of a computation will take, as a text.

    Examples
    --------
    >>> time_left(50, 200, 20.0), time_left(100, 200, 600.0), time_left(200, 200, 80.0)
    ('about 60 s left', 'about 10 min left', '80.0 s')
    """
    if finished >= parts:
        return f"{seconds:.1f} s"
    left = seconds * (parts - finished) / finished
    return f"about {left:.0f} s left" if left < 120.0 else f"about {left / 60.0:.0f} min left"


@contextmanager
def showing(console: Console, what: str) -> Iterator[Callable[[str], None]]:
    """Show one activity until it ends; yield what changes the text on a terminal."""
    if console.is_terminal:
        with console.status(visible(what)) as status:
            yield lambda text: status.update(visible(text))
    else:
        lines = StageLines(console.print)
        lines.begin(visible(what))
        yield lambda text: None
        lines.end()


@contextmanager
def counting(console: Console, what: str) -> Iterator[Callable[[int, int], None]]:
    """Show how many parts of a computation are finished, and the time left; yield what reports them."""
    began, passed = monotonic(), 0.0
    with console.status(visible(what)) as status:

        def report(finished: int, parts: int) -> None:
            nonlocal passed
            text = f"{visible(what)}: {finished} of {parts}, {time_left(finished, parts, monotonic() - began)}"
            if console.is_terminal:
                status.update(text)
            reached = max((share for share in REPORTED if finished >= share * parts), default=0.0)
            if not console.is_terminal and reached > passed:
                passed = reached
                console.print(text)

        yield report


@contextmanager
def fitting(console: Console) -> Iterator[Callable[[str, int, float], None]]:
    """Show stage, iteration and cost of a running fit; yield what reports them."""
    with showing_stages(console, "preparing the fit", "evidence and intervals") as report:

        def progress(stage: str, iteration: int, cost: float) -> None:
            report(stage, f"iteration {iteration}, cost {cost:.6g}")

        yield progress


@contextmanager
def showing_stages(console: Console, first: str, last: str) -> Iterator[Callable[[str, str], None]]:
    """Show stages whose names come with reports of their progress; `last` is what follows the latest report."""
    if console.is_terminal:
        with console.status(first) as status:
            yield lambda stage, detail: status.update(f"{visible(stage)}: {detail}")
        return
    # Begun and ended by the clock of the reports: what follows the last one is no part of its stage.
    times = [monotonic()]
    lines = StageLines(console.print, lambda: times[-1])
    lines.begin(first)
    latest = [first, ""]

    def report(stage: str, detail: str) -> None:
        times.append(monotonic())
        if stage != latest[0]:
            lines.begin(visible(stage), latest[1])
        latest[:] = [stage, detail]

    yield report
    lines.begin(last, latest[1])
    times.append(monotonic())
    lines.end()
