"""Deflection, loaded radius and vertical stiffness. Besselink et al. (2010), eqs. (3)-(5); MF6.2: MF-Tyre manual.

MF5.2 and MF6.1 have a closed form, linear where the quadratic term Q_FZ2 is 0. MF6.2 balances the load of the
camber-deflected contour: a secant from that closed form, a fixed number of steps. If the camber deflection alone
carries more than the load, there is no balance, and R_l is the free radius. c_z is load per deflection, a secant
stiffness.
"""

from __future__ import annotations

from sympy import Eq, Expr, Float, Or, Symbol, tan

from ..functions import absolute, root, where
from ..notation import Chapter, only
from .coefficients.body import Dimension, Model
from .coefficients.body import Vertical as v
from .combined_slip import Fx, Fy
from .inputs import Fz, Fz_in, Fzl, gamma
from .normalized import dpi
from .rolling_radius import Romega, omega

eq = Chapter("Deflection and loaded radius")
R0, Fz0 = Dimension.UNLOADED_RADIUS, v.FNOMIN

#: Steps of the secant for the loaded radius of MF6.2.
STEPS = 8
#: The value that MFeval uses for no deflection.
NO_DEFLECTION = Float("1e-6")
#: The largest deflection per radius: beyond any rim.
DEEPEST = Float("0.95")
#: The smallest deflection of MF6.2.
MIN_DEFLECTION = Float("1e-12")

# fmt: off
firmness = eq("P 4", "c_z_normalized",
             v.VERTICAL_STIFFNESS * R0 / Fz0,
             "1", "vertical stiffness in nominal loads per radius", named=False)
stiff  = eq("P 4", "Q_FZ1_squared",
            firmness**2 - 4 * v.Q_FZ2,
            "1", "linear coefficient of load over deflection, squared", named=False)
QFZ1   = eq("P 4", "Q_FZ1",
            root(stiff),
            "1", "linear coefficient of load over deflection", named=False)
faster = 1 + v.Q_V2 * R0 / Model.LONGVL * absolute(omega) - (v.Q_FCX * Fx / Fz0)**2
firm   = eq("P 3", "f_z",
            (faster - (v.Q_FCY * Fy / Fz0)**2) * (1 + v.PFZ1*dpi) * Fz0,
            "N", "scale of the load by speed, forces and pressure", named=False)
bent   = eq("P 3", "rho_root",
            QFZ1**2 + 4 * v.Q_FZ2 * Fzl / firm,
            "1", "discriminant", named=False)
rooted = eq("P 3", "rho_sqrt",
            root(bent),
            "1", "its root", named=False)
closed = eq("P 3", "rho_closed",
            where(Eq(v.Q_FZ2, 0), R0 * Fzl / (firm * QFZ1), R0 * ((rooted - QFZ1) / (2 * v.Q_FZ2))),
            "m", "deflection of the upright tire", named=False)
upright = eq("P 3", "rho_upright",
             where(closed > 0, closed, 0),
             "m", "deflection of the upright tire, not below 0", named=False)

tread  = eq("M", "r_tw",
            (1.075 - Dimension.ASPECT_RATIO / 2) * Dimension.WIDTH,
            "m", "width of the tread", named=False)
crown  = eq("M", "crown",
            v.Q_CAM1*Romega + v.Q_CAM2*Romega**2,
            "1", "camber deflection of the free radius", named=False)


def balance(sunk: Expr, k: int | str) -> tuple[Symbol, Symbol]:
    """File the deflection and the load of MF6.2 at a loaded radius; sunk is the free radius less the loaded radius."""
    Rl     = eq("M", f"R_l_{k}",
                Romega - sunk,
                "m", "loaded radius", named=False)
    leant  = eq("M", f"rho_gamma_{k}",
                where(Eq(crown, 0), 0, ((v.Q_CAM1*Rl + v.Q_CAM2*Rl**2) / crown)**2 * tread / 8 * absolute(tan(gamma))
                                       - v.Q_CAM3 * sunk * absolute(gamma)),
                "m", "camber deflection", named=False)
    rho    = eq("M", f"rho_{k}",
                where(sunk + leant < MIN_DEFLECTION, MIN_DEFLECTION, sunk + leant),
                "m", "deflection", named=False)
    thrust = eq("M", f"S_fygamma_{k}",
                (v.Q_FYS1 + v.Q_FYS2*Rl/Romega + v.Q_FYS3*(Rl/Romega)**2) * gamma,
                "N", "side force of inclination", named=False)
    fc     = eq("M", f"f_c_{k}",
                (faster - ((rho / R0)**v.Q_FCY2 * v.Q_FCY * (Fy - thrust) / Fz0)**2) * (1 + v.PFZ1*dpi),
                "1", "correction by speed, forces and pressure", named=False)
    load   = eq("M", f"F_z62_{k}",
                fc * (QFZ1 * rho / R0 + v.Q_FZ2 * (rho / R0)**2) * Fz0,
                "N", "load carried", named=False)
    return rho, load


def secant(before: Expr, load_before: Symbol, at: Symbol) -> tuple[Symbol, Symbol]:
    """File secant steps towards the balance of load; return what the tire has sunk and its deflection."""
    rho, load = balance(at, 0)
    for k in range(STEPS):
        rise  = eq("M", f"F_z62_{k}_rise",
                   where(Eq(load, load_before), 1, load - load_before),
                   "N", "what the last step changed in the load", named=False)
        moved = eq("M", f"sunk_{k}_moved",
                   at - (load - Fz_in) * (at - before) / rise,
                   "m", "step of the secant", named=False)
        above = eq("M", f"sunk_{k}_above",
                   where(moved > 0, moved, at / 2),
                   "m", "the same, limited to positive values", named=False)
        before, load_before = at, load
        at    = eq("M", f"sunk_{k + 1}",
                   where(above > DEEPEST * R0, DEEPEST * R0, above),
                   "m", "free radius less loaded radius", named=False)
        rho, load = balance(at, k + 1)
    return at, rho


sunk_0 = eq("M", "sunk_free",
            0,
            "m", "nothing sunk", named=False)
rho_0, load_0 = balance(sunk_0, "free")
_, load_near = balance(upright * Float("0.9"), "near")
balanced, rho_balanced = secant(upright * Float("0.9"), load_near, upright)
floats = load_0 >= Fz_in
sunk   = eq("A3.2", "sunk",
            only("mf62", where(floats, 0, balanced), upright),
            "m", "free radius less loaded radius", named=False)
Rl     = eq("A3.2", "R_l",
            where(Romega > sunk, Romega - sunk, 0),
            "m", "loaded radius")
rho_   = eq("A3.3", "rho_pressed",
            only("mf62", where(floats, rho_0, rho_balanced), upright),
            "m", "deflection", named=False)
rho    = eq("A3.3", "rho",
            where(Or(Eq(only("mf62", Fz, Fzl), 0), rho_ <= 0), NO_DEFLECTION, rho_),
            "m", "deflection")
cz     = eq("A3.3", "c_z",
            only("mf62", Fz, Fzl) / rho,
            "N/m", "vertical stiffness, load per deflection")
