"""Aligning moment. Pacejka (2012), eqs. (4.E31)-(4.E49), (4.E71)-(4.E78), turn slip (4.91)-(4.104).

The industry's solvers (convention tno) and the book differ in B_t, D_t, the equivalent slips (tangents of what
is already a tangent), the moment arm, the side force F'y, a factor LFZO on the trail and, with turn slip, in a
product of QDZ8 and QDZ9 that the book has as a sum. The signs of such a product do not follow the axes; the option
signs corrects this.
"""

from __future__ import annotations

from sympy import Expr, Float, Integer, Symbol, acos, atan, cos, exp, log, pi, sin, sqrt, tan

from ..effects import (
    Mz_from_Fx,
    camber_torque,
    camber_trail,
    combined_Gyk,
    pressure_moment,
    pressure_trail,
    residual_stiffness,
    residual_torque_Mzr,
    trail_curvature,
    trail_load,
    trail_shift,
)
from ..functions import SMALLEST_SQUARE, absolute, root, sgn, where
from ..notation import Chapter, magic, only
from ..options import convention, signs
from ..quantities import V
from .coefficients.body import Dimension, Vertical
from .coefficients.forces import Lateral as py
from .coefficients.moments import Aligning as q
from .coefficients.moments import TurnSlip as ts
from .coefficients.scaling import Scaling as s
from .combined_slip import Eyk, Fx, Fy, Gyk, SHyk, SVyk, stiffness_ykappa, weighting
from .inputs import Fzm, at_most_1, gamma, kappa, on_ground, phit, rs
from .longitudinal_force import Kxk
from .normalized import LMUY, Fz01, alphas, cos_alpha, dfz, dpi, gammas
from .side_force import Kya1, muy_at, straight, with_camber, without_camber
from .turn_slip import epsg, turning, zeta0, zeta2, zeta5, zeta6

eq = Chapter("Aligning moment")
R0, Fz0 = Dimension.UNLOADED_RADIUS, Vertical.FNOMIN

#: The book's eps_r of eq. (4.104), which MFeval does not have.
EPS_R = Float("1e-6")

# fmt: off
SHt    = eq("4.E35", "S_Ht",
            trail_shift.term(q.QHZ1 + q.QHZ2*dfz) + camber_trail.term((q.QHZ3 + q.QHZ4*dfz) * gammas),
            "rad", "shift of the trail")
alphat = eq("4.E34", "alpha_t",
            alphas + SHt,
            "rad", "slip angle of the trail")
alphar = eq("4.E37", "alpha_r",
            alphas + with_camber.SHy + with_camber.SVy / Kya1,
            "rad", "slip angle of the residual moment")
Bt     = eq("4.E40", "B_t",
            (q.QBZ1 + trail_load.term(q.QBZ2*dfz + q.QBZ3*dfz**2)) * s.LKY / LMUY
            * camber_trail.factor(convention.either(1 + q.QBZ4*gamma + q.QBZ5*absolute(gamma),
                                                    1 + q.QBZ5*absolute(gammas) + q.QBZ6*gammas**2)),
            "1/rad", "stiffness factor of the trail")
Ct     = eq("4.E41", "C_t",
            q.QCZ1,
            "1", "shape factor of the trail")
Dt     = eq("4.E43", "D_t",
            Fzm * R0 / Fz01 * (q.QDZ1 + trail_load.term(q.QDZ2*dfz)) * s.LTR * zeta5
            * pressure_trail.factor(1 - q.PPZ1*dpi)
            * camber_trail.factor(convention.either(1 + q.QDZ3*gamma + q.QDZ4*gamma**2,
                                                    1 + q.QDZ3*absolute(gammas) + q.QDZ4*gammas**2))
            * convention.either(1, sgn(V.symbol)),
            "m", "peak factor of the trail")
Et     = eq("4.E44", "E_t",
            at_most_1(trail_curvature.term(
                (q.QEZ1 + trail_load.term(q.QEZ2*dfz + q.QEZ3*dfz**2))
                * (1 + (q.QEZ4 + camber_trail.term(q.QEZ5*gammas)) * 2 / pi * atan(Bt * Ct * alphat)))),
            "1", "curvature factor of the trail")
Br     = eq("4.E45", "B_r",
            residual_stiffness.either(q.QBZ9 * s.LKY / LMUY + q.QBZ10 * with_camber.By * with_camber.Cy,
                                      10 * s.LKY / LMUY) * zeta6,
            "1/rad", "stiffness factor of the residual moment")

pressed = eq("4.95", "F_zm_share",
             Fzm / Fz01,
             "1", "load per nominal load", named=False)
Mzinf_ = eq("4.95", "M_zphi_inf_signed",
            ts.QCRP1 * absolute(muy_at) * R0 * Fzm * root(pressed) * s.LMP,
            "N m", "moment of turning on the spot", named=False)
Mzinf  = eq("4.95", "M_zphi_inf",
            where(Mzinf_ <= 0, Float("1e-6"), Mzinf_),
            "N m", "moment of turning on the spot, above 0")
DDrphi = eq("4.94", "D_Drphi",
            Mzinf / sin(pi / 2 * ts.QDRP1),
            "N m", "peak of the moment by spin", named=False)
Kzgr0  = eq("4.99", "K_zgammar0",
            camber_torque.term(Fzm * R0 * s.LKZC * convention.either(
                signs.either(q.QDZ8*q.QDZ9, -q.QDZ8*q.QDZ9) * dfz + q.QDZ10 + q.QDZ11*dfz*absolute(gamma),
                q.QDZ8 + q.QDZ9*dfz + (q.QDZ10 + q.QDZ11*dfz)*absolute(gammas))),
            "N m/rad", "camber torque stiffness", named=False)
BDrphi = eq("4.98", "B_Drphi",
            Kzgr0 / (ts.QDRP1 * DDrphi * (1 - epsg)),
            "1", "stiffness of the moment by spin", named=False)
Drphi  = eq("4.93", "D_rphi",
            DDrphi * sin(ts.QDRP1 * atan(BDrphi * R0 * phit)),
            "N m", "moment by spin", named=False)
none   = absolute(Drphi) <= SMALLEST_SQUARE  # below it, the square of a divisor would be 0
Mzp90  = eq("4.103", "M_zphi90",
            Mzinf * 2 / pi * atan(ts.QCRP2 * R0 * absolute(phit)) * Gyk,
            "N m", "moment by spin at 90 deg of slip", named=False)
peak   = eq("4.104", "D_rphi_size",
            where(none, 1, absolute(Drphi) + convention.either(0, EPS_R)),
            "N m", "size of the moment by spin; 1 where there is none", named=False)
fall   = eq("4.104", "zeta_7_cosine",
            where(none, 0, Mzp90 / peak),
            "1", "reduction of the moment by spin with side slip", named=False)
size   = eq("4.104", "zeta_7_cosine_size",
            absolute(fall),
            "1", "its size", named=False)
below  = eq("4.104", "zeta_7_below_1",
            where(size >= 1, 0, fall),
            "1", "the same where its size is below 1", named=False)
above  = eq("4.104", "zeta_7_above_1",
            where(size > 1, size, 2),
            "1", "its size where that is above 1", named=False)
flat   = eq("4.104", "zeta_7_beyond_1",
            where(fall > 0, 0, 2),
            "1", "zeta_7 where the size is above 1: its real part", named=False)
zeta7  = eq("4.104", "zeta_7",
            where(size >= 1, flat, 2 / pi * acos(below)),
            "1", "shape factor of the residual moment with turn slip, C_r", named=False)
steep  = eq("MFeval", "zeta_7_imaginary",
            2 / pi * log(above + sqrt(above**2 - 1)),
            "1", "imaginary part of zeta_7, of which MFeval prints the real part of the result", named=False)
zeta8  = eq("4.92", "zeta_8",
            turning(1 + Drphi),
            "1", "moment by spin", named=False)

Dr     = eq("4.E47", "D_r",
            Fzm * R0 * LMUY * sgn(V.symbol) * cos(alphas)
            * (residual_torque_Mzr.term((q.QDZ6 + q.QDZ7*dfz) * s.LRES * zeta2)
               + camber_torque.term(((q.QDZ8 + q.QDZ9*dfz) * pressure_moment.factor(1 + q.PPZ2*dpi)
                                     + (q.QDZ10 + q.QDZ11*dfz) * absolute(gammas)) * gammas * s.LKZC * zeta0))
            + zeta8 - 1,
            "N m", "peak factor of the residual moment")


def residual(name: str, alphar: Expr) -> Expr:
    """Return cos(C_r atan(B_r alpha_r)): C_r is 1, with turn slip zeta7, which may be imaginary with tno."""
    angle = eq("4.E75", f"{name}_w",
               atan(Br * alphar),
               "rad", "angle of the residual moment", named=False)
    grown = eq("MFeval", f"{name}_grown",
               exp(steep * angle),
               "1", "exponential of the same", named=False)
    spun  = eq("4.E75", f"{name}_spun",
               cos(zeta7 * angle) * where(size > 1, convention.either((grown + 1/grown) / 2, 1), 1),
               "1", "fall of the residual moment with turn slip", named=False)
    return turning(spun, cos(atan(Br * alphar)))


t0     = eq("4.E33", "trail_0",
            magic(eq, "trail_0", Bt, Ct, Dt, Et, alphat).cosine * cos_alpha,
            "m", "trail in pure slip")
Mzr0   = eq("4.E36", "M_zr0",
            Dr * residual("M_zr0", alphar) * cos_alpha,
            "N m", "residual moment in pure slip")
Mz0    = eq("4.E31", "M_z0",
            -t0 * straight.Fy0 + Mzr0,
            "N m", "aligning moment in pure slip")

share  = eq("4.E77", "kappa_share",
            (Kxk / Kya1 * kappa)**2,
            "rad^2", "equivalent slip angle of kappa, squared", named=False)


def equivalent(name: str, number: str, alpha: Symbol, text: str) -> Symbol:
    """File the slip angle that is equivalent to alpha and kappa together."""
    tangent = eq(number, f"tan_{name}",
                 convention.either(tan(alpha), alpha),
                 "1", "the same as a slip", named=False)
    squared = eq(number, f"slip_{name}_squared",
                 tangent**2 + share,
                 "rad^2", "equivalent slip, squared", named=False)
    slip = eq(number, f"slip_{name}",
              root(squared),
              "1", "size of the equivalent slip", named=False)
    return eq(number, name,
              convention.either(atan(slip), slip) * sgn(alpha),
              "rad", text)


alphateq = equivalent("alpha_teq", "4.E77", alphat, "equivalent slip of the trail")
alphareq = equivalent("alpha_req", "4.E78", alphar, "equivalent slip of the residual moment")
t      = eq("4.E73", "trail",
            magic(eq, "trail", Bt, Ct, Dt, Et, alphateq).cosine * cos_alpha * convention.either(s.LFZO, 1) * rs,
            "m", "pneumatic trail")
Mzr    = eq("4.E75", "M_zr",
            Dr * residual("M_zr", alphareq) * rs,
            "N m", "residual moment")
arm    = eq("4.E76", "s",
            Mz_from_Fx.term(R0 * s.LS * convention.either(
                q.SSZ1 + q.SSZ2*Fy/Fz0 + (q.SSZ3 + q.SSZ4*dfz) * gamma,
                q.SSZ1 + q.SSZ2*Fy/Fz01 + (q.SSZ3 + q.SSZ4*dfz) * gammas)),
            "m", "moment arm of Fx")
Byk0   = stiffness_ykappa(Integer(0), "_g0", named=False)
Gyk0   = eq("4.E74", "G_yk",
            combined_Gyk.factor(weighting("G_yk_g0", Byk0, py.RCY1, Eyk, kappa, SHyk)),
            "1", "G_yk without inclination", named=False, at="_g0")
Fy1    = eq("4.E74", "F_y1",
            only("mf52", Fy - SVyk, convention.either(Gyk, Gyk0) * without_camber.Fy0),
            "N", "side force that the trail carries", named=False)
Mz     = eq("4.E71", "Mz",
            on_ground(-t * Fy1 + Mzr + arm * Fx),
            "N m", "aligning moment")
