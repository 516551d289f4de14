"""Notation of the book: equations, chapters, and the terms that depend on effects, options and models.

A chapter is a Python module that reads like the book. ``eq(...)`` files a line and returns its *symbol*, so lines are
never substituted into each other. Everything else (switching effects off, printing, differentiating) is a pass over the
filed lines, see `tirefmu.symbolic.model`.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any

import sympy as sp


class Switch(sp.Function):
    """A term of a line that belongs to an effect: ``Switch(effect, on, off)``. It is removed before printing."""

    nargs = 3


class Choice(sp.Function):
    """A term of a line that depends on an option: ``Choice(option, first, second)``."""

    nargs = 3


class Variant(sp.Function):
    """A term in which the models that share a line differ: ``Variant(model, its own, the others')``."""

    nargs = 3


def only(model: str, special: Any, others: Any) -> sp.Expr:
    """Return a term that is `special` in one model and `others` in the others that share the line.

    >>> only("mf52", sp.Symbol("PHY3"), 0)
    Variant(mf52, PHY3, 0)
    """
    return Variant(sp.Symbol(model), sp.sympify(special), sp.sympify(others))


@dataclass(frozen=True)
class Equation:
    """One line of the book.

    - `number`: number in the book, or the name of the source that has the line.
    - `symbol`: what the line defines.
    - `expression`: its right-hand side in coefficients, inputs and earlier symbols.
    - `named`: false for a step inside another line that users need not see.
    - `acts_for`: the named quantity whose added effects change this line too; see
      `tirefmu.symbolic.model.Model.extended`.
    - `variant`: true for a repetition of the line without inclination, which added effects change as without it.
    """

    number: str
    symbol: sp.Symbol
    expression: sp.Expr
    unit: str
    description: str
    chapter: str
    named: bool = True
    acts_for: str = ""
    variant: bool = False

    @cached_property
    def reads(self) -> frozenset[str]:
        """The names in the right-hand side."""
        return frozenset(symbol.name for symbol in self.expression.free_symbols)


@dataclass
class Chapter:
    """A chapter of the book: calling it files a line and returns the line's symbol.

    >>> eq = Chapter("Side force")
    >>> eq("4.E20", "alpha_y", sp.Symbol("alpha") + sp.Symbol("S_Hy"), "rad", "shifted slip angle")
    alpha_y
    >>> eq.equations[0].expression
    S_Hy + alpha
    """

    title: str
    equations: list[Equation] = field(default_factory=list)

    def __call__(
        self,
        number: str,
        name: str,
        expression: Any,
        unit: str = "1",
        description: str = "",
        *,
        named: bool = True,
        at: str = "",
        acts_for: str = "",
    ) -> sp.Symbol:
        """File a line and return its symbol; `at` is the suffix of the same line without inclination."""
        symbol = sp.Symbol(f"{name}{at}", real=True)
        filed = Equation(number, symbol, sp.sympify(expression), unit, description, self.title, named)
        self.equations.append(replace(filed, acts_for=acts_for or (name if at else ""), variant=bool(at)))
        return symbol


@dataclass(frozen=True)
class MagicFormula:
    """The Magic Formula over one slip, its cosine form and its slope, sharing the inner steps.

    - `sine`: D sin(C atan(Bx - E (Bx - atan Bx))), Pacejka (2012), eq. (4.1).
    - `cosine`: the same with the cosine, for the pneumatic trail and the weighting functions, eq. (4.59).
    - `slope`: d(sine)/dx with B, C, D and E held constant.
    """

    sine: sp.Expr
    cosine: sp.Expr
    slope: sp.Expr


def magic(eq: Chapter, name: str, B: sp.Expr, C: sp.Expr, D: sp.Expr, E: sp.Expr, x: sp.Expr) -> MagicFormula:
    """File the inner steps of the Magic Formula as lines and return its three forms.

    `name`: symbol of the resulting quantity; the steps are called ``<name>_u``, ``_v`` and ``_w``. `B`, `C`, `D`, `E`:
    stiffness, shape, peak and curvature factor. `x`: slip, shifted.

    Source: Pacejka, Tire and Vehicle Dynamics (2012), eq. (4.1); the slope with constant E is the Trento worksheet's
    magic_formula_stiffness.
    """
    u = eq("4.1", f"{name}_u", B * x, description="B x", named=False)
    v = eq("4.1", f"{name}_v", u - E * (u - sp.atan(u)), description="B x bent by E", named=False)
    w = eq("4.1", f"{name}_w", C * sp.atan(v), "rad", "angle of the Magic Formula", named=False)
    slope = D * C * sp.cos(w) / (1 + v**2) * B * (1 - E + E / (1 + u**2))
    return MagicFormula(D * sp.sin(w), D * sp.cos(w), slope)


#: Half width squared of the smoothed sign, as in the Trento worksheet.
SIGN_SMOOTHING = sp.Float("1e-6")


def smooth_sign(eq: Chapter, name: str, x: sp.Expr) -> sp.Symbol:
    """File the sign of x without its jump, x / sqrt(x^2 + 1e-6), and return its symbol.

    It is the Trento worksheet's Sign; 0 at 0.

    >>> eq = Chapter("Side force")
    >>> smooth_sign(eq, "sign_alpha_y", sp.Symbol("alpha_y"))
    sign_alpha_y
    """
    return eq("Trento", name, x / sp.sqrt(x**2 + SIGN_SMOOTHING), description="smoothed sign", named=False)
