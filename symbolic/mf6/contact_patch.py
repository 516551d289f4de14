"""Contact patch. Besselink et al. (2010), eqs. (9), (10); MF5.2: MF-Tyre manual."""

from __future__ import annotations

from sympy import And, Eq, Float, Rational, log, sqrt

from ..functions import where
from ..notation import Chapter, only
from .coefficients.body import Dimension, Vertical
from .coefficients.body import Patch as c
from .inputs import Fz_in
from .rolling_radius import czn

eq = Chapter("Contact patch")
R0 = Dimension.UNLOADED_RADIUS
LN10 = Float("2.302585092994046")

# fmt: off
travel = eq("MFeval", "travel",
            R0 - Dimension.RIM_RADIUS - Vertical.BOTTOM_OFFST,
            "m", "deflection at which the tire bottoms", named=False)
load   = eq("MFeval", "F_zc",
            where(Fz_in / czn > travel, travel * czn, Fz_in),
            "N", "load that lengthens the contact patch, until the tire bottoms", named=False)
w      = eq("P 9", "w_patch",
            load / (czn * R0),
            "1", "deflection per radius", named=False)
hard   = eq("M", "hardness",
            log(R0 * Vertical.VERTICAL_STIFFNESS / Vertical.FNOMIN) / LN10,
            "1", "decimal logarithm of the stiffness", named=False)
A1_    = -0.0388*hard**3 + 0.2509*hard**2 - 0.6283*hard + 0.6279
none   = And(Eq(c.Q_A1, 0), Eq(c.Q_A2, 0))
A1     = eq("M", "A_1",
            only("mf52", where(none, A1_, c.Q_A1), 0),
            "1", "half length per root of load", named=False)
A2     = eq("M", "A_2",
            only("mf52", where(none, 1.693 * A1**2, c.Q_A2), 0),
            "1", "half length per load", named=False)
a      = eq("P 9", "a",
            R0 * only("mf52",
                      A2 * load / Vertical.FNOMIN + A1 * sqrt(load / Vertical.FNOMIN),
                      c.Q_RA2 * w + c.Q_RA1 * sqrt(w)),
            "m", "half length of the contact patch")
b      = eq("P 10", "b",
            Dimension.WIDTH * only("mf52", Rational(1, 2), c.Q_RB2 * w + c.Q_RB1 * w**Rational(1, 3)),
            "m", "half width of the contact patch")
