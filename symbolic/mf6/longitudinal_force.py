"""Longitudinal force in pure slip. Pacejka (2012), eqs. (4.E9)-(4.E18)."""

from __future__ import annotations

from sympy import exp

from ..effects import (
    camber_friction,
    curvature_asym,
    load_curvature,
    load_friction,
    load_stiffness,
    longitudinal_shift,
    pressure_friction,
    pressure_stiffness,
)
from ..functions import sgn, sgn1, where
from ..notation import Chapter, magic
from ..quantities import V
from .coefficients.forces import Longitudinal as p
from .coefficients.scaling import Scaling as s
from .inputs import Fz, at_most_1, gamma, kappa, rs
from .normalized import EPS, LMUX, LMUX1, dfz, dpi
from .turn_slip import zeta1

eq = Chapter("Longitudinal force, pure slip")

# fmt: off
SHx    = eq("4.E17", "S_Hx",
            longitudinal_shift.term((p.PHX1 + p.PHX2*dfz) * s.LHX * rs),
            "1", "horizontal shift")
kappax = eq("4.E10", "kappa_x",
            kappa + SHx,
            "1", "longitudinal slip, shifted")
Cx     = eq("4.E11", "C_x",
            p.PCX1 * s.LCX,
            "1", "shape factor")
mux_   = eq("4.E13", "mu_x_loaded",
            (p.PDX1 + load_friction.term(p.PDX2*dfz)) * LMUX
            * pressure_friction.factor(1 + p.PPX3*dpi + p.PPX4*dpi**2)
            * camber_friction.factor(1 - p.PDX3*gamma**2),
            "1", "peak friction", named=False, acts_for="mu_x")
mux    = eq("4.E13", "mu_x",
            where(Fz <= 0, 0, mux_),
            "1", "peak friction; 0 off the ground, as MFeval prints it")
Dx     = eq("4.E12", "D_x",
            mux * Fz * zeta1,
            "N", "peak factor")
Ex     = eq("4.E14", "E_x",
            at_most_1((p.PEX1 + load_curvature.term(p.PEX2*dfz + p.PEX3*dfz**2)) * s.LEX
                      * curvature_asym.factor(1 - p.PEX4*sgn(kappax))),
            "1", "curvature factor")
Kxk    = eq("4.E15", "K_xkappa",
            Fz * (p.PKX1 + load_stiffness.term(p.PKX2*dfz)) * load_stiffness.factor(exp(p.PKX3*dfz))
            * pressure_stiffness.factor(1 + p.PPX1*dpi + p.PPX2*dpi**2) * s.LKX,
            "N", "longitudinal slip stiffness")
Bx     = eq("4.E16", "B_x",
            Kxk / (Cx*Dx + EPS*sgn1(Dx)),
            "1", "stiffness factor")
SVx    = eq("4.E18", "S_Vx",
            longitudinal_shift.term(Fz * (p.PVX1 + p.PVX2*dfz) * s.LVX * LMUX1 * zeta1 * rs),
            "N", "vertical shift")
Fx0    = eq("4.E9", "F_x0",
            (magic(eq, "F_x0", Bx, Cx, Dx, Ex, kappax).sine + SVx) * sgn1(V.symbol),
            "N", "longitudinal force in pure slip")
