"""A request to stop a fit: the solver stops at its next iteration and returns the best values so far."""

from __future__ import annotations

import multiprocessing
import signal
import threading
from collections.abc import Callable, Sequence
from types import FrameType, TracebackType
from typing import Any, Self

from ...tires.tire import Tire

#: Called with (stage, iteration, cost).
Progress = Callable[[str, int, float], None]
#: What asks a program to end, beside Ctrl-C, where it exists: a time limit of a shell or of a queue, Ctrl-Break.
ENDING = tuple(getattr(signal, name) for name in ("SIGTERM", "SIGBREAK") if hasattr(signal, name))


class Interruption:
    """Whether a fit is requested to stop, by Ctrl-C, by a request to end the program or by the progress callback.

    In the ``with`` block the first Ctrl-C or SIGTERM only requests a stop; a second one ends the program. Processes
    that a program has started for parts of its work end at once. Exceptions of callbacks
    are lost in compiled solvers. Therefore a `KeyboardInterrupt` of the progress callback also requests a stop, and
    `raise_failure` raises any other exception of the callback after the solver has returned. Outside the main thread,
    and in programs with their own signal handler, only the callback can request a stop.

    `progress`: called with stage, iteration and cost. Its method ``planned``, if it has one, is called before the first
    stage with name and work of each stage, its method ``reached`` after each iteration and stage with the tire so far.

    >>> def cancel(stage, iteration, cost):
    ...     raise KeyboardInterrupt
    >>> with Interruption(cancel) as interruption:
    ...     interruption.report("Fx", 3, 0.1)
    >>> interruption.requested, interruption.where
    (True, "stage 'Fx', iteration 3")
    """

    def __init__(self, progress: Progress | None = None) -> None:
        self._progress = progress
        self._before = dict[int, Any]()
        self._failure: Exception | None = None
        self._latest = ("", 0)
        self.requested = False

    def __enter__(self) -> Self:
        """Replace the default handlers of Ctrl-C and of what asks a program to end."""
        if threading.current_thread() is threading.main_thread():
            defaults: dict[int, Any] = {signal.SIGINT: signal.default_int_handler}
            if multiprocessing.parent_process() is None:
                defaults |= dict.fromkeys(ENDING, signal.SIG_DFL)
            for number, default in defaults.items():
                if signal.getsignal(number) is default:
                    self._before[number] = signal.signal(number, self._request)
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, at: TracebackType | None) -> None:
        """Restore the handlers."""
        self._restore_handlers()

    def _request(self, number: int, frame: FrameType | None) -> None:
        self.requested = True
        self._restore_handlers()

    def _restore_handlers(self) -> None:
        while self._before:
            signal.signal(*self._before.popitem())

    def stop(self) -> bool:
        """Return whether a stop is requested, as solvers ask."""
        return self.requested

    @property
    def where(self) -> str:
        """Stage and iteration of the latest report."""
        stage, iteration = self._latest
        return f"stage {stage!r}, iteration {iteration}" if stage else "before the first stage"

    def after(self, done: int, stages: int) -> str:
        """Return where the fit was stopped after some of its stages; empty if it is complete."""
        return f"{self.where}, {done} of {stages} stages done" if self.requested and done < stages else ""

    def plan(self, work: Callable[[], Sequence[tuple[str, float]]]) -> None:
        """Report the work of the stages that follow, if the callback takes it."""
        planned = getattr(self._progress, "planned", None)
        if planned is not None:
            self._call(planned, work())

    def reached(self, tire: Callable[[], Tire]) -> None:
        """Report the tire of an iteration or a stage, if the callback takes it."""
        reached = getattr(self._progress, "reached", None)
        if reached is not None:
            self._call(reached, tire())

    def report(self, stage: str, iteration: int, cost: float) -> None:
        """Report the progress."""
        self._latest = (stage, iteration)
        self._call(self._progress, stage, iteration, cost)

    def _call(self, callback: Callable[..., None] | None, *arguments: Any) -> None:
        if callback is None or self.requested:
            return
        try:
            callback(*arguments)
        except KeyboardInterrupt:
            self.requested = True
        except Exception as error:  # raised later by `raise_failure`
            self._failure, self.requested = error, True

    def raise_failure(self) -> None:
        """Raise the exception of the progress callback, if there was one."""
        if self._failure is not None:
            raise self._failure
