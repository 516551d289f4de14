"""The laws of states over a step, each declared once and printed for NumPy, C and CasADi.

A state x follows a target u at a rate r, x' = r (u - x), or adds up a flow, x' = g, or oscillates about a target, or
follows a path independent of time. A law is the exact solution over a step of any size if the target and the rate are
as stated. `tirefmu.symbolic.printers.line_functions` prints a law as a function of its arguments.
"""

from __future__ import annotations

from collections.abc import Callable

import sympy as sp

from .functions import absolute, expm1, sgn, where
from .line_function import LineFunction
from .notation import Chapter

#: Below this size a path has no direction.
NO_PATH = sp.Float("1e-300")
#: The last line of a law.
RESULT = "result"


def _law(define: Callable[..., sp.Expr]) -> LineFunction:
    """Return the law of a function that files its lines in the chapter that is its first argument."""
    arguments = define.__code__.co_varnames[1 : define.__code__.co_argcount]
    lines = Chapter(define.__name__)
    lines("law", RESULT, define(lines, *sp.symbols(arguments, real=True)), named=False)
    return LineFunction(define.__name__, " ".join((define.__doc__ or "").split()), lines, arguments, (RESULT,))


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


def lag_held(eq: Chapter, x: sp.Expr, u: sp.Expr, way: sp.Expr) -> sp.Expr:
    """Lag x' = r (u - x) with a constant target; way is the integral of r, also infinite."""
    gone = eq("law", "gone", -expm1(-way), named=False)
    return (1 - gone) * x + gone * u


def lag_curved(eq: Chapter, x: sp.Expr, u: sp.Expr, u_half: sp.Expr, u_end: sp.Expr, way: sp.Expr) -> sp.Expr:
    """Lag x' = r (u - x) with a target on the parabola through u, u_half and u_end; way is r times the step."""
    slope, bend = _parabola(eq, u, u_half, u_end)
    return sp.exp(-way) * x + _followed(eq, "", u, slope, bend, way)


def _parabola(eq: Chapter, u: sp.Expr, u_half: sp.Expr, u_end: sp.Expr) -> tuple[sp.Expr, sp.Expr]:
    """Return slope and bend of the target u + slope s + bend s^2, where s is the share of the step."""
    slope = eq("law", "slope", 4 * u_half - 3 * u - u_end, named=False)
    return slope, eq("law", "bend", 2 * (u - 2 * u_half + u_end), named=False)


def _followed(eq: Chapter, name: str, u: sp.Expr, slope: sp.Expr, bend: sp.Expr, way: sp.Expr) -> sp.Expr:
    """Return the end of a lag that starts at 0; `name` begins the names of its lines."""
    share = _share(eq, f"{name}lag", way)
    # The moments of r e^{-r (1 - s)} over the step; a difference of nearly equal numbers is replaced by its series.
    small = eq("law", f"{name}small", where(way < sp.Rational(1, 20), way, 0), named=False)
    series1 = _series(small, 2)
    series2 = _series(small, 3)
    large = eq("law", f"{name}large", where(way < sp.Rational(1, 20), 1, way), named=False)
    first = eq("law", f"{name}first", where(way < sp.Rational(1, 20), series1, 1 - share), named=False)
    second = eq("law", f"{name}second", where(way < sp.Rational(1, 20), series2, 1 - 2 * first / large), named=False)
    return slope * first + bend * second - u * expm1(-way)


def sum_curved(eq: Chapter, x: sp.Expr, g: sp.Expr, g_half: sp.Expr, g_end: sp.Expr, h: sp.Expr) -> sp.Expr:
    """Sum x' = g with a flow on the parabola through g, g_half and g_end over a step h."""
    return x + h * (g + 4 * g_half + g_end) / 6


def sum_linear(eq: Chapter, x: sp.Expr, g: sp.Expr, g_end: sp.Expr, h: sp.Expr) -> sp.Expr:
    """Sum x' = g with a flow that is linear from g to g_end over a step h."""
    return x + h * (g + g_end) / 2


# fmt: off
def oscillator(
    eq: Chapter, x: sp.Expr, v: sp.Expr, u: sp.Expr, u_half: sp.Expr, u_end: sp.Expr, way: sp.Expr, loss: sp.Expr,
    h: sp.Expr,
) -> sp.Expr:
    """Oscillator x'' = w^2 (u - x) - d x' with a target on the parabola through u, u_half and u_end over a step h.

    v is x' at the start, way is w h, loss is d h.
    """
    return _oscillation(eq, x, v, u, u_half, u_end, way, loss, h)[0]


def oscillator_speed(
    eq: Chapter, x: sp.Expr, v: sp.Expr, u: sp.Expr, u_half: sp.Expr, u_end: sp.Expr, way: sp.Expr, loss: sp.Expr,
    h: sp.Expr,
) -> sp.Expr:
    """Speed x' at the end of the same step of an oscillator."""
    change = _oscillation(eq, x, v, u, u_half, u_end, way, loss, h)[1]
    step = eq("law", "step", where(h > 0, h, 1), named=False)
    return v + change / step


# fmt: on
#: Up to this way and loss, an oscillation is its Taylor series; above this ratio of loss to way, it is two lags.
SHORT, WIDE, TERMS = sp.Rational(1, 2), sp.Rational(5, 2), 15


def _oscillation(
    eq: Chapter, x: sp.Expr, v: sp.Expr, u: sp.Expr, u_half: sp.Expr, u_end: sp.Expr, way: sp.Expr, loss: sp.Expr,
    h: sp.Expr,
) -> tuple[sp.Expr, sp.Expr]:  # fmt: skip
    """Return the value at the end of a step, and the change of the speed times h.

    With the share s of the step, x'' = way^2 (u(s) - x) - loss x'. Each of three ways to solve this is exact where the
    others subtract nearly equal numbers.
    """
    slope, bend = _parabola(eq, u, u_half, u_end)
    start = eq("law", "start", v * h, named=False)
    short = sp.And(way < SHORT, loss < SHORT)
    wide = loss > WIDE * way
    # Short steps: the Taylor series.
    a = eq("law", "short_way", where(short, way, 0), named=False)
    b = eq("law", "short_loss", where(short, loss, 0), named=False)
    series, target = [x, start], [u, slope, bend]
    for k in range(TERMS - 1):
        force = a**2 * ((target[k] if k < 3 else 0) - series[k]) - b * (k + 1) * series[k + 1]
        series.append(eq("law", f"term{k + 2}", force / ((k + 1) * (k + 2)), named=False))
    near = x + start + sum(reversed(series[2:]), sp.Integer(0))
    near_change = sum((k * series[k] for k in range(TERMS, 1, -1)), sp.Integer(0))
    # The matrix exponential; the shares are those of the slower and the faster exponential, or of the sine.
    square = eq("law", "square_of_difference", (loss / 2 - way) * (loss / 2 + way), named=False)
    aperiodic = square > 0
    above = eq("law", "above", where(aperiodic, square, 0), named=False)
    below = eq("law", "below", where(aperiodic, 0, -square), named=False)
    half, turn = (eq("law", name, sp.sqrt(square), named=False) for name, square in (("half", above), ("turn", below)))
    fast = eq("law", "fast", loss / 2 + half, named=False)
    faster = eq("law", "faster", where(aperiodic, fast, 1), named=False)
    slow = eq("law", "slow", where(aperiodic, way**2 / faster, loss / 2), named=False)
    share = _share(eq, "difference", 2 * half)
    angle = eq("law", "angle", where(turn > 0, turn, 1), named=False)
    sine = eq("law", "sine", where(turn > 0, sp.sin(angle) / angle, 1), named=False)
    decay = eq("law", "decay", sp.exp(-slow), named=False)
    of_speed = eq("law", "of_speed", decay * where(aperiodic, share, sine), named=False)
    cosine = eq("law", "cosine", decay * sp.cos(turn), named=False)
    stay = eq("law", "stay", where(aperiodic, decay * (1 + slow * share), cosine + loss / 2 * of_speed), named=False)
    keep = eq("law", "keep", where(aperiodic, decay * (sp.exp(-2 * half) - slow * share),
                                   cosine - loss / 2 * of_speed), named=False)  # fmt: skip
    # Long steps: the target is followed by a parabola, from which the difference fades.
    divisor = eq("law", "divisor", where(sp.Or(short, wide), 1, way**2), named=False)
    behind = eq("law", "behind", slope - 2 * loss * bend / divisor, named=False)
    middle = eq("law", "middle", u - (2 * bend + loss * behind) / divisor, named=False)
    dx = eq("law", "dx", x - middle, named=False)
    dv = eq("law", "dv", start - behind, named=False)
    far = middle + behind + bend + stay * dx + of_speed * dv
    far_change = 2 * bend + (keep - 1) * dv - way**2 * of_speed * dx
    # Much damping: two lags with different rates.
    difference = eq("law", "difference", where(wide, 2 * half, 1), named=False)
    late = eq("law", "late", _followed(eq, "slow_", u, slope, bend, slow), named=False)
    early = eq("law", "early", _followed(eq, "fast_", u, slope, bend, fast), named=False)
    apart = stay * x + of_speed * start + (fast * late - slow * early) / difference
    apart_change = (keep - 1) * start - way**2 * of_speed * x + way**2 * (early - late) / difference
    ends = (near, apart, far), (near_change, apart_change, far_change)
    end, change = (where(short, first, where(wide, another, third)) for first, another, third in ends)
    return end, change


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
    fall, rise = _parts(eq, a, b, a_end, b_end, width)
    fallen = eq("law", "fallen", where(fall < 0, (z + 1) * sp.exp(fall) - 1, z), named=False)
    return where(rise > 0, 1 + (fallen - 1) * sp.exp(-rise), fallen)


def play(eq: Chapter, z: sp.Expr, s: sp.Expr, s_end: sp.Expr, width: sp.Expr) -> sp.Expr:
    """Play dz = ds / width between -1 and 1 along a path that goes from s to s_end without turning back."""
    moved = eq("law", "moved", z + (s_end - s) / width, named=False)
    return where(moved > 1, 1, where(moved < -1, -1, moved))


def play_size(
    eq: Chapter, z: sp.Expr, a: sp.Expr, b: sp.Expr, a_end: sp.Expr, b_end: sp.Expr, width: sp.Expr
) -> sp.Expr:
    """Play for s = sqrt(a^2 + b^2) along the straight path from (a, b) to (a_end, b_end), in the same two parts."""
    fall, rise = _parts(eq, a, b, a_end, b_end, width)
    lowered = eq("law", "lowered", z + fall, named=False)
    fallen = eq("law", "fallen", where(lowered < -1, -1, lowered), named=False)
    return where(fallen + rise > 1, 1, fallen + rise)


def _parts(
    eq: Chapter, a: sp.Expr, b: sp.Expr, a_end: sp.Expr, b_end: sp.Expr, width: sp.Expr
) -> tuple[sp.Expr, sp.Expr]:
    """Return by how many widths sqrt(a^2 + b^2) falls (negative) and then grows along a straight path."""
    da, db = (eq("law", f"d{n}", end - n, named=False) for n, end in ((a, a_end), (b, b_end)))
    squared = eq("law", "squared", da**2 + db**2, named=False)
    path = eq("law", "path", where(squared > NO_PATH, squared, 1), named=False)
    point = eq("law", "point", -(a * da + b * db) / path, named=False)
    part = eq("law", "part", where(point < 0, 0, where(point > 1, 1, point)), named=False)
    least = eq("law", "least", sp.sqrt((a + part * da) ** 2 + (b + part * db) ** 2), named=False)
    fall = eq("law", "fall", (least - sp.sqrt(a**2 + b**2)) / width, named=False)
    rise = eq("law", "rise", (sp.sqrt(a_end**2 + b_end**2) - least) / width, named=False)
    return fall, rise


#: Every law by name.
LAWS: dict[str, LineFunction] = {
    law.__name__: _law(law)
    for law in (
        lag, lag_held, lag_curved, sum_linear, sum_curved, oscillator, oscillator_speed, dahl, dahl_size, play,
        play_size,
    )
}  # fmt: skip
