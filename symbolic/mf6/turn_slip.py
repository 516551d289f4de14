"""Turn slip: spin and the factors zeta. Pacejka (2012), eqs. (4.76)-(4.106).

It acts in rows with phit; in rows with phit = 0 every zeta is 1. zeta4 is with the side force, zeta7 and zeta8 with the
aligning moment. With the convention tno the spin has the opposite sign of the book's phi, which affects only S_Hyphi,
and camber counts as spin at V_c instead of the book's V_cx.

With inclination, the limit of these equations for phit -> 0 differs from the force of straight running: the spin of
camber reduces D_y and K_yalpha, and with tno's sign S_Hyphi is reversed. MFeval has a mode for each case. Here the two
are interpolated below PHIT_FULL, where a measured path cannot be distinguished from a straight line.
"""

from __future__ import annotations

from sympy import Eq, Expr, Float, atan, cos, sin

from ..effects import turn_slip
from ..functions import absolute, root, sgn1, where
from ..notation import Chapter
from ..options import convention
from ..quantities import V
from .coefficients.body import Dimension
from .coefficients.moments import TurnSlip as t
from .inputs import VXLOW, gamma, kappa, phit
from .normalized import Vc, dfz, tan_alpha
from .rolling_radius import omega

eq = Chapter("Turn slip")
R0 = Dimension.UNLOADED_RADIUS
#: Turn slip above which its equations act in full, 1/m: a path with a radius of 1000 km.
PHIT_FULL = Float("1e-6")
part = absolute(phit) / PHIT_FULL


def turning(on: Expr | int, off: Expr | int = 1) -> Expr:
    """Return a term that is `on` in rows with turn slip and `off` in others."""
    return turn_slip.either(where(Eq(phit, 0), off, turned * on + (1 - turned) * off), off)


# fmt: off
turned = eq("tirefmu", "turn_share",
            where(part < 1, part**2 * (3 - 2*part), 1),
            "1", "share of the equations of turn slip: 1, but less for a path that is almost straight", named=False)
epsg  = eq("4.90", "eps_gamma",
           t.PECP1 * (1 + t.PECP2*dfz),
           "1", "equivalent spin of camber", named=False)
Vspin = eq("4.76", "V_spin",
           where(absolute(V.symbol) < VXLOW, VXLOW * sgn1(V.symbol), convention.either(Vc, V.symbol)),
           "m/s", "speed that the spin refers to", named=False)
phi   = eq("4.76", "phi",
           convention.either(-1, 1) * (phit + (1 - epsg) * omega * sin(gamma) / Vspin),
           "1/m", "spin by path curvature and camber", named=False)
u     = eq("4.76", "R_0_phi",
           R0 * phi,
           "1", "spin per radius", named=False)
zeta0 = eq("4.83", "zeta_0",
           turning(0),
           "1", "camber acts through its spin", named=False)
Bxphi = eq("4.106", "B_xphi",
           t.PDXP1 * (1 + t.PDXP2*dfz) * cos(atan(t.PDXP3*kappa)),
           "1", "fall of D_x with spin", named=False)
zeta1 = eq("4.105", "zeta_1",
           turning(cos(atan(Bxphi * u))),
           "1", "reduction of D_x by spin", named=False)
Byphi = eq("4.78", "B_yphi",
           t.PDYP1 * (1 + t.PDYP2*dfz) * cos(atan(t.PDYP3*tan_alpha)),
           "1", "fall of D_y with spin", named=False)
zeta2 = eq("4.77", "zeta_2",
           turning(cos(atan(Byphi * (absolute(u) + t.PDYP4 * root(absolute(u)))))),
           "1", "reduction of D_y by spin", named=False)
zeta3 = eq("4.79", "zeta_3",
           turning(cos(atan(t.PKYP1 * u**2))),
           "1", "reduction of the cornering stiffness by spin", named=False)
zeta5 = eq("4.91", "zeta_5",
           turning(cos(atan(t.QDTP1 * u))),
           "1", "reduction of the trail by spin", named=False)
zeta6 = eq("4.102", "zeta_6",
           turning(cos(atan(t.QBRP1 * u))),
           "1", "reduction of B_r by spin", named=False)
