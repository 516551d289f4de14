"""A finding about recordings: one line for a reader, and its parts for a program."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass


@dataclass(frozen=True)
class DataFinding:
    """What a recording lacks or contradicts.

    Parameters
    ----------
    kind : str
        Name of the test: "missing slip", "two tires", "repeated rows", ...
    text : str
        One sentence with the recording and the numbers.
    serious : bool
        Whether a result of these data is misleading if nothing is done about it.
    command : str
        The command or option that investigates or corrects it; empty if there is none.
    effects : tuple of str
        Effects that a diagnosis can test as its cause.

    Examples
    --------
    >>> print(DataFinding("repeated rows", "a.csv: 5 of 90 rows occur twice", command='--where "sample <= 85"'))
    a.csv: 5 of 90 rows occur twice (--where "sample <= 85")
    """

    kind: str
    text: str
    serious: bool = False
    command: str = ""
    effects: tuple[str, ...] = ()

    def __str__(self) -> str:
        """Return text and command in one line."""
        return f"{self.text} ({self.command})" if self.command else self.text


def verdict_on(findings: Sequence[DataFinding]) -> str:
    """Return what findings mean for a fit, in one line, such as "ready for a fit, with 1 note"."""
    if any(finding.serious for finding in findings):
        return "a fit of these data would be misleading"
    return "ready for a fit" + (f", with {len(findings)} note{'s'[: len(findings) != 1]}" if findings else "")
