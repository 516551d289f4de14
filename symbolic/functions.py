"""Functions of the lines that SymPy lacks or differentiates otherwise: signs, magnitude, root, a choice by condition.

One convention holds at kinks, in every language: the slope of the magnitude and of the root of a square is 0 at 0, as
sgn(0) is. A branch that is not taken is finite too: arithmetic raises no exception in it, and automatic
differentiation, which multiplies its derivative by 0, remains finite.
"""

from __future__ import annotations

from collections.abc import Callable
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


class SmallestSquare(sp.NumberSymbol):
    """The smallest square of a slip that counts; it depends on the type of a printout's numbers.

    The power -5/2, which a second derivative of a root has, is finite in the type, and a sum of squares below it is 0
    beside other slips.

    >>> SMALLEST_SQUARE, float(SMALLEST_SQUARE)
    (SMALLEST_SQUARE, 1e-100)
    """

    is_real = is_positive = True
    is_irrational = False
    is_commutative = True
    #: Its values in double and single precision.
    double, single = 1e-100, 1e-13

    def _as_mpf_val(self, prec: int) -> Any:
        return sp.Float(self.double)._as_mpf_val(prec)

    def __str__(self) -> str:
        return "SMALLEST_SQUARE"

    __repr__ = __str__

    def _latex(self, printer: Any) -> str:
        return r"\varepsilon^2"


SMALLEST_SQUARE = SmallestSquare()


class Divisor(sp.Piecewise):
    """What a branch divides by or takes a root of: 1 where the branch is not taken.

    SymPy would take the power of each of its values in place of the power of the chosen one.
    """

    def _eval_power(self, exponent: Any) -> None:
        return None


def where(condition: Any, then: Any, otherwise: Any) -> sp.Expr:
    """Return `then` where the condition holds, `otherwise` elsewhere (also where something is NaN).

    What a branch divides by or takes a root of is 1 where the branch is not taken, if the condition is about it.

    >>> x = sp.Symbol("x")
    >>> where(x < 0, 0, x)
    Piecewise((0, x < 0), (x, True))
    >>> where(x <= 0, 0, 1 / x)
    Piecewise((0, x <= 0), (1/Divisor((1, x <= 0), (x, True)), True))
    """
    then = _guarded(then, condition, lambda base: Divisor((base, condition), (1, True)))
    otherwise = _guarded(otherwise, condition, lambda base: Divisor((1, condition), (base, True)))
    return sp.Piecewise((then, condition), (otherwise, True))


def _guarded(branch: Any, condition: Any, guard: Callable[[sp.Expr], sp.Expr]) -> sp.Expr:
    """Return a branch with guarded bases of quotients and roots, of those that share a symbol with the condition."""
    branch, read = sp.sympify(branch), condition.free_symbols
    powers = [
        power
        for power in branch.atoms(sp.Pow)
        if power.base.free_symbols & read and not (power.exp.is_Integer and power.exp > 0)
    ]
    return branch.xreplace({power: guard(power.base) ** power.exp for power in powers})


def root(square: Any) -> sp.Expr:
    """Return the square root of a sum of squares: 0 with all derivatives 0 below the smallest square (also below 0).

    >>> root(sp.Symbol("x")).subs("x", 0), root(sp.Symbol("x")).subs("x", 4)
    (0, 2)
    """
    return where(square <= SMALLEST_SQUARE, 0, sp.sqrt(square))
