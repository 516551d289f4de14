"""A model outside the package: a saturating curve for each axis, with its own names and sections.

It lacks pressure, shifts, trail, relaxation, combined slip weighting, M_x and M_y. The forces share one friction.
"""

from __future__ import annotations

import pytest
from sympy import atan, sqrt

from tirefmu.symbolic.contract import Baseline, FitDeclaration, PropertyFile, Role, positive
from tirefmu.symbolic.declarations import Coefficient, Effect, Section
from tirefmu.symbolic.functions import where
from tirefmu.symbolic.model import Model, Source
from tirefmu.symbolic.models import MODELS
from tirefmu.symbolic.notation import Chapter
from tirefmu.symbolic.quantities import ALPHA, FX, FY, FZ, KAPPA, MZ

softening = Effect("softening", "friction changes with load as this model defines it")


def made_toy(name="toy", *, flips=True, folder="", recipes=()):
    """Return the model; without `flips` no declaration changes the sign of the side force with the convention."""

    class Size(Section, title="DIMENSION", fitted=False):
        UNLOADED_RADIUS = Coefficient("free radius", "m", 0.01, 3.0, neutral=None, start=0.3)

    class Load(Section, title="VERTICAL", fitted=False):
        FNOMIN = Coefficient("nominal load", "N", 1.0, 1e6, neutral=None, start=1000.0)

    class Parameter(Section, title="PARAMETER"):
        UMAX = Coefficient("friction", "1", 0.1, 5.0, neutral=None, start=1.0)
        USOFT = Coefficient("friction, change with load", "1", -2.0, 1.0)
        CLONG = Coefficient("longitudinal stiffness", "N", 10.0, 1e6, None, 2e4, channels=("Fx",))
        CSIDE = Coefficient("cornering stiffness", "N/rad", 10.0, 1e6, None, 2e4, flips=flips, channels=("Fy", "Mz"))
        ARM = Coefficient("trail", "m", 0.0, 1.0, None, 0.03, channels=("Mz",))

    eq = Chapter("A toy")
    kappa, alpha, Fz = (quantity.symbol for quantity in (KAPPA, ALPHA, FZ))
    load = eq("1", "load", where(Fz <= 0, 0, Fz), "N", "load on the ground", named=False)
    mu = eq("2", "mu", Parameter.UMAX + softening.term(Parameter.USOFT * (load / Load.FNOMIN - 1)), "1", "friction")
    limit = eq("3", "limit", mu * load + 1e-6, "N", "largest force", named=False)
    slopes = [eq("4", "K_x", Parameter.CLONG, "N", "stiffness"), eq("4", "K_y", Parameter.CSIDE, "N/rad", "stiffness")]
    x, y = (eq("5", f"wanted_{a}", K * s, "N", "force without slip", named=False)
            for a, K, s in zip("xy", slopes, (kappa, atan(alpha)), strict=True))  # fmt: skip
    total = eq("6", "spread", sqrt(1 + (x**2 + y**2) / limit**2), "1", "how friction is shared", named=False)
    eq("7", "Fx", where(Fz <= 0, 0, x / total), "N", "longitudinal force")
    Fy = eq("8", "Fy", where(Fz <= 0, 0, y / total), "N", "side force")
    eq("9", "Mz", -Parameter.ARM * Fy, "N m", "aligning moment")
    return Model(
        name=name,
        title="A toy",
        inputs=(KAPPA, ALPHA, FZ),
        outputs=(FX, FY, MZ),
        sections=(Size, Load, Parameter),
        source=Source((eq,), folder, (softening,)),
        roles={
            "friction_x": Role("mu", ("UMAX",)),
            "friction_y": Role("mu", ("UMAX",)),
            "stiffness_x": Role("K_x", ("CLONG",)),
            "stiffness_y": Role("K_y", ("CSIDE",)),
        },
        property_file=PropertyFile(formats=("TOY",), written_format="TOY", header={"USE_MODE": "2"}),
        fit=FitDeclaration(
            {"Fy": (positive("mu", 0.01, "Fz"), positive("K_y", 1.0))}, recipes[0] if recipes else "joint", recipes
        ),
        baseline=Baseline(("UMAX", "CLONG", "CSIDE", "ARM")),
    )


@pytest.fixture(scope="session")
def made():
    """Return the function that makes the model."""
    return made_toy


@pytest.fixture(scope="module")
def toy():
    """Register the model for a module."""
    model = made_toy()
    with pytest.MonkeyPatch.context() as patch:
        patch.setitem(MODELS, model.name, model)
        yield model
