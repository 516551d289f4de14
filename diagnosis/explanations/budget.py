"""The time of a comparison: its limit, requests to stop, and what it reports meanwhile."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

from ...fitting.solvers.interruption import Interruption


class Ended(Exception):
    """The time of a comparison is over."""


#: Shares of the time limit at whose end explanations are no longer compared, and final fits end; FMUs and the page need
#: the rest. Conventions.
COMPARING_SHARE, FITTING_SHARE = 0.6, 0.85


@dataclass(eq=False)
class Budget:
    """When a comparison ends although explanations remain: at a time limit, by Ctrl-C or by the progress callback.

    In the ``with`` block the first Ctrl-C or SIGTERM requests the end, a second one ends the program.

    - `progress`: called with a sentence; a `KeyboardInterrupt` of it requests the end.
    - `seconds`: time limit of the whole diagnosis, s; none for None.
    - `answered`: whether there is an answer: `check` raises nothing before.

    >>> with Budget(print, None) as budget:
    ...     budget.report("adding an effect")
    adding an effect
    >>> budget.ended
    ''
    """

    progress: Callable[[str], None]
    seconds: float | None
    answered: bool = False
    _began: float = field(default_factory=time.monotonic)
    _interruption: Interruption = field(init=False)

    def __post_init__(self) -> None:
        self._interruption = Interruption(lambda sentence, *_: self.progress(sentence))

    def __enter__(self) -> Budget:
        self._interruption.__enter__()
        return self

    def __exit__(self, *error: Any) -> None:
        self._interruption.__exit__(*error)

    def report(self, sentence: str) -> None:
        """Report a sentence."""
        self._interruption.report(sentence, 0, 0.0)
        self._interruption.raise_failure()

    def check(self) -> None:
        """Raise `Ended` if the comparison has to end and has an answer: called before each part of the work."""
        if self.answered and self.ended:
            raise Ended

    @property
    def ended(self) -> str:
        """Why the comparison has to end; empty while it goes on."""
        if self._interruption.requested:
            return "stopped on request"
        return f"stopped by the time limit of {self.seconds:g} s" if self._passed(COMPARING_SHARE) else ""

    @property
    def late(self) -> bool:
        """Whether the final fits have to end: what is optional is left out then, fits end after their next step."""
        return self._passed(FITTING_SHARE)

    def _passed(self, share: float) -> bool:
        return bool(self.seconds) and time.monotonic() - self._began > share * (self.seconds or 0.0)
