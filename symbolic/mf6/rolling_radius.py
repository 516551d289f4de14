"""Effective rolling radius and wheel speed. Besselink et al. (2010), eqs. (1), (5), (7).

kappa, omega and R_e depend on each other. MFeval iterates until the first row of a table no longer changes. This takes
three iterations if Q_V1 is not 0. Here three iterations are written out, so rows do not influence each other:
omega = (1 + kappa) V / R_e with the R_e of the second iteration. Load and kappa are used before limits apply.
"""

from __future__ import annotations

from sympy import Expr, Float, Symbol, atan

from ..notation import Chapter
from ..quantities import KAPPA, V
from .coefficients.body import Dimension, Model
from .coefficients.body import Vertical as v
from .inputs import Fz_in
from .normalized import dpi

eq = Chapter("Effective rolling radius")
R0 = Dimension.UNLOADED_RADIUS

# fmt: off
czn   = eq("P 5", "c_zn",
           v.VERTICAL_STIFFNESS * (1 + v.PFZ1*dpi),
           "N/m", "vertical stiffness at this pressure", named=False)
sink  = eq("P 7", "sink",
           v.FNOMIN / czn * (v.DREFF * atan(v.BREFF*Fz_in/v.FNOMIN) + v.FREFF*Fz_in/v.FNOMIN),
           "m", "by how much load lowers the effective radius", named=False)


def round_the_ring(Re: Expr, step: str, named: bool) -> tuple[Symbol, Symbol, Symbol]:
    """File wheel speed, free radius and effective radius that follow from an effective radius."""
    omega  = eq("2.5", f"omega{step}",
                (1 + KAPPA.symbol) * V.symbol / Re,
                "rad/s", "wheel speed", named=named)
    Romega = eq("P 1", f"R_omega{step}",
                R0 * (v.Q_RE0 + v.Q_V1 * (omega * R0 / Model.LONGVL)**2),
                "m", "free radius of the turning wheel", named=named)
    return omega, Romega, eq("P 7", f"R_e{step}",
                             Romega - sink,
                             "m", "effective rolling radius", named=named)


_, _, Re = round_the_ring(Float("0.965") * R0, "_1", False)
_, _, Re = round_the_ring(Re, "_2", False)
omega, Romega, Re = round_the_ring(Re, "", True)
