"""The time of a comparison: its limit, requests to stop, and what it reports meanwhile."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from ...fitting.solvers.interruption import Interruption

#: Share of the time limit within which explanations are compared; final fits, FMUs and the page need the rest.
#: Convention.
COMPARING_SHARE = 0.7


@dataclass(eq=False)
class Budget:
    """When a comparison ends although explanations remain: at a time limit, by Ctrl-C or by the progress callback.

    In the ``with`` block the first Ctrl-C requests the end, a second one ends the program.

    - `progress`: called with a sentence; a `KeyboardInterrupt` of it requests the end.
    - `seconds`: time limit of the whole diagnosis, s; none for None.

    >>> with Budget(print, None) as budget:
    ...     budget.report("adding an effect")
    adding an effect
    >>> budget.ended
    ''
    """

    progress: Callable[[str], None]
    seconds: float | None
    _began: float = field(default_factory=time.monotonic)
    _interruption: Interruption = field(init=False)

    def __post_init__(self) -> None:
        from ...fitting.solvers.interruption import Interruption  # imports CasADi: a diagnosis starts without

        self._interruption = Interruption(lambda sentence, *_: self.progress(sentence))

    def __enter__(self) -> Budget:
        self._interruption.__enter__()
        return self

    def __exit__(self, *error: Any) -> None:
        self._interruption.__exit__(*error)

    def report(self, sentence: str) -> None:
        """Report a sentence, and the time that is left at most."""
        left = "" if self.seconds is None else f"; ends in at most {max(self._left, 0.0):.0f} s"
        self._interruption.report(f"{sentence}{left}", 0, 0.0)
        self._interruption.raise_failure()

    @property
    def _left(self) -> float:
        return COMPARING_SHARE * (self.seconds or 0.0) - (time.monotonic() - self._began)

    @property
    def ended(self) -> str:
        """Why the comparison has to end; empty while it goes on."""
        if self._interruption.requested:
            return "stopped on request"
        return f"stopped by the time limit of {self.seconds:g} s" if self.seconds and self._left <= 0.0 else ""
