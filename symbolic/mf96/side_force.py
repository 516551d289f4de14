"""Side force in pure slip. Pacejka (2012), eqs. (4.E19)-(4.E29), in the Trento worksheet's form.

It differs from the book: camber stiffness has the smoothed sign of the inclination, not its magnitude; LFZ0 occurs
twice in K_yalpha; camber thrust is a pair of shifts (PHY3, PVY3, PVY4), as in 1996, and carries LHY and LVY.
"""

from __future__ import annotations

from sympy import atan, sin

from ..effects import (
    camber_curvature,
    camber_friction,
    camber_stiffness,
    camber_thrust,
    conicity,
    curvature_asym,
    load_curvature,
    load_friction,
    load_stiffness,
    plysteer,
)
from ..notation import Chapter, magic, smooth_sign
from ..quantities import ALPHA
from .coefficients import Lateral as p
from .coefficients import Scaling as s
from .normalized import Fz, Fz01, dfz, gamma, sign_gamma

eq = Chapter("Side force, pure slip")

# fmt: off
SHy    = eq("4.E27", "S_Hy",
            (plysteer.term(p.PHY1 + p.PHY2*dfz) + camber_thrust.term(p.PHY3*gamma)) * s.LHY,
            "rad", "horizontal shift")
SVy    = eq("4.E29", "S_Vy",
            Fz * (conicity.term(p.PVY1 + p.PVY2*dfz)
                  + camber_thrust.term((p.PVY3 + p.PVY4*dfz) * gamma)) * s.LVY * s.LMUY,
            "N", "vertical shift")
alphay = eq("4.E20", "alpha_y",
            ALPHA.symbol + SHy,
            "rad", "slip angle, shifted")
sign_alphay = smooth_sign(eq, "sign_alpha_y", alphay)
Cy     = eq("4.E21", "C_y",
            p.PCY1 * s.LCY,
            "1", "shape factor")
muy    = eq("4.E23", "mu_y",
            (p.PDY1 + load_friction.term(p.PDY2*dfz)) * s.LMUY
            * camber_friction.factor(1 - p.PDY3*gamma**2),
            "1", "peak friction")
Dy     = eq("4.E22", "D_y",
            muy * Fz,
            "N", "peak factor")
Ey     = eq("4.E24", "E_y",
            (p.PEY1 + load_curvature.term(p.PEY2*dfz)) * s.LEY
            * (1 - (curvature_asym.term(p.PEY3) + camber_curvature.term(p.PEY4*gamma)) * sign_alphay),
            "1", "curvature factor")
full   = eq("4.E25", "K_yalpha_w",
            2 * atan(Fz / (Fz01*p.PKY2)),
            "rad", "how far K_yalpha is up", named=False)
Kya    = eq("4.E25", "K_yalpha",
            load_stiffness.either(Fz01 * p.PKY1 * sin(full), p.PKY1 * Fz) * s.LFZ0 * s.LKA
            * camber_stiffness.factor(1 - p.PKY3*sign_gamma),
            "N/rad", "cornering stiffness")
By     = eq("4.E26", "B_y",
            Kya / (Cy*Dy),
            "1/rad", "stiffness factor")
curve  = magic(eq, "F_y0", By, Cy, Dy, Ey, alphay)
Fy0    = eq("4.E19", "F_y0",
            curve.sine + SVy,
            "N", "side force in pure slip")
slope  = eq("Trento", "F_y0_slope",
            curve.slope,
            "N/rad", "slope of F_y0 at this slip angle, E_y held constant")
