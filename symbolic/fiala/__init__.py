"""The Fiala tire of Adams and MotionSolve: nine physical parameters, forces linked by friction only.

Adams/Tire help, "Using the Fiala Handling Force Model"; Altair MotionView help, "Fiala Tire"; Project Chrono,
ChFialaTire.cpp.
"""

from dataclasses import replace

from ..contract import Baseline, FitDeclaration, Motion, PropertyFile, Role, positive
from ..model import Model, Source
from ..quantities import ALPHA, FX, FY, FZ, KAPPA, MY, MZ, V
from .coefficients import SECTIONS

CONSTRAINTS = {
    "Fx": (
        positive("mu_x", 0.01, "kappa", "alpha"),
        positive("mu_x_fall", 0.0),
        positive("K_xkappa", 1.0, size=1e4),
    ),
    "Fy": (
        positive("mu_y", 0.01, "kappa", "alpha"),
        positive("mu_y_fall", 0.0),
        positive("K_yalpha", 1.0, size=1e4),
    ),
    "Mz": (positive("t_0", 0.0, size=0.1),),
}
FIALA = Model(
    name="fiala",
    title="Fiala tire (Adams, MotionSolve)",
    # The sense of rolling and the rate of relaxation follow from the speed; the file has none.
    inputs=(KAPPA, ALPHA, FZ, replace(V, nominal=V.typical)),
    outputs=(FX, FY, MZ, MY),
    sections=SECTIONS,
    source=Source(("forces",), folder=__name__),
    results=("sigma_kappa", "sigma_alpha", "rho", "R_l", "d_z", "C_gamma"),
    roles={
        "friction_x": Role("mu_x", ("UMAX",)),
        "friction_y": Role("mu_y", ("UMAX",)),
        "stiffness_x": Role("K_xkappa", ("CSLIP",)),
        "stiffness_y": Role("K_yalpha", ("CALPHA",)),
        "trail": Role("t_0", ("WIDTH",)),
        "relaxation_x": Role("sigma_kappa"),
        "relaxation_y": Role("sigma_alpha"),
        "loaded_radius": Role("R_l"),
    },
    property_file=PropertyFile(
        formats=("FIALA",),
        written_format="FIALA",
        header={"USE_MODE": "2"},
        aliases={"RELAX_LENGTH_X": "REL_LEN_LON", "RELAX_LENGTH_Y": "REL_LEN_LAT"},
        per_angle=True,
        # Adams' sample files give these in metres although lengths are in millimetres.
        in_si=("RELAX_LENGTH_X", "RELAX_LENGTH_Y"),
    ),
    fit=FitDeclaration(CONSTRAINTS),
    baseline=Baseline(("WIDTH", "CSLIP", "CALPHA", "UMIN", "UMAX")),
    motion=Motion(relaxation=("REL_LEN_LON", "REL_LEN_LAT"), friction_scales=("UMIN", "UMAX")),
)
MODELS = (FIALA,)
