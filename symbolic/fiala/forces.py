"""The lines of the Fiala tire. Adams/Tire help, "Using the Fiala Handling Force Model"; Chrono, ChFialaTire.cpp.

Friction decreases from UMAX to UMIN with the comprehensive slip. Only this couples the axes: |Fx| and |Fy| each stay
within mu Fz, their resultant within sqrt(2) mu Fz. The longitudinal force is linear up to half of the friction, the
side force is cubic up to the critical slip angle. Inclination produces no force.

The form differs from the sources: the forces are odd functions of one argument, without a quotient by the slip at zero.
The argument of the side force is limited to -1 and 1, so that its cubic ends in full sliding.
"""

from __future__ import annotations

from sympy import Expr, Float, atan, tan

from ..effects import relax_lat, relax_lon, rolling_resistance_My
from ..functions import absolute, root, sgn, where
from ..notation import Chapter
from ..options import signs
from ..quantities import ALPHA, FZ, KAPPA, V
from .coefficients import Dimension
from .coefficients import Parameter as p

eq = Chapter("Fiala tire")
kappa, load = KAPPA.symbol, FZ.symbol

#: Below this load the lines are evaluated at it, so that they remain finite; the forces are 0 (no contact).
LIFT_OFF = Float("1e-6")


def on_ground(expression: Expr) -> Expr:
    """Return the expression, 0 without load (a load of NaN gives NaN)."""
    return where(load <= LIFT_OFF, 0, expression)


# fmt: off
Fz     = eq("tirefmu", "F_z",
            where(load <= LIFT_OFF, LIFT_OFF, load),
            "N", "load, limited to positive values", named=False)
side   = eq("tirefmu", "sense",
            signs.either(-1, 1),
            "1", "sense of the side force at positive slip angle: -1 in ISO, 1 in adapted SAE", named=False)
slope  = eq("tirefmu", "tan_alpha",
            tan(ALPHA.symbol),
            "1", "tangent of the side slip angle", named=False)

square = eq("Adams", "S_square",
            kappa**2 + slope**2,
            "1", "comprehensive slip, squared", named=False)
inside = eq("tirefmu", "S_square_inside",
            where(square >= 1, 1, square),
            "1", "the same, 1 at most", named=False)
S      = eq("Adams", "S_s_alpha",
            root(inside),
            "1", "comprehensive slip, 1 at most")
fall   = eq("Adams", "U_fall",
            p.UMAX - p.UMIN,
            "1", "friction that is lost at comprehensive slip 1", named=False)
U      = eq("Adams", "U",
            p.UMAX - fall * S,
            "1", "friction at this comprehensive slip")
mux    = eq("Adams", "mu_x",
            U,
            "1", "largest |Fx| per load at this comprehensive slip")
muy    = eq("Adams", "mu_y",
            U,
            "1", "largest |Fy| per load at this comprehensive slip")

eq("Adams", "mu_x_fall",
   fall,
   "1", "what mu_x loses up to comprehensive slip 1")
eq("Adams", "mu_y_fall",
   fall,
   "1", "what mu_y loses up to comprehensive slip 1")

Kxk    = eq("Adams", "K_xkappa",
            p.CSLIP,
            "N", "longitudinal slip stiffness")
limitx = eq("Adams", "F_x_limit",
            mux * Fz,
            "N", "largest longitudinal force", named=False)
pullx  = eq("Adams", "F_x_linear",
            Kxk * kappa,
            "N", "longitudinal force without sliding", named=False)
eq("Adams", "kappa_crit",
   absolute(limitx / (2 * Kxk)),
   "1", "critical slip, up to which Fx is linear")
Fx     = eq("Adams", "Fx",
            on_ground(where(absolute(pullx) <= limitx / 2, pullx,
                            sgn(pullx) * limitx - limitx**2 / (4 * pullx))),
            "N", "longitudinal force")

Kya    = eq("Adams", "K_yalpha",
            side * p.CALPHA,
            "N/rad", "cornering stiffness")
limity = eq("Adams", "F_y_limit",
            muy * Fz,
            "N", "largest side force", named=False)
pully  = eq("Adams", "F_y_linear",
            Kya * slope,
            "N", "side force without sliding", named=False)
eq("Adams", "alpha_crit",
   atan(absolute(3 * limity / Kya)),
   "rad", "critical slip angle, from which the whole contact slides")
slid   = eq("Adams", "sliding_y",
            where(absolute(pully) >= 3 * limity, sgn(pully), pully / (3 * limity)),
            "1", "1 - H with the sense of the side force: share of the contact that slides", named=False)
Fy     = eq("Adams", "Fy",
            on_ground(limity * slid * (3 - 3 * absolute(slid) + slid**2)),
            "N", "side force")
trail  = eq("Adams", "t_0",
            Dimension.WIDTH / 3,
            "m", "pneumatic trail at zero slip")
Mz     = eq("Adams", "Mz",
            on_ground(-3 * trail * limity * slid * (1 - absolute(slid))**3),
            "N m", "aligning moment")
My     = eq("Adams", "My",
            on_ground(rolling_resistance_My.term(side * p.ROLLING_RESISTANCE * Fz * sgn(V.symbol))),
            "N m", "rolling resistance moment")

lag_x  = eq("Adams", "sigma_kappa",
            relax_lon.term(p.REL_LEN_LON),
            "m", "relaxation length that acts on kappa")
lag_y  = eq("Adams", "sigma_alpha",
            relax_lat.term(p.REL_LEN_LAT),
            "m", "relaxation length that acts on tan(alpha)")
sunk   = eq("Adams", "rho",
            on_ground(Fz / p.VERTICAL_STIFFNESS),
            "m", "deflection of the standing tire")
Rl     = eq("Adams", "R_l",
            where(sunk < Dimension.UNLOADED_RADIUS, Dimension.UNLOADED_RADIUS - sunk, 0),
            "m", "loaded radius of the standing tire")
damp   = eq("Adams", "d_z",
            p.VERTICAL_DAMPING,
            "N s/m", "vertical damping, which a host needs that computes the load")
camber = eq("Adams", "C_gamma",
            p.CGAMMA,
            "N/rad", "camber stiffness of the file, which the model does not use")
