"""Side force in pure slip. Pacejka (2012), eqs. (4.E19)-(4.E30) and, for turn slip, (4.80)-(4.89).

The lines occur three times: with the inclination; without it (``_g0``) for F'y, the side force that the pneumatic
trail carries; and without inclination and turn slip (``_00``) for M_z0. MF5.2 has the 1996 camber thrust, a
horizontal shift PHY3 for the camber stiffness K_ygamma0.
"""

from __future__ import annotations

from dataclasses import dataclass

from sympy import Eq, Expr, Integer, Symbol, atan, sin

from ..effects import (
    camber_curvature,
    camber_friction,
    camber_stiffness,
    camber_stiffness_load,
    camber_thrust,
    conicity,
    curvature_asym,
    load_curvature,
    load_friction,
    load_stiffness,
    plysteer,
    pressure_friction,
    pressure_stiffness,
)
from ..functions import absolute, sgn, sgn1, where
from ..notation import Chapter, magic, only
from ..options import limits, slip_angle
from ..quantities import V
from .coefficients.forces import Lateral as p
from .coefficients.moments import TurnSlip as t
from .coefficients.scaling import Scaling as s
from .inputs import Fz, at_most_1, rs
from .normalized import EPS, LMUY, LMUY1, Fz01, alphas, dfz, dpi, gammas
from .turn_slip import epsg, turning, u, zeta0, zeta3
from .turn_slip import zeta2 as turn_zeta2

eq = Chapter("Side force, pure slip")


@dataclass(frozen=True)
class PureSideForce:
    """Results of the lines at one inclination for other chapters."""

    Kya1: Symbol
    By: Symbol
    Cy: Symbol
    SHy: Symbol
    SVy: Symbol
    Fy0: Symbol


# fmt: off


def cornering_stiffness(gammas: Expr, at: str, named: bool, zeta3: Expr = zeta3) -> Symbol:
    """File K_yalpha, eq. (4.E25)."""
    top = ((p.PKY2 + camber_stiffness_load.term(p.PKY5*gammas**2))
           * pressure_stiffness.factor(1 + p.PPY2*dpi))
    return eq("4.E25", "K_yalpha",
              load_stiffness.either(p.PKY1 * Fz01 * sin(p.PKY4 * atan(Fz / Fz01 / top)), p.PKY1 * Fz)
              * pressure_stiffness.factor(1 + p.PPY1*dpi)
              * camber_stiffness.factor(1 - p.PKY3*absolute(gammas)) * zeta3 * s.LKY,
              "N/rad", "cornering stiffness", named=named, at=at)


def nonzero(Kya: Symbol, at: str) -> Symbol:
    """File K'_yalpha, eq. (4.E39)."""
    return eq("4.E39", "K_yalpha1", Kya + EPS*sgn1(Kya), "N/rad", "cornering stiffness, not 0", named=False, at=at)


def pure(gammas: Expr, Kya: Symbol, Kya1: Symbol, at: str, *, named: bool = False, spins: bool = True) -> PureSideForce:
    """File the side force at an inclination, with turn slip or without."""
    zeta2 = turn_zeta2 if spins else Integer(1)
    SVyg   = eq("4.E28", "S_Vygamma",
                camber_thrust.term(Fz * (p.PVY3 + p.PVY4*dfz) * gammas * s.LKYC * LMUY1 * zeta2),
                "N", "vertical shift by inclination", named=False, at=at)
    zeta4  = eq("4.84", "zeta_4",
                turning(1 + SHyphi - SVyg / Kya1) if spins else 1,
                "1", "shift by spin", named=False, at=at)
    SHyg   = only("mf52",
                  camber_thrust.term(p.PHY3*gammas * s.LKYC),
                  camber_thrust.term((Kyg0*gammas - SVyg) / Kya1 * zeta0) + zeta4 - 1)
    SHy    = eq("4.E27", "S_Hy",
                (plysteer.term((p.PHY1 + p.PHY2*dfz) * s.LHY) + SHyg) * rs,
                "rad", "horizontal shift", named=named, at=at)
    alphay = eq("4.E20", "alpha_y",
                alphas + SHy,
                "rad", "slip angle, shifted", named=named, at=at)
    Cy     = eq("4.E21", "C_y",
                p.PCY1 * s.LCY,
                "1", "shape factor", named=named, at=at)
    muy    = eq("4.E23", "mu_y_loaded",
                (p.PDY1 + load_friction.term(p.PDY2*dfz)) * LMUY
                * pressure_friction.factor(1 + p.PPY3*dpi + p.PPY4*dpi**2)
                * camber_friction.factor(1 - p.PDY3*gammas**2),
                "1", "peak friction", named=False, at=at, acts_for="mu_y")
    Dy     = eq("4.E22", "D_y",
                muy * Fz * zeta2,
                "N", "peak factor", named=named, at=at)
    Ey     = eq("4.E24", "E_y",
                at_most_1((p.PEY1 + load_curvature.term(p.PEY2*dfz)) * s.LEY
                          * (1 + camber_curvature.term(p.PEY5*gammas**2)
                             - (curvature_asym.term(p.PEY3) + camber_curvature.term(p.PEY4*gammas))
                             * sgn1(alphay))),
                "1", "curvature factor", named=named, at=at)
    By     = eq("4.E26", "B_y",
                Kya / (Cy*Dy + EPS*sgn1(Dy)),
                "1/rad", "stiffness factor", named=named, at=at)
    SVy    = eq("4.E29", "S_Vy",
                (conicity.term(Fz * (p.PVY1 + p.PVY2*dfz) * s.LVY * LMUY1 * zeta2) + SVyg) * rs,
                "N", "vertical shift", named=named, at=at)
    Fy0    = eq("4.E19", "F_y0",
                (magic(eq, f"F_y0{at}", By, Cy, Dy, Ey, alphay).sine + SVy) * slip_angle.either(sgn1(V.symbol), 1),
                "N", "side force in pure slip", named=named, at=at)
    return PureSideForce(Kya1, By, Cy, SHy, SVy, Fy0)


Kya0   = cornering_stiffness(Integer(0), "_g0", named=False)
Kya01  = nonzero(Kya0, "_g0")
Kya    = cornering_stiffness(gammas, "", named=True)
Kya1   = nonzero(Kya, "")
Kyg0   = eq("4.E30", "K_ygamma0",
            only("mf52",
                 camber_thrust.term((p.PHY3 * p.PKY1 * Fz01 * sin(p.PKY4 * atan(Fz / (p.PKY2*Fz01))) * s.LKYC
                                     + Fz * (p.PVY3 + p.PVY4*dfz)) * s.LKYC),
                 camber_thrust.term(Fz * (p.PKY6 + p.PKY7*dfz)
                                    * pressure_stiffness.factor(1 + p.PPY5*dpi) * s.LKYC)),
            "N/rad", "camber stiffness")
DHyphi = eq("4.86", "D_Hyphi",
            (t.PHYP2 + t.PHYP3*dfz) * sgn(V.symbol),
            "rad", "shift by spin, peak", named=False)
slope  = eq("4.88", "K_Hyphi",
            where(Eq(DHyphi * Kya01, 0), 1, t.PHYP1 * DHyphi * Kya01),
            "N", "cornering stiffness times shift; 1 where there is no shift", named=False)
BHyphi = eq("4.88", "B_Hyphi",
            Kyg0 / (1 - epsg) / slope,
            "1", "shift by spin, stiffness", named=False)
EHyphi = eq("4.87", "E_Hyphi",
            at_most_1(t.PHYP4),
            "1", "shift by spin, curvature", named=False)
SHyphi = eq("4.80", "S_Hyphi",
            magic(eq, "S_Hyphi", BHyphi, t.PHYP1, DHyphi, EHyphi, u).sine * sgn(V.symbol),
            "rad", "shift by spin", named=False)

Kya00  = cornering_stiffness(Integer(0), "_00", named=False, zeta3=Integer(1))
with_camber    = pure(gammas, Kya, Kya1, "", named=True)
without_camber = pure(Integer(0), Kya0, Kya01, "_g0")
straight       = pure(Integer(0), Kya00, nonzero(Kya00, "_00"), "_00", spins=False)
muy_   = Symbol("mu_y_loaded", real=True)
muy_at = eq("4.E23", "mu_y_pressed",
            where(Fz <= 0, 0, muy_),
            "1", "peak friction, 0 off the ground", named=False)
muy    = eq("4.E23", "mu_y",
            limits.either(muy_at, absolute(muy_at)),
            "1", "peak friction; 0 off the ground, as MFeval prints it")
