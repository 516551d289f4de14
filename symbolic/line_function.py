"""A function whose results are lines of a chapter."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

from .declarations import Quantity
from .notation import Chapter, Equation


@dataclass(frozen=True)
class LineFunction:
    """A function of real numbers, with one or several results.

    - `arguments`, `results`: their names; results are lines of the chapter.

    >>> from tirefmu.symbolic.wheel.kinematics import FUNCTIONS
    >>> FUNCTIONS[0].results[:5]
    ('V_x', 'V_y', 'wheel_speed', 'psi_dot', 'gamma')
    """

    name: str
    summary: str
    chapter: Chapter
    arguments: tuple[str, ...]
    results: tuple[str, ...]

    @property
    def lines(self) -> tuple[Equation, ...]:
        """The lines that the results need, in their order."""
        given, needed = set(self.arguments), set(self.results)
        lines: list[Equation] = []
        for line in reversed(self.chapter.equations):
            if line.symbol.name in needed - given:
                needed |= line.reads
                lines.append(line)
        return tuple(reversed(lines))


def names(quantities: Iterable[Quantity]) -> tuple[str, ...]:
    """Return the names of quantities, as the arguments or the results of a function."""
    return tuple(quantity.name for quantity in quantities)
