"""Normalized inputs, as the Trento worksheet has them.

Equation numbers in this folder are those of Pacejka (2012), section 4.E, for the line of that name; the form is the
Trento worksheet's MF96. Each chapter states its deviations from the book.
"""

from __future__ import annotations

from sympy import Expr, Float, Piecewise

from ..notation import Chapter, smooth_sign
from ..quantities import FZ, GAMMA
from .coefficients import Scaling as s
from .coefficients import Vertical as v

eq = Chapter("Normalized inputs")

#: Below this load the lines are evaluated at it, so that they remain finite; the forces are 0 (no contact).
LIFT_OFF = Float("1e-6")


def on_ground(expression: Expr) -> Expr:
    """Return the expression, 0 without load (a load of NaN gives NaN)."""
    return Piecewise((0, FZ.symbol <= LIFT_OFF), (expression, True))


# fmt: off
Fz    = eq("tirefmu", "F_z",
           Piecewise((LIFT_OFF, FZ.symbol <= LIFT_OFF), (FZ.symbol, True)),
           "N", "load, limited to positive values", named=False)
Fz01  = eq("4.E1", "F_z01",
           s.LFZ0 * v.FNOMIN,
           "N", "nominal load, scaled")
dfz   = eq("4.E2a", "dfz",
           Fz / Fz01 - 1,
           "1", "normalized change in load")
gamma = eq("4.E4", "gamma_s",
           GAMMA.symbol * s.LGAMMAY,
           "rad", "inclination, scaled")
sign_gamma = smooth_sign(eq, "sign_gamma", gamma)
