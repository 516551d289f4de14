"""Normalized quantities. Pacejka (2012), eqs. (4.E1)-(4.E8).

The star quantities alpha*, gamma* are tangent and sine, or the angles themselves (option slip_angle). With the
convention book, sliding friction decreases with the slip speed and LMU acts degressively in the shifts. Neither has an
influence while all LMU are 1 and LMUV is 0.
"""

from __future__ import annotations

from sympy import Float, sin, sqrt, tan

from ..functions import absolute, root, sgn
from ..notation import Chapter
from ..options import convention, slip_angle
from ..quantities import V
from .coefficients.body import Model, Operating, Vertical
from .coefficients.scaling import Scaling as s
from .inputs import Fz, alpha, gamma, kappa, p

eq = Chapter("Normalized inputs")
V0, Fz0, p0 = Model.LONGVL, Vertical.FNOMIN, Operating.NOMPRES

#: The book's eps_V, eps_x, eps_y, eps_K, [4.E6a]: keeps quotients finite.
EPS = Float("1e-6")
#: The book's A_mu of eq. (4.E8).
A_MU = 10

# fmt: off
Fz01  = eq("4.E1", "F_z01",
           s.LFZO * Fz0,
           "N", "nominal load, scaled", named=False)
dfz   = eq("4.E2a", "dfz",
           (Fz - Fz01) / Fz01,
           "1", "normalized change in load")
dpi   = eq("4.E2b", "dpi",
           (p - p0) / p0,
           "1", "normalized change in pressure")
tan_alpha = eq("2.11", "tan_alpha",
               tan(alpha),
               "1", "lateral slip", named=False)
Vc    = eq("2.12", "V_c",
           absolute(V.symbol) * sqrt(1 + tan_alpha**2),
           "m/s", "speed of the contact point", named=False)
cos_alpha = eq("4.E6", "cos_alpha",
               V.symbol / (Vc + EPS),
               "1", "cos(alpha'): the cosine of the slip angle, with the sign of the speed", named=False)
alphas = eq("4.E3", "alpha_star",
            slip_angle.either(tan_alpha * sgn(V.symbol), alpha),
            "rad", "lateral slip alpha*")
gammas = eq("4.E4", "gamma_star",
            slip_angle.either(sin(gamma), gamma),
            "rad", "inclination gamma*")
slip_squared = eq("4.E7", "slip_squared",
                  kappa**2 + tan_alpha**2,
                  "1", "longitudinal and lateral slip, squared", named=False)
slide = eq("4.E7", "slide",
           convention.either(1, 1 + s.LMUV * absolute(V.symbol) / V0 * root(slip_squared)),
           "1", "by how much slip speed lowers friction", named=False)
LMUX  = eq("4.E7", "LMUX_star",
           convention.either(s.LMUX, s.LMUX / slide),
           "1", "friction scale of Fx", named=False)
LMUY  = eq("4.E7", "LMUY_star",
           convention.either(s.LMUY, s.LMUY / slide),
           "1", "friction scale of Fy", named=False)
LMUX1 = eq("4.E8", "LMUX_shift",
           convention.either(LMUX, A_MU * LMUX / (1 + (A_MU - 1) * LMUX)),
           "1", "friction scale of the shifts of Fx", named=False)
LMUY1 = eq("4.E8", "LMUY_shift",
           convention.either(LMUY, A_MU * LMUY / (1 + (A_MU - 1) * LMUY)),
           "1", "friction scale of the shifts of Fy", named=False)
