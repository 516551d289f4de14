"""The brush model: bristles on a contact patch with parabolic pressure, Pacejka (2012), chapter 3.

Eight physical coefficients; five of them describe a tire at one load. It suits few data points and control design.
"""

from ..contract import (
    Baseline,
    FitDeclaration,
    Motion,
    PropertyFile,
    Role,
    friction_falling,
    positive,
    stiffness_saturating,
    with_extrapolation,
)
from ..model import Model, Source
from ..quantities import ALPHA, FX, FY, FZ, KAPPA, MZ
from .coefficients import SECTIONS
from .effects import load_patch, load_stiffness

CONSTRAINTS = with_extrapolation(
    {
        "Fx": (
            positive("mu_x", 0.01, "Fz"),
            positive("K_xkappa", 1.0, "Fz", size=1e4),
            friction_falling("mu_x", "Fz"),
            stiffness_saturating("K_xkappa", "Fz", on_request=True),
        ),
        "Fy": (
            positive("mu_y", 0.01, "Fz"),
            positive("K_yalpha", 1.0, "Fz", size=1e4),
            friction_falling("mu_y", "Fz"),
            stiffness_saturating("K_yalpha", "Fz"),
        ),
        "Mz": (positive("a", 1e-3, "Fz"),),
    }
)
BRUSH = Model(
    name="brush",
    title="Brush model with parabolic pressure",
    inputs=(KAPPA, ALPHA, FZ),
    outputs=(FX, FY, MZ),
    sections=SECTIONS,
    source=Source(("contact",), folder=__name__, own_effects=(load_stiffness, load_patch)),
    roles={
        "friction_x": Role("mu_x", ("MUX",)),
        "friction_y": Role("mu_y", ("MUY", "NMU")),
        "stiffness_x": Role("K_xkappa", ("CKAPPA",)),
        "stiffness_y": Role("K_yalpha", ("CALPHA", "NSTIFF")),
        "trail": Role("D_t", ("PATCH", "NPATCH")),
    },
    property_file=PropertyFile(formats=("BRUSH",), written_format="BRUSH", strict=True),
    fit=FitDeclaration(CONSTRAINTS),
    baseline=Baseline(("CKAPPA", "CALPHA", "MUX", "MUY", "PATCH")),
    motion=Motion(friction_scales=("MUX", "MUY")),
)
MODELS = (BRUSH,)
