"""Functions of the lines that SymPy lacks or differentiates otherwise: signs, magnitude, a choice by condition."""

from __future__ import annotations

from typing import Any

import sympy as sp


class sgn(sp.Function):
    """The sign of x, 0 at 0; its derivative is 0 everywhere.

    >>> sgn(sp.Integer(0)), sgn(sp.Symbol("V")).diff(sp.Symbol("V"))
    (0, 0)
    """

    nargs = 1
    is_real = True

    @classmethod
    def eval(cls, x: Any) -> Any:
        """Return the sign of a number; leave a symbol alone."""
        return sp.sign(x) if x.is_Number else None

    def fdiff(self, argindex: int = 1) -> sp.Expr:
        """Return 0."""
        return sp.Integer(0)


class sgn1(sgn):
    """The sign of x, +1 at 0; its derivative is 0 everywhere.

    >>> sgn1(sp.Integer(0)), sgn1(sp.Integer(-2))
    (1, -1)
    """

    @classmethod
    def eval(cls, x: Any) -> Any:
        """Return the sign of a number; leave a symbol alone."""
        return (sp.Integer(1) if x >= 0 else sp.Integer(-1)) if x.is_Number else None


class absolute(sp.Function):
    """The magnitude of x; its derivative is `sgn`, 0 at 0.

    >>> absolute(sp.Symbol("gamma")).diff(sp.Symbol("gamma"))
    sgn(gamma)
    """

    nargs = 1
    is_real = True

    @classmethod
    def eval(cls, x: Any) -> Any:
        """Return the magnitude of a number; leave a symbol unchanged."""
        return sp.Abs(x) if x.is_Number else None

    def fdiff(self, argindex: int = 1) -> sp.Expr:
        """Return the sign."""
        return sgn(self.args[0])


class expm1(sp.Function):
    """e^x - 1, exact for small x.

    >>> expm1(sp.Integer(0)), expm1(sp.Symbol("x")).diff(sp.Symbol("x"))
    (0, exp(x))
    """

    nargs = 1
    is_real = True

    @classmethod
    def eval(cls, x: Any) -> Any:
        """Return 0 at 0; leave everything else unchanged."""
        return sp.Integer(0) if x.is_zero else None

    def fdiff(self, argindex: int = 1) -> sp.Expr:
        """Return e^x."""
        return sp.exp(self.args[0])


def where(condition: Any, then: Any, otherwise: Any) -> sp.Expr:
    """Return `then` where the condition holds, `otherwise` elsewhere (also where something is NaN).

    >>> where(sp.Symbol("Fz") < 0, 0, sp.Symbol("Fz"))
    Piecewise((0, Fz < 0), (Fz, True))
    """
    return sp.Piecewise((then, condition), (otherwise, True))
