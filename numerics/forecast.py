"""How long a computation will still take: the work that remains, at the pace of the work that is done."""

from __future__ import annotations

from collections.abc import Sequence


class Forecast:
    """The time left of stages whose work is known in advance, in any unit.

    `stages`: name and work of each stage, in their order. A stage may be skipped.

    >>> forecast = Forecast([("Fx", 10.0), ("Fy", 20.0), ("all", 60.0)])
    >>> forecast.begin("Fx")
    >>> forecast.left(1.0) is None  # no stage has ended: the pace is unknown
    True
    >>> forecast.end(2.0)
    >>> forecast.place, forecast.left()
    ('stage 1 of 3', 16.0)
    >>> forecast.begin("Fy")
    >>> forecast.left(1.0)
    15.0
    """

    def __init__(self, stages: Sequence[tuple[str, float]]) -> None:
        self._stages = tuple(stages)
        self._at, self._running = -1, False
        self._done, self._seconds = 0.0, 0.0

    @property
    def place(self) -> str:
        """The number of the current or latest stage."""
        return f"stage {self._at + 1} of {len(self._stages)}" if self._at >= 0 else ""

    def begin(self, stage: str) -> None:
        """Begin the next stage with a name; a name that does not follow belongs to the current stage."""
        following = range(self._at + 1, len(self._stages))
        position = next((number for number in following if self._stages[number][0] == stage), None)
        if position is not None:
            self._at, self._running = position, True

    def end(self, seconds: float) -> None:
        """End the current stage, or a part of it, which took so many seconds."""
        if self._at >= 0:
            self._done += self._stages[self._at][1] if self._running else 0.0
            self._seconds += seconds
            self._running = False

    def left(self, running: float = 0.0) -> float | None:
        """Return the seconds left while the current stage has been running for some; None before a stage has ended.

        A stage that takes longer than its work suggests slows down the pace of those that follow.
        """
        if not self._done:
            return None
        current = self._stages[self._at][1] if self._running else 0.0
        later = sum(work for _, work in self._stages[self._at + 1 :])
        pace = max(self._seconds / self._done, (self._seconds + running) / (self._done + current))
        return pace * later + max(pace * current - running, 0.0)


def seconds_left(finished: int, parts: int, seconds: float) -> float:
    """Return the seconds that the other ones of equal parts will take.

    >>> seconds_left(50, 200, 20.0), seconds_left(200, 200, 80.0)
    (60.0, 0.0)
    """
    return seconds * (parts - finished) / finished


def left_text(seconds: float | None) -> str:
    """Return the time left as a text; empty if it is unknown or nothing is left.

    >>> left_text(0.4), left_text(59.6), left_text(600.0), left_text(None), left_text(0.0)
    ('less than 1 s left', 'about 60 s left', 'about 10 min left', '', '')
    """
    if not seconds:
        return ""
    if seconds < 1.0:
        return "less than 1 s left"
    return f"about {seconds:.0f} s left" if seconds < 120.0 else f"about {seconds / 60.0:.0f} min left"
