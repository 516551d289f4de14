"""Forces in combined slip. Pacejka (2012), eqs. (4.E50)-(4.E67), in the Trento worksheet's form.

It differs from the book: no curvature in G; no load in the shifts; S_Vykappa takes the raw inclination; the
shifts and RVY are not scaled.
"""

from __future__ import annotations

from sympy import Expr, atan, cos, sin, sqrt

from ..effects import combined_Gxa, combined_Gyk, kappa_sideforce_SVyk
from ..notation import Chapter
from ..quantities import ALPHA, GAMMA, KAPPA
from .coefficients import Lateral as py
from .coefficients import Longitudinal as px
from .coefficients import Scaling as s
from .longitudinal_force import Fx0
from .normalized import Fz, dfz, on_ground
from .side_force import Fy0, muy

eq = Chapter("Forces, combined slip")
kappa, alpha = KAPPA.symbol, ALPHA.symbol

# fmt: off


def weighting(name: str, numbers: tuple[str, str], B: Expr, C: Expr, x: Expr, SH: Expr) -> Expr:
    """Return cos(C atan(B (x + S_H))) / cos(C atan(B S_H)), eq. (4.E51) without curvature."""
    number, number0 = numbers
    w  = eq(number, f"{name}_w",
            C * atan(B * (x + SH)),
            "rad", "angle of the weighting function", named=False)
    w0 = eq(number0, f"{name}_w0",
            C * atan(B * SH),
            "rad", "the same at zero slip", named=False)
    return cos(w) / cos(w0)


Bxa  = eq("4.E54", "B_xalpha",
          px.RBX1 * s.LXA / sqrt(1 + px.RBX2**2 * kappa**2),
          "1/rad", "stiffness of G_xa")
Gxa  = eq("4.E51", "G_xa",
          combined_Gxa.factor(weighting("G_xa", ("4.E51", "4.E52"), Bxa, px.RCX1, alpha, px.RHX1)),
          "1", "weighting of Fx by side slip")
Byk  = eq("4.E62", "B_ykappa",
          py.RBY1 * s.LYK / sqrt(1 + py.RBY2**2 * (alpha - py.RBY3)**2),
          "1", "stiffness of G_yk")
Gyk  = eq("4.E59", "G_yk",
          combined_Gyk.factor(weighting("G_yk", ("4.E59", "4.E60"), Byk, py.RCY1, kappa, py.RHY1)),
          "1", "weighting of Fy by longitudinal slip")
DVyk = eq("4.E67", "D_Vyk",
          muy * Fz * (py.RVY1 + py.RVY2*dfz + py.RVY3*GAMMA.symbol) / sqrt(1 + py.RVY4**2 * alpha**2),
          "N", "peak of S_Vyk")
SVyk = eq("4.E66", "S_Vyk",
          kappa_sideforce_SVyk.term(DVyk * sin(py.RVY5 * atan(py.RVY6*kappa)) * s.LVYK),
          "N", "side force made by longitudinal slip")
Fx   = eq("4.E50", "Fx",
          on_ground(Gxa * Fx0),
          "N", "longitudinal force")
Fy   = eq("4.E58", "Fy",
          on_ground(Gyk * Fy0 + SVyk),
          "N", "side force")
