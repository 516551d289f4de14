"""Longitudinal force in pure slip. Pacejka (2012), eqs. (4.E9)-(4.E18), in the Trento worksheet's form.

It differs from the book: K_xkappa falls with exp(-PKX3 dfz); the inclination is scaled by LGAMMAY; the sign
in E_x is smoothed; E_x is not clamped; B_x has no epsilon (and no value at mu_x = 0).
"""

from __future__ import annotations

from sympy import exp

from ..effects import (
    camber_friction,
    curvature_asym,
    load_curvature,
    load_friction,
    load_stiffness,
    longitudinal_shift,
)
from ..notation import Chapter, magic, smooth_sign
from ..quantities import KAPPA
from .coefficients import Longitudinal as p
from .coefficients import Scaling as s
from .normalized import Fz, dfz, gamma

eq = Chapter("Longitudinal force, pure slip")

# fmt: off
SHx    = eq("4.E17", "S_Hx",
            longitudinal_shift.term((p.PHX1 + p.PHX2*dfz) * s.LHX),
            "1", "horizontal shift")
kappax = eq("4.E10", "kappa_x",
            KAPPA.symbol + SHx,
            "1", "longitudinal slip, shifted")
sign_kappax = smooth_sign(eq, "sign_kappa_x", kappax)
Cx     = eq("4.E11", "C_x",
            p.PCX1 * s.LCX,
            "1", "shape factor")
mux    = eq("4.E13", "mu_x",
            (p.PDX1 + load_friction.term(p.PDX2*dfz)) * s.LMUX
            * camber_friction.factor(1 - p.PDX3*gamma**2),
            "1", "peak friction")
Dx     = eq("4.E12", "D_x",
            mux * Fz,
            "N", "peak factor")
Ex     = eq("4.E14", "E_x",
            (p.PEX1 + load_curvature.term(p.PEX2*dfz + p.PEX3*dfz**2)) * s.LEX
            * curvature_asym.factor(1 - p.PEX4*sign_kappax),
            "1", "curvature factor")
Kxk    = eq("4.E15", "K_xkappa",
            Fz * (p.PKX1 + load_stiffness.term(p.PKX2*dfz)) * s.LKXK
            * load_stiffness.factor(exp(-p.PKX3*dfz)),
            "N", "longitudinal slip stiffness")
Bx     = eq("4.E16", "B_x",
            Kxk / (Cx*Dx),
            "1", "stiffness factor")
SVx    = eq("4.E18", "S_Vx",
            longitudinal_shift.term(Fz * (p.PVX1 + p.PVX2*dfz) * s.LVX * s.LMUX),
            "N", "vertical shift")
curve  = magic(eq, "F_x0", Bx, Cx, Dx, Ex, kappax)
Fx0    = eq("4.E9", "F_x0",
            curve.sine + SVx,
            "N", "longitudinal force in pure slip")
slope  = eq("Trento", "F_x0_slope",
            curve.slope,
            "N", "slope of F_x0 at this slip, E_x held constant")
