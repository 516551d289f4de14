"""A model: an ordered table of named lines, and the passes over it."""

from __future__ import annotations

from collections.abc import Collection, Iterable
from dataclasses import dataclass, replace
from functools import cached_property, lru_cache

import sympy as sp

from .effects import EFFECTS
from .errors import UnknownName
from .notation import Chapter, Coefficient, Effect, Equation, Quantity, Section, Switch


@dataclass(frozen=True, eq=False)
class Model:
    """A tire model of the book.

    Attributes
    ----------
    name : str
        As on the command line.
    title : str
    inputs, outputs : tuple of Quantity
    sections : tuple of type[Section]
        The coefficients, by .tir section.
    chapters : tuple of Chapter
        The lines, in an order in which each uses only earlier ones.

    Examples
    --------
    >>> from tirefmu.symbolic import model
    >>> mf96 = model("mf96")
    >>> [quantity.name for quantity in mf96.inputs]
    ['kappa', 'alpha', 'gamma', 'Fz']
    >>> sorted(mf96.owned("camber_thrust"))
    ['PHY3', 'PVY3', 'PVY4']
    """

    name: str
    title: str
    inputs: tuple[Quantity, ...]
    outputs: tuple[Quantity, ...]
    sections: tuple[type[Section], ...]
    chapters: tuple[Chapter, ...]

    @cached_property
    def coefficients(self) -> dict[str, Coefficient]:
        """Every coefficient's card by its .tir name, in the order of the parameter vector."""
        return {name: card for section in self.sections for name, card in section.coefficients.items()}

    @property
    def parameters(self) -> tuple[Coefficient, ...]:
        """The cards in the order of the parameter vector of all generated code."""
        return tuple(self.coefficients.values())

    @cached_property
    def equations(self) -> tuple[Equation, ...]:
        """Every line as written, effects standing in it as switches."""
        return tuple(equation for chapter in self.chapters for equation in chapter.equations)

    @cached_property
    def effects(self) -> dict[str, Effect]:
        """The effects that stand in the lines, in the order of their first place."""
        names = (str(switch.args[0]) for line in self.equations for switch in _switches(line.expression))
        return {name: EFFECTS[name] for name in dict.fromkeys(names)}

    @cached_property
    def core(self) -> frozenset[str]:
        """Coefficients that the model cannot do without."""
        return frozenset(name for name, card in self.coefficients.items() if card.neutral is None)

    def lines(self, effects: Collection[str] | None = None) -> tuple[Equation, ...]:
        """Return the lines with effects switched.

        Parameters
        ----------
        effects : collection of str, optional
            The effects that the tire has; all of the model where None.

        Returns
        -------
        tuple of Equation
            No switch is left in them.

        Raises
        ------
        UnknownName
            If an effect is not one of this model.
        """
        present = self.effects.keys() if effects is None else self.known_effects(effects)
        lines: list[Equation] = []
        constants: dict[sp.Symbol, sp.Expr] = {}  # a line that is 0 or 1 now makes later terms vanish
        for line in self.equations:
            expression = _switched(line.expression, present).xreplace(constants)
            if expression.is_Number:
                constants[line.symbol] = expression
            lines.append(replace(line, expression=expression))
        return tuple(lines)

    def known_effects(self, names: Iterable[str]) -> frozenset[str]:
        """Return the names as a set, or raise `UnknownName` for one that this model has not."""
        chosen = frozenset(names)
        for name in sorted(chosen - self.effects.keys()):
            raise UnknownName(f"effect of {self.name}", name, self.effects)
        return chosen

    def live(self, effects: Collection[str] | None = None) -> frozenset[str]:
        """Return the coefficients that reach an output with these effects."""
        outputs = {quantity.name for quantity in self.outputs}
        symbols = {str(s) for line in reaching(self.lines(effects), outputs) for s in line.expression.free_symbols}
        return frozenset(symbols & self.coefficients.keys())

    @lru_cache(maxsize=256)  # noqa: B019  (models live as long as the program)
    def owned(self, *effects: str) -> frozenset[str]:
        """Return the coefficients that reach no output once these effects are off.

        Parameters
        ----------
        *effects : str

        Returns
        -------
        frozenset of str
        """
        return self.live() - self.live(self.effects.keys() - self.known_effects(effects))


def reaching(lines: Iterable[Equation], targets: Collection[str]) -> list[Equation]:
    """Return the lines on which the targets depend, in order.

    Parameters
    ----------
    lines : iterable of Equation
        Each uses only earlier symbols.
    targets : collection of str
        Symbols asked for.

    Returns
    -------
    list of Equation
    """
    needed, kept = set(targets), []
    for line in reversed(list(lines)):
        if line.symbol.name in needed:
            kept.append(line)
            needed |= {symbol.name for symbol in line.expression.free_symbols}
    return kept[::-1]


def _switches(expression: sp.Expr) -> list[sp.Expr]:
    """Every switch of an expression in the order of a walk through it."""
    return [node for node in sp.preorder_traversal(expression) if isinstance(node, Switch)]


def _switched(expression: sp.Expr, present: Collection[str]) -> sp.Expr:
    """Put `on` or `off` in the place of every switch."""
    return expression.replace(Switch, lambda effect, on, off: on if str(effect) in present else off)
