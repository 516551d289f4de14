"""Made tires for the laws: a law holds for every tire, not only for the published one."""

from __future__ import annotations

import numpy as np
import pytest

from tirefmu.symbolic import MODELS
from tirefmu.tires import Tire


def made_tire(model, seed):
    """Return a tire with every coefficient moved off its generic start, a tenth of the way to either bound at most.

    All effects act and all asymmetries are there; the tire is strange, but its friction is positive at
    inclinations up to 0.15 rad and loads up to twice the nominal.
    """
    rng = np.random.default_rng(seed)
    values = {}
    for name, card in MODELS[model].coefficients.items():
        bound = card.upper if rng.random() < 0.5 else card.lower
        values[name] = card.generic + rng.uniform(0.03, 0.1) * (bound - card.generic)
    values |= {"FNOMIN": rng.uniform(500, 6000), "UNLOADED_RADIUS": rng.uniform(0.2, 0.5)}
    return Tire(model, values, signs="adapted-sae", name=f"made tire {seed}")


@pytest.fixture(params=[(model, seed) for model in MODELS for seed in range(4)], ids=lambda p: f"{p[0]}-{p[1]}")
def tire(request):
    return made_tire(*request.param)


@pytest.fixture(scope="session")
def points():
    """Return a function that draws n rows of inputs for a tire, shape (n_inputs, n)."""

    def draw(tire, n=200, seed=0):
        rng = np.random.default_rng(seed)
        columns = {
            "kappa": rng.uniform(-0.6, 1.0, n),
            "alpha": rng.uniform(-0.5, 0.5, n),
            "gamma": rng.uniform(-0.15, 0.15, n),
            "Fz": rng.uniform(0.1, 2.0, n) * tire.values["FNOMIN"],
        }
        return np.stack([columns[name] for name in tire.inputs])

    return draw


@pytest.fixture(scope="session")
def forces_of():
    """Return a function that gives a tire's forces at rows of inputs, shape (n_forces, n)."""

    def forces(tire, rows):
        return np.stack(list(tire.forces(**dict(zip(tire.inputs, rows, strict=True))).values()))

    return forces


@pytest.fixture(scope="session")
def scale_of():
    """Return a function that gives the size of a tire's forces, shape (n_forces, 1): what errors are small to."""

    def scale(tire):
        load = tire.values["FNOMIN"]
        sizes = {"Fx": load, "Fy": load, "Mz": load * tire.values["UNLOADED_RADIUS"]}
        return np.array([[sizes[name]] for name in tire.outputs])

    return scale
