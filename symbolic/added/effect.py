"""An effect that is added to the equations of a model: what its file declares."""

from __future__ import annotations

from collections.abc import Sequence
from copy import copy
from dataclasses import dataclass
from functools import cached_property, partial
from types import new_class
from typing import TYPE_CHECKING

from ...boundary.errors import EffectError
from ..declarations import Coefficient, Section
from ..detection import Detection
from .formula_names import names_in
from .state import State

if TYPE_CHECKING:
    import sympy as sp


@dataclass(frozen=True)
class Act:
    """Change of one named quantity, given by name or role, by an added effect.

    - `how`: "factor" or "term".
    - `text`: the formula as `tirefmu.symbolic.added.formula.formula_text` writes it.

    >>> act = Act("friction_y", "factor", "TMU1*(T - TREF) + 1")
    >>> sorted(act.reads), act.expression
    (['T', 'TMU1', 'TREF'], TMU1*(T - TREF) + 1)
    """

    on: str
    how: str
    text: str

    @cached_property
    def reads(self) -> frozenset[str]:
        """The names that the formula reads."""
        return names_in(self.text)

    @cached_property
    def expression(self) -> sp.Expr:
        """The formula as a SymPy expression."""
        from .formula import formula

        return formula(self.text, f"an effect on {self.on}")


@dataclass(frozen=True)
class AddedEffect:
    """An effect that is added to the equations of a model.

    Attributes
    ----------
    name, physics, source : str
        Public name, physical mechanism, and reference.
    declarations : tuple of Coefficient
        Its coefficients; at neutral values the effect vanishes.
    acts : tuple of Act
        The quantities that it changes.
    detection : Detection or None
        How a diagnosis detects it, if the file declares that.
    states : tuple of State
        Its memory: formulas read a state like an input.
    """

    name: str
    physics: str
    source: str
    declarations: tuple[Coefficient, ...]
    acts: tuple[Act, ...]
    detection: Detection | None = None
    states: tuple[State, ...] = ()

    @property
    def reads(self) -> frozenset[str]:
        """The names that its acts and states read."""
        return frozenset().union(*(act.reads for act in self.acts), *(state.reads for state in self.states))

    @property
    def acts_on(self) -> tuple[str, ...]:
        """The named quantities that it changes, by name or by role."""
        return tuple(dict.fromkeys(act.on for act in self.acts))

    @property
    def section(self) -> str:
        """The .tir section of its coefficients."""
        return f"TIREFMU_{self.name.upper()}"


def sections_of(effects: Sequence[AddedEffect]) -> list[type[Section]]:
    """Return a .tir section for each effect. A shared coefficient is in the section of the first effect."""
    seen: dict[str, Coefficient] = {}
    sections = []
    for effect in effects:
        for declaration in effect.declarations:
            if declaration.name in seen and seen[declaration.name] != declaration:
                raise EffectError(f"{declaration.name} of {effect.name} is another coefficient elsewhere")
        names = {
            declaration.name: copy(declaration) for declaration in effect.declarations if declaration.name not in seen
        }
        seen |= names
        if names:
            keywords = {"title": effect.section}
            sections.append(new_class(effect.name, (Section,), keywords, partial(_filled, names)))
    return sections


def _filled(declarations: dict[str, Coefficient], space: dict[str, object]) -> None:
    """Put declarations into a class body."""
    space.update(declarations)


def owners_of(effects: Sequence[AddedEffect]) -> dict[str, list[tuple[AddedEffect, State]]]:
    """Return the states of effects by name, each with the effects that declare it.

    Raises `EffectError` if two effects declare a state of the same name differently, or if a state has the name of a
    line or an FMU variable of another state.
    """
    owners: dict[str, list[tuple[AddedEffect, State]]] = {}
    for effect in effects:
        for state in effect.states:
            shared = owners.setdefault(state.name, [])
            if shared and shared[0][1] != state:
                raise EffectError(f"state {state.name} of {effect.name} is another one in {shared[0][0].name}")
            shared.append((effect, state))
    taken = {
        line: name
        for name, ((_, state), *_) in owners.items()
        for line in (*state.line_names, state.event_line, f"{name}_velocity", f"{name}_event")
    }
    for name in sorted(owners.keys() & taken.keys()):
        raise EffectError(f"state {name} has the name of a quantity of state {taken[name]}")
    return owners
