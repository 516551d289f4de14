"""The time of a comparison: its limit, requests to stop, and what it reports meanwhile."""

from __future__ import annotations

import time
from collections.abc import Callable

from ...fitting.solvers.interruption import Interruption


class Ended(Exception):
    """The time of a comparison is over."""


#: Shares of the time limit at whose end explanations are no longer compared, and final fits end; FMUs and the page need
#: the rest. Conventions.
COMPARING_SHARE, FITTING_SHARE = 0.6, 0.85


class Budget(Interruption):
    """When a comparison ends although explanations remain: at a time limit, by Ctrl-C or by the progress callback.

    - `progress`: called with a sentence; a `KeyboardInterrupt` of it requests the end.
    - `seconds`: time limit of the whole diagnosis, s; none for None.
    - `answered`: whether there is an answer: `check` raises nothing before.

    >>> with Budget(print, None) as budget:
    ...     budget.tell("adding an effect")
    adding an effect
    >>> budget.ended
    ''
    """

    def __init__(self, progress: Callable[[str], None], seconds: float | None) -> None:
        super().__init__(lambda sentence, *_: progress(sentence))
        self.seconds, self.answered, self._began = seconds, False, time.monotonic()

    def tell(self, sentence: str) -> None:
        """Report a sentence."""
        self.report(sentence, 0, 0.0)
        self.raise_failure()

    def check(self) -> None:
        """Raise `Ended` if the comparison has to end and has an answer: called before each part of the work."""
        if self.answered and self.ended:
            raise Ended

    @property
    def ended(self) -> str:
        """Why the comparison has to end; empty while it goes on."""
        if self.requested:
            return "stopped on request"
        return f"stopped by the time limit of {self.seconds:g} s" if self._passed(COMPARING_SHARE) else ""

    @property
    def late(self) -> bool:
        """Whether the final fits have to end: what is optional is left out then, fits end after their next step."""
        return self._passed(FITTING_SHARE)

    def _passed(self, share: float) -> bool:
        return bool(self.seconds) and time.monotonic() - self._began > share * (self.seconds or 0.0)
