"""How functions are laid out as text: statements with remarks, indentation, templates."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from textwrap import wrap
from typing import Protocol

from ..routines import Routine

#: Characters of a line of comments.
WIDTH = 110


class Printer(Protocol):
    """What writes an expression."""

    def doprint(self, expr: object) -> str:
        """Return the text of an expression."""


@dataclass(frozen=True)
class Layout:
    """How a language writes statements and comments.

    Attributes
    ----------
    printer : Printer
    statement : str
        Definition of a local variable: ``{name}`` and ``{value}``.
    comment : str
        A comment up to the end of the line: ``{}``.
    escape : callable
        Makes any text harmless in such a comment.
    indent : str
    """

    printer: Printer
    statement: str
    comment: str
    escape: Callable[[str], str]
    indent: str = "    "

    def remark(self, text: str) -> str:
        """Return a comment."""
        return self.comment.format(self.escape(text))

    def head(self, lines: Iterable[str]) -> str:
        """Return a block of comments."""
        parts = [part for line in lines for part in wrap(self.escape(line), WIDTH, subsequent_indent="    ")]
        return "\n".join(self.comment.format(part) for part in parts)

    def statements(self, routine: Routine, depth: int = 1) -> str:
        """Return the statements of a routine: chapter by chapter, each with its number and meaning."""
        lines = []
        for assignment in routine.body:
            if assignment.heading:
                lines += ["", self.remark(assignment.heading)]
            value = self.printer.doprint(assignment.expression)
            text = self.statement.format(name=assignment.symbol, value=value)
            lines.append(f"{text}  {self.remark(assignment.remark)}" if assignment.remark else text)
        return self.indented(lines, depth)

    def values(self, routine: Routine) -> list[str]:
        """Return the results of a routine as expressions, row by row of a matrix."""
        return [self.printer.doprint(value) for row in routine.results for value in row]

    def indented(self, lines: Iterable[str], depth: int = 1) -> str:
        """Return lines as a text, indented."""
        text = "\n".join(lines).strip("\n")
        return "\n".join(self.indent * depth + line if line else "" for line in text.split("\n"))


def filled(template: str, values: Mapping[str, object]) -> str:
    """Return a template with ``@name@`` replaced; code is full of braces and dollar signs.

    Examples
    --------
    >>> filled("struct @name@ {};", {"name": "tire"})
    'struct tire {};'
    """
    return re.sub("@([a-z_]+)@", lambda found: str(values[found[1]]), template)


def wrapped(items: Sequence[str], width: int = 100) -> list[str]:
    """Return items as lines of limited width, each but the last ending with a comma.

    Examples
    --------
    >>> wrapped(["kappa", "alpha", "gamma"], width=14)
    ['kappa, alpha, ', 'gamma']
    """
    lines = [""]
    for i, item in enumerate(items):
        text = item + (", " if i < len(items) - 1 else "")
        if lines[-1] and len(lines[-1]) + len(text) > width:
            lines.append("")
        lines[-1] += text
    return lines
