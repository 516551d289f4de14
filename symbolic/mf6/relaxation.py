"""Stiffness of the standing tire and relaxation lengths. Besselink et al. (2010), eqs. (17)-(19); MF5.2: manual."""

from __future__ import annotations

from sympy import atan, exp, sin

from ..effects import camber_stiffness
from ..functions import absolute
from ..notation import Chapter, only
from .coefficients.body import Dimension, Vertical
from .coefficients.body import Structural as c
from .coefficients.forces import Lateral as py
from .coefficients.forces import Longitudinal as px
from .coefficients.scaling import Scaling as s
from .inputs import Fz, gamma
from .longitudinal_force import Kxk
from .normalized import Fz01, dfz, dpi
from .side_force import Kya

eq = Chapter("Relaxation")
R0, Fz0 = Dimension.UNLOADED_RADIUS, Vertical.FNOMIN

# fmt: off
cx     = eq("P 17", "c_x",
            c.LONGITUDINAL_STIFFNESS * (1 + c.PCFX1*dfz + c.PCFX2*dfz**2) * (1 + c.PCFX3*dpi),
            "N/m", "longitudinal stiffness of the standing tire")
cy     = eq("P 18", "c_y",
            c.LATERAL_STIFFNESS * (1 + c.PCFY1*dfz + c.PCFY2*dfz**2) * (1 + c.PCFY3*dpi),
            "N/m", "lateral stiffness of the standing tire")
sigmax = eq("P 19", "sigma_x",
            only("mf52",
                 (px.PTX1 + px.PTX2*dfz) * exp(-px.PTX3*dfz) * s.LSGKP * R0 * Fz / Fz0,
                 absolute(Kxk / cx)),
            "m", "longitudinal relaxation length")
sigmay = eq("P 19", "sigma_y",
            only("mf52",
                 py.PTY1 * sin(2 * atan(Fz / (py.PTY2*Fz01))) * R0 * s.LFZO * s.LSGAL
                 * camber_stiffness.factor(1 - py.PKY3*absolute(gamma)),
                 absolute(Kya / cy)),
            "m", "lateral relaxation length")
