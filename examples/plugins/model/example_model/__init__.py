"""A model for tirefmu: each force is an arctangent of its slip, and both share the friction.

F_x0 = mu Fz 2/pi atan(pi/2 K kappa / (mu Fz)), likewise F_y0 of tan(alpha); the resultant is limited to mu Fz.
"""

from sympy import atan, pi, sqrt, tan

from tirefmu.symbolic.contract import Baseline, FitDeclaration, PropertyFile, Role, positive
from tirefmu.symbolic.declarations import Coefficient, Section
from tirefmu.symbolic.functions import where
from tirefmu.symbolic.model import Model, Source
from tirefmu.symbolic.notation import Chapter
from tirefmu.symbolic.quantities import ALPHA, FX, FY, FZ, KAPPA


class Size(Section, title="DIMENSION", fitted=False):
    """Dimensions and the nominal load."""

    UNLOADED_RADIUS = Coefficient("free radius", "m", 0.01, 3.0, neutral=None, start=0.3)
    FNOMIN = Coefficient("nominal load", "N", 1.0, 1e6, neutral=None, start=1000.0)


class Curve(Section, title="ARCTANGENT"):
    """Friction and stiffness; the side force changes sign between adapted SAE and ISO."""

    AMU = Coefficient("friction", "1", 0.1, 5.0, neutral=None, start=1.0)
    ACX = Coefficient("longitudinal stiffness per load", "1", 1.0, 200.0, neutral=None, start=20.0, channels=("Fx",))
    ACY = Coefficient(
        "cornering stiffness per load", "1/rad", 1.0, 200.0, neutral=None, start=15.0, flips=True, channels=("Fy",)
    )


EQUATIONS = Chapter("Arctangents")
_Fz = EQUATIONS("1", "load", where(FZ.symbol <= 0, 0, FZ.symbol), "N", "load on the ground", named=False)
_mu = EQUATIONS("2", "mu", Curve.AMU, "1", "friction")
_limit = EQUATIONS("3", "limit", _mu * _Fz + 1e-6, "N", "largest force", named=False)
_K_x = EQUATIONS("4", "K_x", Curve.ACX * _Fz, "N", "longitudinal stiffness")
_K_y = EQUATIONS("5", "K_y", Curve.ACY * _Fz, "N/rad", "cornering stiffness")
_x = EQUATIONS("6", "share_x", 2 / pi * atan(pi / 2 * _K_x * KAPPA.symbol / _limit), "1", "share of Fx", named=False)
_y = EQUATIONS(
    "7", "share_y", 2 / pi * atan(pi / 2 * _K_y * tan(ALPHA.symbol) / _limit), "1", "share of Fy", named=False
)
_both = EQUATIONS("8", "both", sqrt(1 + _x**2 * _y**2), "1", "reduction by combined slip", named=False)
EQUATIONS("9", "Fx", where(FZ.symbol <= 0, 0, _limit * _x / _both), "N", "longitudinal force")
EQUATIONS("10", "Fy", where(FZ.symbol <= 0, 0, _limit * _y / _both), "N", "side force")

MODELS = (
    Model(
        name="arctangent",
        title="Arctangents",
        inputs=(KAPPA, ALPHA, FZ),
        outputs=(FX, FY),
        sections=(Size, Curve),
        source=Source((EQUATIONS,), "", ()),
        roles={
            "friction_x": Role("mu", ("AMU",)),
            "friction_y": Role("mu", ("AMU",)),
            "stiffness_x": Role("K_x", ("ACX",)),
            "stiffness_y": Role("K_y", ("ACY",)),
        },
        property_file=PropertyFile(formats=("ARCTANGENT",), written_format="ARCTANGENT", header={}),
        fit=FitDeclaration({"Fy": (positive("mu", 0.01, "Fz"),)}, "joint", ()),
        baseline=Baseline(("AMU", "ACX", "ACY")),
    ),
)
