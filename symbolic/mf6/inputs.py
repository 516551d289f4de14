"""The inputs of the lines: as given, or within limits.

With the option limits the order is MFeval's: slips fade out below VXLOW, then everything is limited to the
ranges of the .tir file (the load from above only). Some lines use the inputs before that, as their chapters state.
"""

from __future__ import annotations

from sympy import Expr, Float, Symbol, cos, pi, tan

from ..functions import absolute, where
from ..notation import Chapter
from ..options import limits
from ..quantities import ALPHA, FZ, GAMMA, KAPPA, PHIT, P, V
from .coefficients.body import InclinationRange, LoadRange, LongSlipRange, Model, PressureRange, SlipAngleRange

eq = Chapter("Inputs")
#: Below this load there is no contact, N.
LIFT_OFF = Float("1e-6")
speed = absolute(V.symbol)

# fmt: off


def within(name: str, unit: str, x: Expr, lower: Symbol, upper: Symbol) -> Symbol:
    """File x, limited to two bounds with the option limits, and return its symbol."""
    raised = eq("MFeval", f"{name}_raised",
                limits.either(x, where(x < lower, lower, x)),
                unit, f"{name}, with limits not below the lowest", named=False)
    return eq("MFeval", f"{name}_in",
              limits.either(raised, where(raised > upper, upper, raised)),
              unit, f"{name}, within limits", named=False)


VXLOW = eq("tirefmu", "V_xlow",
           where(Model.VXLOW <= 0, Float("1e-6"), Model.VXLOW),
           "m/s", "speed below which slips fade out, above 0", named=False)
fade  = eq("MFeval", "fade",
           limits.either(1, where(speed <= VXLOW, speed / VXLOW, 1)),
           "1", "reduction of kappa and phit at low speed", named=False)
rs    = eq("MFeval", "fade_smooth",
           limits.either(1, where(speed <= VXLOW, (1 - cos(pi * V.symbol / VXLOW)) / 2, 1)),
           "1", "reduction of the shifts, the trail and the residual moment at low speed", named=False)
phit  = eq("MFeval", "phit_in",
           limits.either(PHIT.symbol, PHIT.symbol * cos(ALPHA.symbol) * fade * where(V.symbol < 0, -1, 1)),
           "1/m", "turn slip, within limits", named=False)
speed_sum = eq("MFeval", "speed_sum",
               limits.either(1, speed + absolute(V.symbol * tan(ALPHA.symbol))),
               "m/s", "rolling and sliding speed", named=False)
alpha_low = eq("MFeval", "alpha_low",
               limits.either(ALPHA.symbol,
                             where(speed_sum < VXLOW, ALPHA.symbol * speed_sum / VXLOW, ALPHA.symbol)),
               "rad", "slip angle, faded out at low speed", named=False)
kappa = within("kappa", "1", KAPPA.symbol * fade, LongSlipRange.KPUMIN, LongSlipRange.KPUMAX)
alpha = within("alpha", "rad", alpha_low, SlipAngleRange.ALPMIN, SlipAngleRange.ALPMAX)
gamma = within("gamma", "rad", GAMMA.symbol, InclinationRange.CAMMIN, InclinationRange.CAMMAX)
p     = within("p", "Pa", P.symbol, PressureRange.PRESMIN, PressureRange.PRESMAX)
Fz_in = eq("MFeval", "F_z",
           where(FZ.symbol < LIFT_OFF, 0, FZ.symbol),
           "N", "load, 0 off the ground", named=False)
Fz    = eq("MFeval", "F_z_limited",
           limits.either(Fz_in, where(Fz_in > LoadRange.FZMAX, LoadRange.FZMAX, Fz_in)),
           "N", "load, within limits", named=False)
Fzl   = eq("MFeval", "F_zl",
           limits.either(Fz, where(Fz < LoadRange.FZMIN, LoadRange.FZMIN, Fz)),
           "N", "load of the deflection, not below FZMIN with limits", named=False)
Fzm   = eq("MFeval", "F_zm",
           limits.either(Fz, where(Fz <= 0, 0, Fzl)),
           "N", "load of the aligning moment, the same but on the ground", named=False)


def at_most_1(E: Expr) -> Expr:
    """Return a curvature factor, at most 1 with the option limits."""
    return limits.either(E, where(E > 1, 1, E))


def on_ground(expression: Expr) -> Expr:
    """Return the expression, 0 without load (a load of NaN gives NaN)."""
    return where(FZ.symbol < LIFT_OFF, 0, expression)
