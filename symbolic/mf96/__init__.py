"""MF96: the Magic Formula of 1996 exactly as the Trento team's worksheet generated it."""

from ..model import Model
from ..quantities import ALPHA, FX, FY, FZ, GAMMA, KAPPA, MZ
from . import aligning_moment, combined_slip, longitudinal_force, normalized, side_force
from .coefficients import SECTIONS

MF96 = Model(
    name="mf96",
    title="Magic Formula 1996, Trento form",
    inputs=(KAPPA, ALPHA, GAMMA, FZ),
    outputs=(FX, FY, MZ),
    sections=SECTIONS,
    chapters=tuple(
        module.eq for module in (normalized, longitudinal_force, side_force, combined_slip, aligning_moment)
    ),
)
