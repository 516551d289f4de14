"""Layout of functions as text: statements with remarks, indentation, templates."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from itertools import chain
from textwrap import wrap
from typing import Protocol

from ..routines import Routine

#: Characters of a line of comments, and of a line of code without its indentation.
WIDTH = 110
#: A line of code ends after a comma or an operator between blanks; in a product if that alone is too long.
_BREAKS, _FACTORS = re.compile(r"(?<=[,+\-?:&|=] )"), re.compile(r"(?<=[^*]\*)(?!\*)")


class Printer(Protocol):
    """What writes an expression."""

    def doprint(self, expr: object) -> str:
        """Return the text of an expression."""


@dataclass(frozen=True)
class Layout:
    """How a language writes statements and comments.

    - `statement`: definition of a local variable: ``{name}`` and ``{value}``.
    - `comment`: a comment up to the end of the line: ``{}``.
    - `escape`: makes any text harmless in such a comment.
    - `continued`: the end of a line whose statement continues on the next one.
    """

    printer: Printer
    statement: str
    comment: str
    escape: Callable[[str], str]
    indent: str = "    "
    continued: str = ""

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
            lines += self.lines(self.statement.format(name=assignment.symbol, value=value), assignment.remark)
        return self.indented(lines, depth)

    def lines(self, code: str, remark: str = "") -> list[str]:
        """Return a statement as one line, or broken into several; a remark that does not fit is above it."""
        after = f"  {self.remark(remark)}" if remark else ""
        if len(code + after) <= WIDTH:
            return [code + after]
        above = self.head([remark]).splitlines()
        if len(code) <= WIDTH:
            return [*above, code]
        width = WIDTH - len(self.indent + self.continued)
        parts = ([part] if len(part) <= width else _FACTORS.split(part) for part in _BREAKS.split(code))
        first, *others = wrapped(list(chain.from_iterable(parts)), width, "")
        broken = [first, *(self.indent + other for other in others)]
        return [*above, *(line.rstrip() + self.continued for line in broken[:-1]), broken[-1]]

    def values(self, routine: Routine) -> list[str]:
        """Return the results of a routine as expressions, row by row of a matrix."""
        return [self.printer.doprint(value) for row in routine.results for value in row]

    def rows(self, routine: Routine, row: str = "{},") -> list[str]:
        """Return the rows of a matrix of results as lines, each row in the brackets of the language."""
        texts = (", ".join(map(self.printer.doprint, values)) for values in routine.results)
        return [line for text in texts for line in self.lines(row.format(text))]

    def indented(self, lines: Iterable[str], depth: int = 1) -> str:
        """Return lines as a text, indented."""
        text = "\n".join(lines).strip("\n")
        return "\n".join(self.indent * depth + line if line else "" for line in text.split("\n"))


def filled(template: str, values: Mapping[str, object]) -> str:
    """Return a template with ``@name@`` replaced; code is full of braces and dollar signs.

    >>> filled("struct @name@ {};", {"name": "tire"})
    'struct tire {};'
    """
    return re.sub("@([a-z_]+)@", lambda found: str(values[found[1]]), template)


def wrapped(items: Sequence[str], width: int = 100, separator: str = ", ") -> list[str]:
    """Return items as lines of limited width, each but the last ending with the separator.

    >>> wrapped(["kappa", "alpha", "gamma"], width=14)
    ['kappa, alpha, ', 'gamma']
    """
    lines = [""]
    for i, item in enumerate(items):
        text = item + (separator if i < len(items) - 1 else "")
        if lines[-1] and len(lines[-1]) + len(text) > width:
            lines.append("")
        lines[-1] += text
    return lines
