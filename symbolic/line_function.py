"""A function whose results are lines of a chapter: arguments and results are quantities."""

from __future__ import annotations

from dataclasses import dataclass

from .declarations import Quantity
from .notation import Chapter, Equation


@dataclass(frozen=True)
class LineFunction:
    """A function with several results, which are lines of the chapter.

    >>> from tirefmu.symbolic.wheel.kinematics import FUNCTIONS
    >>> [result.name for result in FUNCTIONS[0].results][:5]
    ['V_x', 'V_y', 'wheel_speed', 'psi_dot', 'gamma']
    """

    name: str
    summary: str
    chapter: Chapter
    arguments: tuple[Quantity, ...]
    results: tuple[Quantity, ...]

    @property
    def lines(self) -> tuple[Equation, ...]:
        """The lines that the results need, in their order."""
        given = {argument.name for argument in self.arguments}
        needed = {result.name for result in self.results}
        lines: list[Equation] = []
        for line in reversed(self.chapter.equations):
            if line.symbol.name in needed - given:
                needed |= {symbol.name for symbol in line.expression.free_symbols}
                lines.append(line)
        return tuple(reversed(lines))
