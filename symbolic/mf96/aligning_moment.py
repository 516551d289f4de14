"""Aligning moment. Pacejka (2012), eqs. (4.E31)-(4.E49) pure and (4.E71)-(4.E78) combined.

The pure moment M_z0 is the Trento worksheet's: E_t has atan(B_t C_t alpha_t) without 2/pi; D_t divides by the
unscaled nominal load; S_Hf has no epsilon; the trail multiplies the whole F_y0, vertical shift included.
The worksheet ends there. The output Mz follows the book: equivalent slips, G_yk F_y0 and the moment arm of Fx; without
longitudinal slip and with SSZ at 0 it is M_z0. The equivalent slips have a sign without a jump:
alpha sqrt(1 + q^2 / (alpha^2 + 1e-6)) for the book's sgn(alpha) sqrt(alpha^2 + q^2).
"""

from __future__ import annotations

from sympy import atan, cos, sqrt

from ..effects import (
    Mz_from_Fx,
    camber_trail,
    residual_torque_Mzr,
    trail_curvature,
    trail_load,
    trail_shift,
)
from ..notation import SIGN_SMOOTHING, Chapter, magic
from ..quantities import ALPHA, KAPPA
from .coefficients import Aligning as q
from .coefficients import Dimension, Vertical
from .coefficients import Scaling as s
from .combined_slip import Fx, Fy, SVyk
from .longitudinal_force import Kxk
from .normalized import Fz, dfz, gamma, on_ground, sign_gamma
from .side_force import By, Cy, Fy0, Kya, SHy, SVy

eq = Chapter("Aligning moment")
R0, Fz0, alpha = Dimension.UNLOADED_RADIUS, Vertical.FNOMIN, ALPHA.symbol

# fmt: off
SHf    = eq("4.E38", "S_Hf",
            SHy + SVy / Kya,
            "rad", "shift of the residual moment")
SHt    = eq("4.E35", "S_Ht",
            trail_shift.term(q.QHZ1 + q.QHZ2*dfz) + camber_trail.term((q.QHZ3 + q.QHZ4*dfz) * gamma),
            "rad", "shift of the trail")
alphat = eq("4.E34", "alpha_t",
            alpha + SHt,
            "rad", "slip angle of the trail")
alphar = eq("4.E37", "alpha_r",
            alpha + SHf,
            "rad", "slip angle of the residual moment")
Bt     = eq("4.E40", "B_t",
            (q.QBZ1 + trail_load.term(q.QBZ2*dfz + q.QBZ3*dfz**2)) * s.LKY / s.LMUY
            * camber_trail.factor(1 + q.QBZ4*gamma + q.QBZ5*sign_gamma),
            "1/rad", "stiffness factor of the trail")
Ct     = eq("4.E41", "C_t",
            q.QCZ1,
            "1", "shape factor of the trail")
Dt     = eq("4.E43", "D_t",
            Fz * (q.QDZ1 + trail_load.term(q.QDZ2*dfz)) * R0 / Fz0 * s.LT
            * camber_trail.factor(1 + q.QDZ3*gamma + q.QDZ4*gamma**2),
            "m", "peak factor of the trail")
Et     = eq("4.E44", "E_t",
            trail_curvature.term(
                (q.QEZ1 + trail_load.term(q.QEZ2*dfz + q.QEZ3*dfz**2))
                * (1 + (q.QEZ4 + camber_trail.term(q.QEZ5*gamma)) * atan(Bt * Ct * alphat))),
            "1", "curvature factor of the trail")
Br     = eq("4.E45", "B_r",
            q.QBZ9 * s.LKY / s.LMUY + q.QBZ10 * By * Cy,
            "1/rad", "stiffness factor of the residual moment")
Dr     = eq("4.E47", "D_r",
            residual_torque_Mzr.term(
                Fz * (q.QDZ6 + q.QDZ7*dfz + (q.QDZ8 + q.QDZ9*dfz) * gamma) * R0 * s.LMUY * s.LMR),
            "N m", "peak factor of the residual moment")
t0     = eq("4.E33", "trail_0",
            magic(eq, "trail_0", Bt, Ct, Dt, Et, alphat).cosine * cos(alpha),
            "m", "trail in pure slip")
Mzr0   = eq("4.E36", "M_zr0",
            Dr * cos(atan(Br * alphar)) * cos(alpha),
            "N m", "residual moment in pure slip")
Mz0    = eq("4.E31", "M_z0",
            -t0 * Fy0 + Mzr0,
            "N m", "aligning moment in pure slip")

share  = eq("4.E77", "kappa_share",
            (Kxk / Kya * KAPPA.symbol)**2,
            "rad^2", "equivalent slip angle of kappa, squared", named=False)
alphateq = eq("4.E77", "alpha_teq",
              alphat * sqrt(1 + share / (alphat**2 + SIGN_SMOOTHING)),
              "rad", "equivalent slip of the trail")
alphareq = eq("4.E78", "alpha_req",
              alphar * sqrt(1 + share / (alphar**2 + SIGN_SMOOTHING)),
              "rad", "equivalent slip of the residual moment")
t      = eq("4.E73", "trail",
            magic(eq, "trail", Bt, Ct, Dt, Et, alphateq).cosine * cos(alpha),
            "m", "pneumatic trail")
Mzr    = eq("4.E75", "M_zr",
            Dr * cos(atan(Br * alphareq)) * cos(alpha),
            "N m", "residual moment")
arm    = eq("4.E76", "s",
            Mz_from_Fx.term(R0 * (q.SSZ1 + q.SSZ2*Fy/Fz0 + (q.SSZ3 + q.SSZ4*dfz) * gamma) * s.LS),
            "m", "moment arm of Fx")
Mz     = eq("4.E71", "Mz",
            on_ground(-t * (Fy - SVyk) + Mzr + arm * Fx),
            "N m", "aligning moment")
