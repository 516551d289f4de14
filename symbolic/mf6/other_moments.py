"""Overturning and rolling resistance moment. MF-Tyre manual; Pacejka (2012), eqs. (4.E69), (4.E70).

Below FZMIN both fade out, except with the convention book. M_y resists rolling: in ISO-W it is negative if the wheel
rolls forward (the book's plus belongs to its own axes). Near a locked wheel the industry's solvers fade it out
(`taper`, which mixes a speed with a ratio and is right for VXLOW = 1 m/s).
"""

from __future__ import annotations

from sympy import Eq, Float, atan, cos, pi, sin

from ..effects import overturning_Mx, pressure_moment, rolling_resistance_My
from ..functions import absolute, sgn1, where
from ..notation import Chapter, only
from ..options import convention
from ..quantities import KAPPA, V
from .coefficients.body import Dimension, LoadRange, Model, Operating, Vertical
from .coefficients.moments import Overturning as x
from .coefficients.moments import Rolling as y
from .coefficients.scaling import Scaling as s
from .combined_slip import Fx, Fy
from .inputs import VXLOW, Fz, Fz_in, gamma, on_ground, p
from .normalized import dpi

eq = Chapter("Overturning and rolling resistance moment")
R0, Fz0, FZMIN = Dimension.UNLOADED_RADIUS, Vertical.FNOMIN, LoadRange.FZMIN
speed = absolute(V.symbol)
#: The smallest pressure of M_y per nominal pressure: its power may be negative.
LEAST_SHARE = Float("1e-6")

# fmt: off
Fzx  = eq("MFeval", "F_zx",
          convention.either(where(Fz < FZMIN, Fz * (Fz / FZMIN)**2, Fz), Fz),
          "N", "load of M_x", named=False)
hump = eq("M", "M_x_hump",
          x.QSX4 * cos(x.QSX5 * atan((x.QSX6*Fzx/Fz0)**2)) * sin(x.QSX7*gamma + x.QSX8 * atan(x.QSX9*Fy/Fz0)),
          "1", "hump of M_x over load and side force", named=False)
Mx   = eq("4.E69", "Mx",
          on_ground(overturning_Mx.term(R0 * s.LMX * (
              Fzx * (x.QSX1*s.LVMX - x.QSX2*gamma * pressure_moment.factor(1 + x.PPMX1*dpi) + x.QSX3*Fy/Fz0
                     + hump + x.QSX10 * atan(x.QSX11*Fzx/Fz0) * gamma - x.QSX12*gamma*absolute(gamma))
              + Fy * (x.QSX13 + x.QSX14*absolute(gamma))))),
          "N m", "overturning moment")

Fzy  = eq("MFeval", "F_zy",
          convention.either(where(Fz_in < FZMIN, Fz_in**2 / FZMIN, Fz_in), Fz),
          "N", "load of M_y", named=False)
load = eq("MFeval", "F_zy_share",
          where(Fzy <= 0, 1, Fzy / Fz0),
          "1", "load of M_y in nominal loads; 1 off the ground", named=False)
drag = eq("4.E70", "M_y_speed",
          y.QSY1 + y.QSY2*Fx/Fz0 + y.QSY3*absolute(V.symbol / Model.LONGVL) + y.QSY4*(V.symbol / Model.LONGVL)**4,
          "1", "resistance by force and speed", named=False)
moving = eq("tirefmu", "speed_moving",
            where(Eq(V.symbol, 0), 1, speed),
            "m/s", "speed; 1 at standstill, where M_y is 0", named=False)
high = VXLOW / moving - 1
low  = -VXLOW - VXLOW / moving
near = eq("MFeval", "M_y_near_locked",
          sin(pi / 2 * (1 + KAPPA.symbol) * speed / VXLOW),
          "1", "fade near the locked wheel", named=False)
back = eq("MFeval", "M_y_backward",
          where(KAPPA.symbol >= low, near, -1),
          "1", "the same, -1 where the wheel turns backward", named=False)
lock = eq("MFeval", "M_y_taper",
          convention.either(where(KAPPA.symbol <= high, back, 1), 1),
          "1", "the same, 1 where the wheel rolls", named=False)
share = eq("4.E70", "p_share",
           p / Operating.NOMPRES,
           "1", "pressure per nominal pressure", named=False)
press = eq("4.E70", "M_y_pressure",
           where(share < LEAST_SHARE, LEAST_SHARE, share),
           "1", "pressure per nominal pressure, above 0", named=False)
full = eq("4.E70", "M_y_full",
          only("mf52",
               -R0 * Fzy * s.LMY * drag,
               -R0 * convention.either(Fz0, Fz) * s.LMY
               * (drag + (y.QSY5 + y.QSY6*load) * gamma**2)
               * load**y.QSY7 * pressure_moment.factor(press**y.QSY8)),
          "N m", "rolling resistance moment of the rolling wheel", named=False)
rolls = eq("MFeval", "M_y_rolling",
           where(Eq(V.symbol, 0), 0, full * sgn1(V.symbol) * lock),
           "N m", "rolling resistance moment, 0 at standstill", named=False)
My   = eq("4.E70", "My",
          on_ground(rolling_resistance_My.term(rolls)),
          "N m", "rolling resistance moment")
