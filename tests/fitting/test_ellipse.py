"""Combined slip that nobody measured keeps to the friction ellipse; what the data never show is stated everywhere."""

from __future__ import annotations

import numpy as np
import pytest

from tirefmu.fitting.problem import ellipse_values
from tirefmu.symbolic.models import MODELS
from tirefmu.tires import Tire

MAGIC_FORMULAS = [name for name, model in MODELS.items() if "weighting_x" in model.roles]


def largest_resultant(tire, load):
    """Return the largest resultant in units of the ellipse, and the fall of Fy at the peak slip angle with kappa."""
    kappa, alpha = np.meshgrid(np.linspace(-0.3, 0.3, 61), np.radians(np.linspace(-12.0, 12.0, 49)))
    forces = tire.forces(kappa=kappa, alpha=alpha, Fz=load)
    shares = [np.abs(forces[name]) / np.abs(forces[name]).max() for name in ("Fx", "Fy")]
    held, sliding = (tire.forces(kappa=value, alpha=0.15, Fz=load)["Fy"] for value in (0.0, 0.3))
    return float(np.hypot(*shares).max()), float(sliding / held)


@pytest.mark.parametrize("model", MAGIC_FORMULAS)
@pytest.mark.parametrize(
    "pure", [{}, {"PDX1": 2.6, "PDY1": 2.4, "PKX1": 60.0}, {"PDY1": 0.8, "PCY1": 1.6, "PKX1": 15.0}]
)
def test_the_resultant_stays_within_the_ellipse(model, pure):
    declared = MODELS[model].coefficients
    start = {name: declared[name].generic for name in declared if declared[name].fitted and name[0] == "P"}
    tire = Tire(model, {**start, "FNOMIN": 3000.0, "UNLOADED_RADIUS": 0.3, **pure}, signs="adapted-sae")
    values = ellipse_values(tire, tire.defaulted)
    assert values
    assert not {"PCX1", "PDX1", "PKY1"} & values.keys()
    resultant, remaining = largest_resultant(tire.with_values(**values), 3000.0)
    assert resultant < 1.05
    assert remaining < 0.8


def test_what_is_known_is_not_changed(known):
    measured = [name for name in known.values if name not in known.defaulted]
    assert not ellipse_values(known, set(known.defaulted) - set(measured)).keys() & set(measured)
    assert ellipse_values(known, ()) == {}


@pytest.mark.parametrize("model", ["fiala", "brush"])
def test_a_model_without_such_coefficients_has_no_values(model):
    tire = Tire(model, {"FNOMIN": 3000.0, "UNLOADED_RADIUS": 0.3})
    assert ellipse_values(tire, tire.defaulted) == {}
