"""An effect that is added to the equations of a model: what its file declares."""

from __future__ import annotations

from dataclasses import dataclass

import sympy as sp

from ..detection import Detection
from ..notation import Coefficient


@dataclass(frozen=True)
class Act:
    """Change of one named quantity, given by name or role, by an added effect: ``how`` is "factor" or "term"."""

    on: str
    how: str
    expression: sp.Expr


@dataclass(frozen=True)
class AddedEffect:
    """An effect that is added to the equations of a model.

    Attributes
    ----------
    name, physics, source : str
    declarations : tuple of Coefficient
        Its coefficients; at neutral values the effect vanishes.
    acts : tuple of Act
    detection : Detection or None
        How a diagnosis detects it, if the file declares that.
    """

    name: str
    physics: str
    source: str
    declarations: tuple[Coefficient, ...]
    acts: tuple[Act, ...]
    detection: Detection | None = None

    @property
    def acts_on(self) -> tuple[str, ...]:
        """The named quantities that it changes, by name or by role."""
        return tuple(dict.fromkeys(act.on for act in self.acts))

    @property
    def section(self) -> str:
        """The .tir section of its coefficients."""
        return f"TIREFMU_{self.name.upper()}"
