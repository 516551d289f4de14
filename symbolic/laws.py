"""The laws by which states change over a step, each declared once and printed for NumPy, C and CasADi.

A state x follows a target u at a rate r, x' = r (u - x), or adds up a flow, x' = g, or follows a path without regard to
time. A law is the exact solution over a step if the target and the rate are as stated, whatever the size of the step.
`tirefmu.symbolic.printers.laws` prints a law as a function of its arguments.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import sympy as sp

from .functions import absolute, expm1, sgn, where
from .notation import Chapter

#: Below this size a path has no direction.
NO_PATH = sp.Float("1e-300")


@dataclass(frozen=True)
class Law:
    """A function of real numbers: lines, and the symbol of its result.

    Attributes
    ----------
    name, summary : str
    arguments : tuple of str
    lines : Chapter
        Each line uses arguments and earlier lines.
    result : sympy.Expr

    Examples
    --------
    >>> law = LAWS["lag"]
    >>> law.arguments
    ('x', 'u', 'u_end', 'way')
    """

    name: str
    summary: str
    arguments: tuple[str, ...]
    lines: Chapter
    result: sp.Expr


def _law(define: Callable[..., sp.Expr]) -> Law:
    """Return the law of a function that files its lines in the chapter that is its first argument."""
    arguments = define.__code__.co_varnames[1 : define.__code__.co_argcount]
    lines = Chapter(define.__name__)
    result = define(lines, *sp.symbols(arguments, real=True))
    return Law(define.__name__, " ".join((define.__doc__ or "").split()), arguments, lines, result)


def _share(eq: Chapter, name: str, way: sp.Expr) -> sp.Expr:
    """Return (1 - e^-way)/way, 1 at 0."""
    safe = eq("law", f"{name}_way", where(way > 0, way, 1), named=False)
    return eq("law", f"{name}_share", where(way > 0, -expm1(-safe) / safe, 1), named=False)


def _series(way: sp.Expr, first: int) -> sp.Expr:
    """Return w/n (1 - w/(n + 1) (1 - w/(n + 2) (...))), six terms."""
    series: sp.Expr = sp.Integer(1)
    for n in reversed(range(first + 1, first + 6)):
        series = 1 - way / n * series
    return way / first * series


def lag(eq: Chapter, x: sp.Expr, u: sp.Expr, u_end: sp.Expr, way: sp.Expr) -> sp.Expr:
    """Lag x' = r (u - x) with a target that is linear from u to u_end; way is the integral of r, also infinite."""
    decay = eq("law", "decay", sp.exp(-way), named=False)
    share = _share(eq, "lag", way)
    return decay * x + ((u_end - u) * (1 - share) - u * expm1(-way))


def lag_curved(eq: Chapter, x: sp.Expr, u: sp.Expr, u_half: sp.Expr, u_end: sp.Expr, way: sp.Expr) -> sp.Expr:
    """Lag x' = r (u - x) with a target on the parabola through u, u_half and u_end; way is r times the step."""
    slope = eq("law", "slope", 4 * u_half - 3 * u - u_end, named=False)
    bend = eq("law", "bend", 2 * (u - 2 * u_half + u_end), named=False)
    share = _share(eq, "lag", way)
    # The moments of r e^{-r (1 - s)} over the step; a difference of nearly equal numbers is replaced by its series.
    small = eq("law", "small", where(way < sp.Rational(1, 20), way, 0), named=False)
    series1 = _series(small, 2)
    series2 = _series(small, 3)
    large = eq("law", "large", where(way < sp.Rational(1, 20), 1, way), named=False)
    first = eq("law", "first", where(way < sp.Rational(1, 20), series1, 1 - share), named=False)
    second = eq("law", "second", where(way < sp.Rational(1, 20), series2, 1 - 2 * first / large), named=False)
    return sp.exp(-way) * x - u * expm1(-way) + slope * first + bend * second


def sum_curved(eq: Chapter, x: sp.Expr, g: sp.Expr, g_half: sp.Expr, g_end: sp.Expr, h: sp.Expr) -> sp.Expr:
    """Sum x' = g with a flow on the parabola through g, g_half and g_end over a step h."""
    return x + h * (g + 4 * g_half + g_end) / 6


def sum_linear(eq: Chapter, x: sp.Expr, g: sp.Expr, g_end: sp.Expr, h: sp.Expr) -> sp.Expr:
    """Sum x' = g with a flow that is linear from g to g_end over a step h."""
    return x + h * (g + g_end) / 2


def dahl(eq: Chapter, z: sp.Expr, s: sp.Expr, s_end: sp.Expr, width: sp.Expr) -> sp.Expr:
    """Dahl's law dz = (sgn(ds) - z) |ds| / width along a path that goes from s to s_end without turning back."""
    way = eq("law", "way", (s_end - s) / width, named=False)
    return sgn(way) + (z - sgn(way)) * sp.exp(-absolute(way))


def dahl_size(
    eq: Chapter, z: sp.Expr, a: sp.Expr, b: sp.Expr, a_end: sp.Expr, b_end: sp.Expr, width: sp.Expr
) -> sp.Expr:
    """Dahl's law for s = sqrt(a^2 + b^2) along the straight path from (a, b) to (a_end, b_end).

    The size falls to the point of the path that is nearest to zero and grows from there on: two parts without a turn.
    """
    da, db = (eq("law", f"d{n}", end - n, named=False) for n, end in ((a, a_end), (b, b_end)))
    squared = eq("law", "squared", da**2 + db**2, named=False)
    path = eq("law", "path", where(squared > NO_PATH, squared, 1), named=False)
    point = eq("law", "point", -(a * da + b * db) / path, named=False)
    part = eq("law", "part", where(point < 0, 0, where(point > 1, 1, point)), named=False)
    least = eq("law", "least", sp.sqrt((a + part * da) ** 2 + (b + part * db) ** 2), named=False)
    fall = eq("law", "fall", (least - sp.sqrt(a**2 + b**2)) / width, named=False)
    rise = eq("law", "rise", (sp.sqrt(a_end**2 + b_end**2) - least) / width, named=False)
    fallen = eq("law", "fallen", where(fall < 0, (z + 1) * sp.exp(fall) - 1, z), named=False)
    return where(rise > 0, 1 + (fallen - 1) * sp.exp(-rise), fallen)


#: Every law by name.
LAWS: dict[str, Law] = {
    each.__name__: _law(each) for each in (lag, lag_curved, sum_linear, sum_curved, dahl, dahl_size)
}
