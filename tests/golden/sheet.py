"""MF5.2, MF6.1 and MF6.2 line by line in plain NumPy: the reference for conditions without golden rows.

Equations: H. B. Pacejka, Tire and Vehicle Dynamics, 3rd ed. (2012), section 4.E; I. J. M. Besselink, A. J. C. Schmeitz
and H. B. Pacejka, An improved Magic Formula/Swift tyre model that can handle inflation pressure changes, Vehicle
System Dynamics 48 (2010), equations (1)-(19) and A48-A60; MF-Tyre/MF-Swift equation manual (TNO, 2013); and the
behaviour of MFeval 4.3.1 where it is none of them. Transcribed for the tests, with no line of the book's code in it:
no SymPy, no guard at a singular point. Undefined values are NaN.

Convention "tno" is what MFeval computes; its acos of the spin moment is complex beyond 1, of which the columns are the
real part. "book" is the printed section 4.E in ISO-W axes, so that rolling resistance stays negative; there the
argument of acos has the small eps_r in its denominator and counts as 1 beyond 1. Rows spin where phit is not 0.
"""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
from numpy import abs, arctan, cos, exp, pi, sign, sin, sqrt, tan

#: One value for the book's small numbers eps_V, eps_x, eps_y, eps_K (and eps_r).
EPS = 1e-6

#: The results of evaluate in addition to R_omega.
QUANTITIES = """
    Fx Fy Mz Mx My kappa_x B_x C_x D_x E_x S_Vx S_Hx K_xkappa mu_x F_x0 G_xa alpha_y B_y C_y D_y E_y S_Vy S_Hy
    K_yalpha mu_y F_y0 G_yk S_Vyk B_r B_t C_t D_r D_t E_t alpha_r alpha_t M_z0 M_zr trail R_e R_l rho a b sigma_x
    sigma_y c_x c_y c_z omega
"""


class Coefficients(dict):
    """Values by .tir name as attributes; a missing name is an error, except for two that .tir files lack."""

    def __getattr__(self, name):
        return self[name] if name in self or name not in ("LMUV", "QBZ6") else 0.0


def evaluate(values, rows, *, model="mf61", limits=False, slip_angle="tan", turn_slip=True, convention="tno", passes=3):
    """Return forces and named quantities, a dict of arrays.

    `rows` holds arrays kappa, alpha, gamma (rad), Fz (N), p (Pa), V (m/s), phit (1/m). `turn_slip` lets rows with
    phit != 0 spin. `passes` is the number of iterations for the rolling radius.
    """
    c = Coefficients(values)
    q = SimpleNamespace(model=model, limits=limits, tangent=slip_angle == "tan", book=convention == "book")
    with np.errstate(all="ignore"):
        admit(c, q, {name: np.array(column, dtype=float) for name, column in rows.items()}, turn_slip)
        normalize(c, q)
        rolling_radius(c, q, passes)
        spin(c, q)
        longitudinal(c, q)
        pure_side = lateral(c, q, q.gs)
        vars(q).update(vars(pure_side))
        combined(c, q)
        upright = lateral(c, q, 0.0 * q.gs)
        aligning(c, q, upright)
        pure_moment(c, q)
        overturning(c, q)
        rolling_resistance(c, q)
        (deflection_62 if model == "mf62" else deflection_61)(c, q)
        contact_patch(c, q)
        carcass(c, q)
    results = {
        name: np.broadcast_to(np.asarray(getattr(q, name)), q.Fz.shape) for name in (*QUANTITIES.split(), "R_omega")
    }
    return {name: array.astype(float) for name, array in results.items()}


def sgn1(x):
    """Return +1 where x >= 0, else -1 (NaN where x is NaN)."""
    return np.where(np.isnan(x), np.nan, np.where(x >= 0, 1.0, -1.0))


def sin_mf(B, C, E, x):
    return sin(C * arctan(B * x - E * (B * x - arctan(B * x))))


def cos_mf(B, C, E, x):
    return cos(C * arctan(B * x - E * (B * x - arctan(B * x))))


def admit(c, q, rows, turn_slip):
    """Take the inputs unchanged, or bounded (limits): `_in` are those without limits."""
    q.V, q.Fz_in, q.kappa_in = rows["V"], np.maximum(rows["Fz"], 0.0), rows["kappa"]
    q.Fz, q.kappa, q.alpha, q.gamma = q.Fz_in, q.kappa_in, rows["alpha"], rows["gamma"]
    q.p, q.phit, q.rs = rows["p"], rows["phit"], np.ones_like(q.V)
    q.Fz_low = q.Fz_moment = q.Fz
    q.at_most_1 = (lambda E: np.minimum(E, 1.0)) if q.limits else (lambda E: E)
    if q.limits:
        slow = abs(q.V) <= c.VXLOW
        w = np.where(slow, abs(q.V) / c.VXLOW, 1.0)
        q.rs = np.where(slow, (1 - cos(pi * q.V / c.VXLOW)) / 2, 1.0)
        q.phit = q.phit * cos(q.alpha) * w * np.where(q.V < 0, -1.0, 1.0)
        S = abs(q.V) + abs(q.V * tan(q.alpha))
        alpha = np.where(c.VXLOW > S, q.alpha * S / c.VXLOW, q.alpha)
        q.alpha = np.clip(alpha, c.ALPMIN, c.ALPMAX)
        q.gamma = np.clip(q.gamma, c.CAMMIN, c.CAMMAX)
        q.kappa = np.clip(q.kappa * w, c.KPUMIN, c.KPUMAX)
        q.p = np.clip(q.p, c.PRESMIN, c.PRESMAX)
        q.Fz = np.minimum(q.Fz, c.FZMAX)
        q.Fz_low = np.maximum(q.Fz, c.FZMIN)
        q.Fz_moment = np.where(q.Fz == 0, 0.0, q.Fz_low)
    q.spins = (q.phit != 0) & turn_slip


def normalize(c, q):
    """Nominal values, star quantities and friction scales, (4.E1)-(4.E8)."""
    q.R0, q.Fz0, q.V0 = c.UNLOADED_RADIUS, c.FNOMIN, c.LONGVL
    q.Fz0_ = c.LFZO * q.Fz0
    q.dfz = (q.Fz - q.Fz0_) / q.Fz0_
    q.dpi = (q.p - c.NOMPRES) / c.NOMPRES
    Vsy = abs(q.V) * tan(q.alpha)
    q.Vc = sqrt(q.V**2 + Vsy**2)
    q.cos_a = q.V / (q.Vc + EPS)
    q.as_, q.gs = (tan(q.alpha) * sign(q.V), sin(q.gamma)) if q.tangent else (q.alpha, q.gamma)
    q.LMUX, q.LMUY = c.LMUX, c.LMUY
    q.LMUX_, q.LMUY_ = q.LMUX, q.LMUY
    if q.book:
        Vs = np.hypot(q.kappa * q.V, Vsy)
        q.LMUX, q.LMUY = (L / (1 + c.LMUV * Vs / q.V0) for L in (c.LMUX, c.LMUY))
        q.LMUX_, q.LMUY_ = (10 * L / (1 + 9 * L) for L in (q.LMUX, q.LMUY))


def rolling_radius(c, q, passes):
    """Effective rolling radius and the wheel's speed, which need each other; Besselink (1), (5), (7)."""
    q.R_e = 0.965 * q.R0
    load = q.Fz_in / q.Fz0
    q.c_z0 = c.VERTICAL_STIFFNESS * (1 + c.PFZ1 * q.dpi)
    for _ in range(passes):
        q.omega = (1 + q.kappa_in) * q.V / q.R_e
        q.R_omega = q.R0 * (c.Q_RE0 + c.Q_V1 * (q.omega * q.R0 / q.V0) ** 2)
        q.R_e = q.R_omega - q.Fz0 / q.c_z0 * (c.DREFF * arctan(c.BREFF * load) + c.FREFF * load)


def spin(c, q):
    """Turn slip's factors that need no force, (4.76)-(4.106); 1 where the row does not spin."""
    q.eps_g = c.PECP1 * (1 + c.PECP2 * q.dfz)
    fast = q.V if q.book else q.Vc
    V_ = np.where(abs(q.V) < c.VXLOW, c.VXLOW * sgn1(q.V), fast)
    q.phi = -q.phit - (1 - q.eps_g) * q.omega * sin(q.gamma) / V_
    if q.book:
        q.phi = -q.phi
    q.u = u = q.R0 * q.phi
    B_xphi = c.PDXP1 * (1 + c.PDXP2 * q.dfz) * cos(arctan(c.PDXP3 * q.kappa))
    B_yphi = c.PDYP1 * (1 + c.PDYP2 * q.dfz) * cos(arctan(c.PDYP3 * tan(q.alpha)))
    factors = {
        "zeta0": 0.0,
        "zeta1": cos(arctan(B_xphi * u)),
        "zeta2": cos(arctan(B_yphi * (abs(u) + c.PDYP4 * sqrt(abs(u))))),
        "zeta3": cos(arctan(c.PKYP1 * u**2)),
        "zeta5": cos(arctan(c.QDTP1 * u)),
        "zeta6": cos(arctan(c.QBRP1 * u)),
    }
    for name, factor in factors.items():
        setattr(q, name, np.where(q.spins, factor, 1.0))


def longitudinal(c, q):
    """Fx in pure slip, (4.E9)-(4.E18)."""
    Fz, dfz, dpi = q.Fz, q.dfz, q.dpi
    q.C_x = c.PCX1 * c.LCX
    friction = (c.PDX1 + c.PDX2 * dfz) * (1 + c.PPX3 * dpi + c.PPX4 * dpi**2) * (1 - c.PDX3 * q.gamma**2) * q.LMUX
    q.mu_x = np.where(Fz == 0, 0.0, friction)
    q.D_x = q.mu_x * Fz * q.zeta1
    pressure = 1 + c.PPX1 * dpi + c.PPX2 * dpi**2
    q.K_xkappa = Fz * (c.PKX1 + c.PKX2 * dfz) * exp(c.PKX3 * dfz) * pressure * c.LKX
    q.B_x = q.K_xkappa / (q.C_x * q.D_x + EPS * sgn1(q.D_x))
    q.S_Hx = (c.PHX1 + c.PHX2 * dfz) * c.LHX * q.rs
    q.S_Vx = Fz * (c.PVX1 + c.PVX2 * dfz) * c.LVX * q.LMUX_ * q.zeta1 * q.rs
    q.kappa_x = q.kappa + q.S_Hx
    curvature = c.PEX1 + c.PEX2 * dfz + c.PEX3 * dfz**2
    q.E_x = q.at_most_1(curvature * (1 - c.PEX4 * sign(q.kappa_x)) * c.LEX)
    q.F_x0 = (q.D_x * sin_mf(q.B_x, q.C_x, q.E_x, q.kappa_x) + q.S_Vx) * sgn1(q.V)


def lateral(c, q, gs, spinning=True):
    """Fy in pure slip at an inclination gs, (4.E19)-(4.E30), with the shift by spin (4.80)-(4.90)."""
    s = SimpleNamespace()
    Fz, dfz, dpi, Fz0_ = q.Fz, q.dfz, q.dpi, q.Fz0_
    zeta0, zeta2, zeta3 = (getattr(q, f"zeta{i}") if spinning else 1.0 for i in (0, 2, 3))
    level = c.PKY1 * Fz0_ * (1 + c.PPY1 * dpi)
    softness = (c.PKY2 + c.PKY5 * gs**2) * (1 + c.PPY2 * dpi)
    s.K_yalpha = level * (1 - c.PKY3 * abs(gs)) * sin(c.PKY4 * arctan(Fz / Fz0_ / softness)) * zeta3 * c.LKY
    s.K_ = s.K_yalpha + EPS * sgn1(s.K_yalpha)
    s.S_Vyg = Fz * (c.PVY3 + c.PVY4 * dfz) * gs * c.LKYC * q.LMUY_ * zeta2
    s.C_y = c.PCY1 * c.LCY
    mu = (c.PDY1 + c.PDY2 * dfz) * (1 + c.PPY3 * dpi + c.PPY4 * dpi**2) * (1 - c.PDY3 * gs**2) * q.LMUY
    s.D_y = mu * Fz * zeta2
    s.B_y = s.K_yalpha / (s.C_y * s.D_y + EPS * sgn1(s.D_y))
    constant = (c.PHY1 + c.PHY2 * dfz) * c.LHY
    if q.model == "mf52":
        s.S_Hy = (constant + c.PHY3 * gs * c.LKYC) * q.rs
    else:
        Kyg0 = Fz * (c.PKY6 + c.PKY7 * dfz) * (1 + c.PPY5 * dpi) * c.LKYC
        zeta4 = 1.0
        if spinning:
            zeta4 = np.where(q.spins, 1 + spin_shift(c, q, Kyg0, level) - s.S_Vyg / s.K_, 1.0)
        s.S_Hy = (constant + (Kyg0 * gs - s.S_Vyg) / s.K_ * zeta0 + zeta4 - 1) * q.rs
    s.S_Vy = (Fz * (c.PVY1 + c.PVY2 * dfz) * c.LVY * q.LMUY_ * zeta2 + s.S_Vyg) * q.rs
    s.alpha_y = q.as_ + s.S_Hy
    skew = 1 + c.PEY5 * gs**2 - (c.PEY3 + c.PEY4 * gs) * sgn1(s.alpha_y)
    s.E_y = q.at_most_1((c.PEY1 + c.PEY2 * dfz) * skew * c.LEY)
    s.F_y0 = s.D_y * sin_mf(s.B_y, s.C_y, s.E_y, s.alpha_y) + s.S_Vy
    if q.tangent:
        s.F_y0 = np.where(q.V < 0, -s.F_y0, s.F_y0)
    s.mu_y = np.where(Fz == 0, 0.0, mu)
    return s


def spin_shift(c, q, Kyg0, level):
    """Horizontal shift of Fy by spin, (4.80)-(4.89)."""
    K0 = level * sin(c.PKY4 * arctan(q.Fz / q.Fz0_ / (c.PKY2 * (1 + c.PPY2 * q.dpi)))) * q.zeta3 * c.LKY
    D = (c.PHYP2 + c.PHYP3 * q.dfz) * sign(q.V)
    B = Kyg0 / (1 - q.eps_g) / (c.PHYP1 * D * (K0 + EPS * sgn1(K0)))
    return D * sin_mf(B, c.PHYP1, q.at_most_1(c.PHYP4), q.u) * sign(q.V)


def combined(c, q):
    """Fx and Fy in combined slip, (4.E50)-(4.E67)."""
    gs, dfz = q.gs, q.dfz
    B_xa = (c.RBX1 + c.RBX3 * gs**2) * cos(arctan(c.RBX2 * q.kappa)) * c.LXAL
    E_xa = q.at_most_1(c.REX1 + c.REX2 * dfz)
    q.G_xa = cos_mf(B_xa, c.RCX1, E_xa, q.as_ + c.RHX1) / cos_mf(B_xa, c.RCX1, E_xa, c.RHX1)
    q.Fx = q.G_xa * q.F_x0

    def weight(inclination):
        shift = c.RHY1 + c.RHY2 * dfz
        E = q.at_most_1(c.REY1 + c.REY2 * dfz)
        B = (c.RBY1 + c.RBY4 * inclination**2) * cos(arctan(c.RBY2 * (q.as_ - c.RBY3))) * c.LYKA
        return cos_mf(B, c.RCY1, E, q.kappa + shift) / cos_mf(B, c.RCY1, E, shift)

    q.G_yk = weight(gs)
    q.G_yk_upright = weight(0.0)
    D = q.mu_y * q.Fz * (c.RVY1 + c.RVY2 * dfz + c.RVY3 * gs) * cos(arctan(c.RVY4 * q.as_)) * q.zeta2
    q.S_Vyk = D * sin(c.RVY5 * arctan(c.RVY6 * q.kappa)) * c.LVYKA * q.rs
    q.Fy = q.G_yk * q.F_y0 + q.S_Vyk
    q.mu_y_signed, q.mu_y = q.mu_y, abs(q.mu_y) if q.limits else q.mu_y


def aligning(c, q, upright):
    """Mz, (4.E31)-(4.E49), (4.E71)-(4.E78); Besselink A54-A60. `upright` is Fy's chapter at gamma* = 0."""
    gs, dfz, R0, Fzm = q.gs, q.dfz, q.R0, q.Fz_moment
    lean, lean_abs, lean_square = (abs(gs), abs(gs), gs**2) if q.book else (q.gamma, abs(q.gamma), q.gamma**2)
    S_Ht = c.QHZ1 + c.QHZ2 * dfz + (c.QHZ3 + c.QHZ4 * dfz) * gs
    q.alpha_t = q.as_ + S_Ht
    q.alpha_r = q.as_ + q.S_Hy + q.S_Vy / q.K_
    camber = 1 + c.QBZ5 * lean_abs + (c.QBZ6 * lean_square if q.book else c.QBZ4 * q.gamma)
    q.B_t = (c.QBZ1 + c.QBZ2 * dfz + c.QBZ3 * dfz**2) * camber * c.LKY / q.LMUY
    q.C_t = c.QCZ1
    camber = 1 + c.QDZ3 * lean + c.QDZ4 * lean_square
    q.D_t = Fzm * R0 / q.Fz0_ * (c.QDZ1 + c.QDZ2 * dfz) * (1 - c.PPZ1 * q.dpi) * camber * c.LTR * q.zeta5
    if q.book:
        q.D_t = q.D_t * sign(q.V)
    tilt = 1 + (c.QEZ4 + c.QEZ5 * gs) * 2 / pi * arctan(q.B_t * q.C_t * q.alpha_t)
    q.E_t = q.at_most_1((c.QEZ1 + c.QEZ2 * dfz + c.QEZ3 * dfz**2) * tilt)
    q.B_r = (c.QBZ9 * c.LKY / q.LMUY + c.QBZ10 * q.B_y * q.C_y) * q.zeta6
    q.zeta7, zeta8 = spin_moment(c, q)
    q.D_r = residual_peak(c, q, q.zeta0, q.zeta2) + zeta8 - 1
    alpha_t_eq, alpha_r_eq = (equivalent(q, x) for x in (q.alpha_t, q.alpha_r))
    q.trail = q.D_t * cos_mf(q.B_t, q.C_t, q.E_t, alpha_t_eq) * q.cos_a * q.rs * (1.0 if q.book else c.LFZO)
    q.M_zr = q.D_r * np.real(cos(q.zeta7 * arctan(q.B_r * alpha_r_eq))) * q.rs
    reference, inclination = (q.Fz0_, gs) if q.book else (q.Fz0, q.gamma)
    s = R0 * (c.SSZ1 + c.SSZ2 * q.Fy / reference + (c.SSZ3 + c.SSZ4 * dfz) * inclination) * c.LS
    force = q.Fy - q.S_Vyk
    if q.model != "mf52":
        force = (q.G_yk_upright if q.book else q.G_yk) * upright.F_y0
    q.Mz = -q.trail * force + q.M_zr + s * q.Fx


def equivalent(q, slip):
    """Equivalent slip of slip and kappa together, (4.E77)-(4.E78); Besselink A54-A55 with tangents."""
    both = (q.K_xkappa / q.K_ * q.kappa) ** 2
    if q.book:
        return sqrt(slip**2 + both) * sign(slip)
    return arctan(sqrt(tan(slip) ** 2 + both)) * sign(slip)


def residual_peak(c, q, zeta0, zeta2):
    """Peak of the residual moment without the part of spin, (4.E47)."""
    dfz, gs = q.dfz, q.gs
    by_camber = (c.QDZ8 + c.QDZ9 * dfz) * (1 + c.PPZ2 * q.dpi) + (c.QDZ10 + c.QDZ11 * dfz) * abs(gs)
    peak = (c.QDZ6 + c.QDZ7 * dfz) * c.LRES * zeta2 + by_camber * gs * c.LKZC * zeta0
    return q.Fz_moment * q.R0 * peak * q.LMUY * sign(q.V) * cos(q.as_)


def spin_moment(c, q):
    """zeta7 and zeta8, (4.92)-(4.104): a complex zeta7 where its acos is (tno)."""
    Fzm, R0 = q.Fz_moment, q.R0
    M_inf = c.QCRP1 * abs(q.mu_y_signed) * R0 * Fzm * sqrt(Fzm / q.Fz0_) * c.LMP
    M_inf = np.where(M_inf < 0, 1e-6, M_inf)
    D = M_inf / sin(pi / 2 * c.QDRP1)
    if q.book:
        stiffness = c.QDZ8 + c.QDZ9 * q.dfz + (c.QDZ10 + c.QDZ11 * q.dfz) * abs(q.gs)
    else:
        stiffness = c.QDZ8 * c.QDZ9 * q.dfz + c.QDZ10 + c.QDZ11 * q.dfz * abs(q.gamma)
    B = Fzm * R0 * stiffness * c.LKZC / (c.QDRP1 * D * (1 - q.eps_g))
    D_rphi = D * sin(c.QDRP1 * arctan(B * R0 * q.phit))
    M_90 = M_inf * 2 / pi * arctan(c.QCRP2 * R0 * abs(q.phit)) * q.G_yk
    if q.book:
        zeta7 = 2 / pi * np.arccos(np.clip(M_90 / (abs(D_rphi) + EPS), -1.0, 1.0))
    else:
        zeta7 = 2 / pi * np.arccos(M_90 / abs(D_rphi) + 0j)
    return np.where(q.spins, zeta7, 1.0), np.where(q.spins, 1 + D_rphi, 1.0)


def pure_moment(c, q):
    """Mz in pure side slip, (4.E31)-(4.E36): the side force at gamma* = 0 and without spin."""
    trail = q.D_t * cos_mf(q.B_t, q.C_t, q.E_t, q.alpha_t) * q.cos_a
    residual = q.D_r * np.real(cos(q.zeta7 * arctan(q.B_r * q.alpha_r))) * q.cos_a
    q.M_z0 = -trail * lateral(c, q, 0.0 * q.gs, spinning=False).F_y0 + residual


def overturning(c, q):
    """Mx, (4.E69), with the MF-Tyre manual's QSX12-QSX14; tno: fading below FZMIN."""
    gamma, Fz0 = q.gamma, q.Fz0
    Fz = q.Fz if q.book else np.where(q.Fz < c.FZMIN, q.Fz * (q.Fz / c.FZMIN) ** 2, q.Fz)
    bell = c.QSX4 * cos(c.QSX5 * arctan((c.QSX6 * Fz / Fz0) ** 2))
    wave = sin(c.QSX7 * gamma + c.QSX8 * arctan(c.QSX9 * q.Fy / Fz0))
    by_load = c.QSX1 * c.LVMX - c.QSX2 * gamma * (1 + c.PPMX1 * q.dpi) + c.QSX3 * q.Fy / Fz0 + bell * wave
    by_load = by_load + c.QSX10 * arctan(c.QSX11 * Fz / Fz0) * gamma - c.QSX12 * gamma * abs(gamma)
    q.Mx = q.R0 * c.LMX * (Fz * by_load + q.Fy * (c.QSX13 + c.QSX14 * abs(gamma)))


def rolling_resistance(c, q):
    """My, (4.E70) and Besselink A48; tno: fading near the locked wheel."""
    speed = abs(q.V / q.V0)
    m = c.QSY1 + c.QSY2 * q.Fx / q.Fz0 + c.QSY3 * speed + c.QSY4 * speed**4
    if q.book:
        Fz = level = q.Fz
    else:
        Fz = np.where(q.Fz_in < c.FZMIN, q.Fz_in * q.Fz_in / c.FZMIN, q.Fz_in)
        level = q.Fz0
    if q.model == "mf52":
        My = -q.R0 * Fz * c.LMY * m
    else:
        m = m + (c.QSY5 + c.QSY6 * Fz / q.Fz0) * q.gamma**2
        My = -q.R0 * level * c.LMY * m * (Fz / q.Fz0) ** c.QSY7 * (q.p / c.NOMPRES) ** c.QSY8
    if q.book:
        q.My = My * sign(q.V)  # no resistance at standstill
        return
    high = c.VXLOW / abs(q.V) - 1
    low = -c.VXLOW - c.VXLOW / abs(q.V)
    fading = np.where(q.kappa_in >= low, sin(pi / 2 * (1 + q.kappa_in) * abs(q.V) / c.VXLOW), -1.0)
    taper = np.where(q.kappa_in <= high, fading, 1.0)
    q.My = np.where(q.V == 0, 0.0, My * sgn1(q.V) * taper)


def softening(c, q, rho_factor, Fy):
    """How speed, forces and pressure change the vertical force, Pacejka (A3.3)."""
    by_forces = (c.Q_FCX * q.Fx / q.Fz0) ** 2 + (rho_factor * c.Q_FCY * Fy / q.Fz0) ** 2
    return (1 + c.Q_V2 * q.R0 / q.V0 * abs(q.omega) - by_forces) * (1 + c.PFZ1 * q.dpi)


def deflection_61(c, q):
    """Vertical deflection in closed form, Besselink (4), Pacejka (A3.2)-(A3.3)."""
    R0, Fz = q.R0, q.Fz_low
    QFZ1 = sqrt((c.VERTICAL_STIFFNESS * R0 / q.Fz0) ** 2 - 4 * c.Q_FZ2)
    f = softening(c, q, 1.0, q.Fy) * q.Fz0
    # The root of Q_FZ2 x^2 + QFZ1 x = Fz / f, written so that a small Q_FZ2 costs no digits.
    rho = R0 * not_negative(2 * Fz / f / (QFZ1 + sqrt(QFZ1**2 + 4 * c.Q_FZ2 * Fz / f)))
    q.R_l = not_negative(q.R_omega - rho)
    q.rho = np.where(Fz == 0, 1e-6, rho)
    q.c_z = Fz / q.rho


def not_negative(x):
    return np.where(x > 0, x, 0.0)


def deflection_62(c, q, steps=400):
    """Loaded radius at which the MF6.2 manual's vertical force is the load: the outermost root, by bisection.

    The free radius where camber alone carries more; NaN where no radius down to 0.3 of the free one carries the load.
    """
    R0, Fz0, gamma, R_omega = q.R0, q.Fz0, q.gamma, q.R_omega
    QFZ1 = sqrt((c.VERTICAL_STIFFNESS * R0 / Fz0) ** 2 - 4 * c.Q_FZ2)
    tread = (1.075 - 0.5 * c.ASPECT_RATIO) * c.WIDTH

    def deflection(R_l):
        free = not_negative(R_omega - R_l)
        camber = (c.Q_CAM1 * R_l + c.Q_CAM2 * R_l**2) * gamma / ((c.Q_CAM1 * R_omega + c.Q_CAM2 * R_omega**2) * gamma)
        by_camber = camber**2 * tread / 8 * abs(tan(gamma)) - c.Q_CAM3 * free * abs(gamma)
        return np.maximum(free + np.where(np.isnan(by_camber), 0.0, by_camber), 1e-12)

    def excess(R_l):
        rho = deflection(R_l) / R0
        S_fyg = (c.Q_FYS1 + c.Q_FYS2 * R_l / R_omega + c.Q_FYS3 * (R_l / R_omega) ** 2) * gamma
        force = softening(c, q, rho**c.Q_FCY2, q.Fy - S_fyg) * (QFZ1 * rho + c.Q_FZ2 * rho**2) * Fz0
        return force - q.Fz_in

    # The root lies just outside the first grid radius, going inwards, that carries the load.
    lower, upper = np.full_like(R_omega, np.nan), R_omega.copy()
    for share in np.linspace(1.0, 0.3, steps + 1)[1:]:
        inner = share * R_omega
        carries = np.isnan(lower) & (excess(inner) >= 0)
        lower = np.where(carries, inner, lower)
        upper = np.where(np.isnan(lower), inner, upper)
    for _ in range(60):
        middle = (lower + upper) / 2
        inside = excess(middle) >= 0
        lower, upper = np.where(inside, middle, lower), np.where(inside, upper, middle)
    q.R_l = np.where(excess(R_omega) >= 0, R_omega, (lower + upper) / 2)
    q.rho = np.where(q.Fz == 0, 1e-6, np.where(np.isnan(q.R_l), np.nan, deflection(q.R_l)))
    q.c_z = q.Fz / q.rho


def contact_patch(c, q):
    """Half length and half width, Besselink (9)-(10) or the MF-Tyre 5.2 manual; no longer once the rim touches."""
    h = q.R0 - c.RIM_RADIUS - c.BOTTOM_OFFST
    Fz = np.where(q.Fz_in / q.c_z0 > h, h * q.c_z0, q.Fz_in)
    if q.model == "mf52":
        y = np.log10(q.R0 * c.VERTICAL_STIFFNESS / q.Fz0)
        Q_A1, Q_A2 = c.Q_A1, c.Q_A2
        if Q_A1 == 0 and Q_A2 == 0:
            Q_A1 = -0.0388 * y**3 + 0.2509 * y**2 - 0.6283 * y + 0.6279
            Q_A2 = 1.693 * Q_A1**2
        q.a = q.R0 * (Q_A2 * Fz / q.Fz0 + Q_A1 * sqrt(Fz / q.Fz0))
        q.b = c.WIDTH / 2
    else:
        w = Fz / (q.c_z0 * q.R0)
        q.a = q.R0 * (c.Q_RA2 * w + c.Q_RA1 * sqrt(w))
        q.b = c.WIDTH * (c.Q_RB2 * w + c.Q_RB1 * w ** (1 / 3))


def carcass(c, q):
    """Stiffnesses of the standing tire and relaxation lengths, Besselink (17)-(19) or the MF-Tyre 5.2 manual."""
    dfz, dpi = q.dfz, q.dpi
    q.c_x = c.LONGITUDINAL_STIFFNESS * (1 + c.PCFX1 * dfz + c.PCFX2 * dfz**2) * (1 + c.PCFX3 * dpi)
    q.c_y = c.LATERAL_STIFFNESS * (1 + c.PCFY1 * dfz + c.PCFY2 * dfz**2) * (1 + c.PCFY3 * dpi)
    if q.model == "mf52":
        q.sigma_x = (c.PTX1 + c.PTX2 * dfz) * exp(-c.PTX3 * dfz) * c.LSGKP * q.R0 * q.Fz / q.Fz0
        lean = 1 - c.PKY3 * abs(q.gamma)
        q.sigma_y = c.PTY1 * sin(2 * arctan(q.Fz / (c.PTY2 * q.Fz0_))) * lean * q.R0 * c.LFZO * c.LSGAL
    else:
        q.sigma_x = abs(q.K_xkappa / q.c_x)
        q.sigma_y = abs(q.K_yalpha / q.c_y)
