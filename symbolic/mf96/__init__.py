"""MF96: the Magic Formula of 1996 exactly as the Trento team's worksheet generated it."""

from ..contract import FitDeclaration, Motion, PropertyFile, Role, curvature, positive, with_extrapolation
from ..magic_formula import BASELINE, ROLES, force_constraints
from ..model import Model, Source
from ..quantities import ALPHA, FX, FY, FZ, GAMMA, KAPPA, MZ
from .coefficients import SECTIONS

CONSTRAINTS = with_extrapolation(
    force_constraints(pressure=False)
    | {"Mz": (positive("C_t", 0.1), positive("B_t", 0.1, "Fz", "gamma"), curvature("E_t", "Fz", "gamma", "alpha"))}
)
CHAPTERS = ("normalized", "longitudinal_force", "side_force", "combined_slip", "aligning_moment")
MF96 = Model(
    name="mf96",
    title="Magic Formula 1996, Trento form",
    inputs=(KAPPA, ALPHA, GAMMA, FZ),
    outputs=(FX, FY, MZ),
    sections=SECTIONS,
    source=Source(CHAPTERS, folder=__name__),
    roles=ROLES | {"slope_x": Role("F_x0_slope"), "slope_y": Role("F_y0_slope")},
    # There is no public number for the Trento form; only tirefmu writes its files.
    property_file=PropertyFile(fittyp=(96,), strict=True),
    fit=FitDeclaration(CONSTRAINTS, recipe="progressive"),
    baseline=BASELINE,
    motion=Motion(friction_scales=("LMUX", "LMUY")),
)
MODELS = (MF96,)
