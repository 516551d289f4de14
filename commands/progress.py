"""Progress of a command on standard error: a line that is rewritten on a terminal, otherwise a line for each stage."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from contextvars import ContextVar
from time import monotonic
from typing import TYPE_CHECKING

from rich.console import Console

from ..boundary.escaping import visible
from ..numerics.forecast import Forecast, left_text, seconds_left

if TYPE_CHECKING:
    from ..tires import Tire

#: Shares of a counted computation that have a line where there is no terminal.
REPORTED = (0.25, 0.5, 0.75, 1.0)
#: What a fit does before its first stage and after its last one.
PREPARING, EVIDENCE = "preparing the fit", "evidence and intervals"
#: Takes the tire after each iteration and stage of a fit: set by a program that draws it while the fit runs.
follower: ContextVar[Callable[[Tire], None] | None] = ContextVar("follower", default=None)


class Stages:
    """Shows stages of a computation, their number and the time left, if their work is known.

    `ended`: takes a line for a stage that has ended; nothing of a stage that raises. `update`: takes the text of the
    present activity. `found`: takes a line about something that was found within a stage. `clock`: returns seconds.

    >>> seconds = iter([0.0, 1.5, 4.0])
    >>> stages = Stages(print, lambda text: None, print, lambda: next(seconds))
    >>> stages.plan([("Fx", 1.0), ("Fy", 2.0)])
    >>> stages.begin("Fx")
    >>> stages.begin("Fy")
    Fx: 1.5 s; stage 1 of 2, about 3 s left
    >>> stages.end("12 iterations")
    Fy: 12 iterations, 2.5 s; stage 2 of 2
    """

    def __init__(
        self,
        ended: Callable[[str], None],
        update: Callable[[str], None],
        on_change: Callable[[str], None],
        clock: Callable[[], float] = monotonic,
    ) -> None:
        self._ended, self._update, self._found, self._clock = ended, update, on_change, clock
        self._forecast = Forecast(())
        self._stage, self._detail = "", ""
        self._began = self._latest = 0.0

    def plan(self, stages: Sequence[tuple[str, float]]) -> None:
        """Announce the names and the work of the stages that follow."""
        self._forecast = Forecast(stages)

    def begin(self, stage: str, *, since_latest: bool = False) -> None:
        """Begin a stage; the one before has ended, now or with its latest report."""
        now = self._latest if since_latest else self._clock()
        if self._stage:
            self._end(now)
        self._forecast.begin(stage)
        self._stage, self._detail, self._began, self._latest = stage, "", now, now
        self._show(now)

    def report(self, detail: str) -> None:
        """Report a detail of the stage."""
        self._detail, self._latest = detail, self._clock()
        self._show(self._latest)

    def end(self, detail: str = "") -> None:
        """End the last stage."""
        self._detail = detail or self._detail
        self._end(self._clock())
        self._stage = ""

    def event(self, sentence: str) -> None:
        """Report something that was found within the stage."""
        self._found(f"{visible(self._stage)}: {visible(sentence)}")

    def _end(self, now: float) -> None:
        self._forecast.end(now - self._began)
        detail = f"{self._detail}, " if self._detail else ""
        self._ended(f"{visible(self._stage)}: {detail}{now - self._began:.1f} s{self._remaining('; ', 0.0)}")

    def _show(self, now: float) -> None:
        detail = f": {self._detail}" if self._detail else ""
        self._update(f"{visible(self._stage)}{detail}{self._remaining(', ', now - self._began)}")

    def _remaining(self, separator: str, running: float) -> str:
        parts = [text for text in (self._forecast.place, left_text(self._forecast.left(running))) if text]
        return separator + ", ".join(parts) if parts else ""


@contextmanager
def showing_stages(console: Console, stages: Sequence[tuple[str, float]] = ()) -> Iterator[Stages]:
    """Show stages until the last one has ended; `stages` has the names and the work of those that are known."""
    if console.is_terminal:
        with console.status("") as status:
            # Lines of stages that have ended are for logs; on a terminal only what was found remains.
            shown = Stages(lambda line: None, status.update, console.print)
            shown.plan(stages)
            yield shown
        return
    shown = Stages(console.print, lambda text: None, console.print)
    shown.plan(stages)
    yield shown
    shown.end()


@contextmanager
def showing(console: Console, what: str) -> Iterator[None]:
    """Show one activity until it ends."""
    with showing_stages(console) as stages:
        stages.begin(what)
        yield


class FitProgress:
    """What a fit reports its stages to: `fit` calls it, and first `planned`."""

    def __init__(self, stages: Stages) -> None:
        self._stages, self._stage = stages, ""
        stages.begin(PREPARING)

    def planned(self, work: Sequence[tuple[str, float]]) -> None:
        """Announce the work of the stages; that of the evidence is similar to that of the last stage."""
        self._stages.plan([*work, *((EVIDENCE, last) for _, last in work[-1:])])

    def reached(self, tire: Tire) -> None:
        """Pass the tire of an iteration or a stage to who follows the fit."""
        follow = follower.get()
        if follow is not None:
            follow(tire)

    def __call__(self, stage: str, iteration: int, cost: float) -> None:
        """Report an iteration of a stage."""
        if stage != self._stage:
            self._stage = stage
            self._stages.begin(stage)
        self._stages.report(f"iteration {iteration}, cost {cost:.4g}")

    def finish(self) -> None:
        """Begin what follows the last stage, since its latest report."""
        self._stages.begin(EVIDENCE, since_latest=True)


@contextmanager
def fitting(console: Console) -> Iterator[FitProgress]:
    """Show stage, iteration and cost of a running fit, and the time left."""
    with showing_stages(console) as stages:
        progress = FitProgress(stages)
        yield progress
        progress.finish()


@contextmanager
def counting(
    console: Console, what: str, *, singly: bool = False, expected: tuple[int, float] | None = None
) -> Iterator[Callable[[int, int], None]]:
    """Show how many parts of a computation are finished, and the time left; yield what reports them.

    `singly`: each part is reported: parts that are finished before the first report belong to an earlier run.
    `expected`: number of parts and seconds of all of them, if they are known in advance.
    """
    began, passed, kept = monotonic(), 0.0, -1
    with console.status(visible(what)) as status:

        def show(text: str, line: bool) -> None:
            if console.is_terminal:
                status.update(text)
            elif line:
                console.print(text)

        def report(finished: int, parts: int) -> None:
            nonlocal passed, kept
            kept = (finished - 1 if singly else 0) if kept < 0 else kept
            seconds = monotonic() - began
            left = left_text(seconds_left(finished - kept, parts - kept, seconds)) or f"{seconds:.1f} s"
            reached = max((share for share in REPORTED if finished >= share * parts), default=0.0)
            show(f"{visible(what)}: {finished} of {parts}, {left}", reached > passed)
            passed = max(passed, reached)

        if expected is not None:
            show(f"{visible(what)}: 0 of {expected[0]}, {left_text(expected[1])}", line=True)
        yield report
