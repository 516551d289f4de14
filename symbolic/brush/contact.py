"""Forces and aligning moment of bristles on a contact patch with parabolic pressure. Pacejka (2012), section 3.2.

Numbers of lines are the book's sections. A bristle enters the patch at the leading edge undeflected and deflects in
proportion to slip and distance until its force reaches the local friction limit; from there to the trailing edge it
slides. The integrals over both parts have a closed form in psi, the share of the patch that slides.

The book has one stiffness and one friction coefficient. Here they may differ by axis: the limit of a bristle's force is
the ellipse with the half axes mu_x q_z and mu_y q_z, and a sliding bristle's force is the point of the ellipse that
dissipates most, (mu_x^2 v_x, mu_y^2 v_y) / |(mu_x v_x, mu_y v_y)| q_z for the sliding velocity v. With equal
frictions it opposes the sliding velocity; with equal stiffnesses too, the lines are those of the book:
F = mu Fz (3 psi - 3 psi^2 + psi^3) and trail = a/3 (1 - psi)^3 / (1 - psi + psi^2/3).

Inclination and turn slip are neglected, and so is the moment that Fx has about the laterally deflected patch.
"""

from __future__ import annotations

from sympy import Expr, Float, sqrt, tan

from ..effects import load_friction
from ..functions import SMALLEST_SQUARE, absolute, root, where
from ..notation import Chapter
from ..options import signs
from ..quantities import ALPHA, FZ, KAPPA
from .coefficients import Brush as c
from .coefficients import Vertical
from .effects import load_patch, load_stiffness

eq = Chapter("Contact patch with bristles")
kappa = KAPPA.symbol

#: Below this load the lines are evaluated at it, so that they remain finite; the forces are 0.
LIFT_OFF = Float("1e-6")
#: A wheel nearer to lock than this is computed at this distance from it: the whole patch slides.
LOCKED = Float("1e-6")


def on_ground(expression: Expr) -> Expr:
    """Return the expression, 0 without load (a load of NaN gives NaN)."""
    return where(FZ.symbol <= LIFT_OFF, 0, expression)


# fmt: off
Fz      = eq("tirefmu", "F_z",
             where(FZ.symbol <= LIFT_OFF, LIFT_OFF, FZ.symbol),
             "N", "load, limited to positive values", named=False)
ratio   = eq("tirefmu", "load_ratio",
             Fz / Vertical.FNOMIN,
             "1", "load per nominal load", named=False)
kratio  = eq("tirefmu", "stiffness_ratio",
             load_stiffness.either(ratio**c.NSTIFF, ratio),
             "1", "slip stiffness per that at nominal load", named=False)
muratio = eq("tirefmu", "friction_ratio",
             load_friction.factor(ratio**c.NMU),
             "1", "friction per that at nominal load", named=False)
mux     = eq("tirefmu", "mu_x",
             c.MUX * muratio,
             "1", "longitudinal friction")
muy     = eq("tirefmu", "mu_y",
             c.MUY * muratio,
             "1", "lateral friction")
side    = eq("tirefmu", "side",
             signs.either(-1, 1),
             "1", "sign of Fy at a positive slip angle: -1 in ISO", named=False)
Kxk     = eq("3.2.2", "K_xkappa",
             c.CKAPPA * kratio,
             "N", "longitudinal slip stiffness")
Kya     = eq("3.2.1", "K_yalpha",
             side * c.CALPHA * kratio,
             "N/rad", "cornering stiffness")
a       = eq("tirefmu", "a",
             c.PATCH * load_patch.either(ratio**c.NPATCH, sqrt(ratio)),
             "m", "half length of the contact patch")

vy      = eq("3.2.3", "tan_alpha",
             tan(ALPHA.symbol),
             "1", "lateral sliding velocity of the wheel per forward velocity", named=False)
rolling = eq("3.2.3", "rolling",
             where(absolute(1 + kappa) < LOCKED, LOCKED, absolute(1 + kappa)),
             "1", "rolling velocity per forward velocity, limited to positive values", named=False)
slipx   = eq("3.2.3", "slip_x",
             kappa / rolling,
             "1", "theoretical longitudinal slip: sliding per rolling velocity")
slipy   = eq("3.2.3", "slip_y",
             vy / rolling,
             "1", "theoretical side slip: sliding per rolling velocity")
reachx  = eq("3.2.3", "reach_x",
             Kxk * slipx / (3*mux*Fz),
             "1", "psi of the longitudinal slip alone", named=False)
reachy  = eq("3.2.3", "reach_y",
             Kya * slipy / (3*muy*Fz),
             "1", "psi of the side slip alone", named=False)
square  = eq("3.2.3", "psi_squared",
             reachx**2 + reachy**2,
             "1", "psi squared, beyond full sliding too", named=False)
bounded = eq("3.2.3", "psi_bounded",
             where(square >= 1, 1, square),
             "1", "psi squared", named=False)
psi     = eq("3.2.3", "psi",
             root(bounded),
             "1", "share of the contact patch that slides")
squares = eq("tirefmu", "sliding_squared",
             (mux*kappa)**2 + (muy*vy)**2,
             "1", "sliding velocity weighted with friction, squared", named=False)
slides  = eq("tirefmu", "sliding",
             where(squares <= SMALLEST_SQUARE, 0, Fz * psi**2 * (3 - 2*psi) / sqrt(squares)),
             "N", "load on the sliding part per weighted sliding velocity", named=False)
sticks  = eq("3.2.3", "sticking",
             (1 - psi)**2 / rolling,
             "1", "share of the slip stiffness on the sticking part, per rolling velocity", named=False)
stick   = eq("3.2.3", "F_y_sticking",
             Kya * sticks,
             "N", "side force of the sticking part per tan(alpha)", named=False)
slide   = eq("3.2.3", "F_y_sliding",
             side * muy**2 * slides,
             "N", "side force of the sliding part per tan(alpha)", named=False)
Fx      = eq("3.2.3", "Fx",
             on_ground(kappa * (Kxk*sticks + mux**2*slides)),
             "N", "longitudinal force")
Fy      = eq("3.2.3", "Fy",
             on_ground(vy * (stick + slide)),
             "N", "side force")
Dt      = eq("3.2.1", "D_t",
             a / 3,
             "m", "pneumatic trail at zero slip")
behind  = eq("3.2.1", "arm_sliding",
             9 * (1 - psi)**2 / (3 - 2*psi),
             "1", "arm of the sliding part per trail at zero slip", named=False)
t       = eq("3.2.1", "trail",
             Dt * (stick*(1 - 4*psi) + slide*behind) / (stick + slide),
             "m", "pneumatic trail")
Mz      = eq("3.2.1", "Mz",
             -t * Fy,
             "N m", "aligning moment")
