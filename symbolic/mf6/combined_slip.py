"""Forces in combined slip. Pacejka (2012), eqs. (4.E50)-(4.E67)."""

from __future__ import annotations

from sympy import Expr, Symbol, atan, cos, sin

from ..effects import camber_combined, combined_Gxa, combined_Gyk, kappa_sideforce_SVyk
from ..notation import Chapter, magic
from .coefficients.forces import Lateral as py
from .coefficients.forces import Longitudinal as px
from .coefficients.scaling import Scaling as s
from .inputs import Fz, at_most_1, kappa, on_ground, rs
from .longitudinal_force import Fx0
from .normalized import alphas, dfz, gammas
from .side_force import muy_at, with_camber
from .turn_slip import zeta2

eq = Chapter("Forces, combined slip")

# fmt: off


def weighting(name: str, B: Expr, C: Expr, E: Expr, x: Expr, SH: Expr) -> Expr:
    """Return the weighting function G, 1 at zero slip: eqs. (4.E51)-(4.E53) and (4.E59)-(4.E61)."""
    return magic(eq, name, B, C, 1, E, x + SH).cosine / magic(eq, f"{name}0", B, C, 1, E, SH).cosine


def stiffness_ykappa(gammas: Expr, at: str, named: bool) -> Symbol:
    """File B_ykappa, eq. (4.E62)."""
    return eq("4.E62", "B_ykappa",
              combined_Gyk.term((py.RBY1 + camber_combined.term(py.RBY4*gammas**2))
                                * cos(atan(py.RBY2 * (alphas - py.RBY3))) * s.LYKA),
              "1", "stiffness of G_yk", named=named, at=at)


Bxa  = eq("4.E54", "B_xalpha",
          combined_Gxa.term((px.RBX1 + camber_combined.term(px.RBX3*gammas**2))
                            * cos(atan(px.RBX2*kappa)) * s.LXAL),
          "1/rad", "stiffness of G_xa")
Exa  = eq("4.E56", "E_xalpha",
          at_most_1(combined_Gxa.term(px.REX1 + px.REX2*dfz)),
          "1", "curvature of G_xa")
Cxa  = eq("4.E55", "C_xalpha",
          px.RCX1,
          "1", "shape of G_xa")
Gxa  = eq("4.E51", "G_xa",
          combined_Gxa.factor(weighting("G_xa", Bxa, Cxa, Exa, alphas, px.RHX1)),
          "1", "weighting of Fx by side slip")
SHyk = eq("4.E65", "S_Hyk",
          combined_Gyk.term(py.RHY1 + py.RHY2*dfz),
          "1", "shift of G_yk", named=False)
Eyk  = eq("4.E64", "E_ykappa",
          at_most_1(combined_Gyk.term(py.REY1 + py.REY2*dfz)),
          "1", "curvature of G_yk")
Cyk  = eq("4.E63", "C_ykappa",
          py.RCY1,
          "1", "shape of G_yk")
Byk  = stiffness_ykappa(gammas, "", named=True)
Gyk  = eq("4.E59", "G_yk",
          combined_Gyk.factor(weighting("G_yk", Byk, Cyk, Eyk, kappa, SHyk)),
          "1", "weighting of Fy by longitudinal slip")
DVyk = eq("4.E67", "D_Vyk",
          kappa_sideforce_SVyk.term(
              muy_at * Fz * (py.RVY1 + py.RVY2*dfz + py.RVY3*gammas) * cos(atan(py.RVY4*alphas)) * zeta2),
          "N", "peak of S_Vyk")
SVyk = eq("4.E66", "S_Vyk",
          kappa_sideforce_SVyk.term(DVyk * sin(py.RVY5 * atan(py.RVY6*kappa)) * s.LVYKA * rs),
          "N", "side force made by longitudinal slip")
Fx   = eq("4.E50", "Fx",
          on_ground(Gxa * Fx0),
          "N", "longitudinal force")
Fy   = eq("4.E58", "Fy",
          on_ground(Gyk * with_camber.Fy0 + SVyk),
          "N", "side force")
