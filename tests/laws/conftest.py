"""Made tires for the laws: a law holds for every tire, not only for the published one."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from tirefmu.symbolic.models import MODELS
from tirefmu.tires import Tire
from tirefmu.tires.definition import RANGES

from ..relatives import slow_relatives

#: Dimensions, ranges and nominal conditions. Values a tenth of the way to a bound would not describe a tire.
BODY = ("MODEL", "DIMENSION", "OPERATING_CONDITIONS", "VERTICAL", "STRUCTURAL", "CONTACT_PATCH")
#: Deflection of MF6.2: values of a contour of 0.2 m.
CONTOUR = {"Q_V1": 1e-3, "Q_V2": 0.05, "Q_FZ2": 10.0, "Q_FCX": 0.1, "Q_FCY": 0.1, "Q_FCY2": -0.4, "Q_CAM1": 80.0,
           "Q_CAM2": 250.0, "Q_CAM3": 0.5, "Q_FYS1": 2e3, "Q_FYS2": 3e3, "Q_FYS3": -4e3, "PFZ1": 0.7}  # fmt: skip
#: Bounds that are far from the values of real tires.
SMALL = {"QSY3": 0.1, "QSY4": 0.01, "PEY5": 0.1, "PKY5": 0.1, "RBX3": 0.1, "RBY4": 0.1, "PDYP4": 0.1}


def made_tire(model, seed):
    """Return a tire with every coefficient moved off its generic start, a tenth of the way to either bound at most.

    All effects and all asymmetries are present; the tire is unusual, but its friction is positive at
    inclinations up to 0.15 rad and loads up to twice the nominal.
    """
    rng = np.random.default_rng(seed)
    values = {}
    for name, declaration in MODELS[model].coefficients.items():
        upward = rng.random() < 0.5 or declaration.lower == declaration.generic
        bound = declaration.upper if upward else declaration.lower
        values[name] = declaration.generic + rng.uniform(0.03, 0.1) * (bound - declaration.generic)
        if declaration.section in BODY:
            values[name] = (CONTOUR.get(name, declaration.generic) or 0.1) * rng.uniform(0.9, 1.1)
        if declaration.section.endswith("_RANGE"):
            values[name] = declaration.generic
    load = rng.uniform(500, 6000)
    values |= {"FNOMIN": load, "UNLOADED_RADIUS": rng.uniform(0.25, 0.5)}
    values |= {name: values[name] * share for name, share in SMALL.items() if name in values}
    if "LMP" in values:  # a parking moment below 0 is treated as 0
        values["LMP"] = 0.5 + abs(values["LMP"])
    if "LMUV" in values:  # friction that grows with slip speed grows without bounds
        values["LMUV"] = abs(values["LMUV"])
    if "FZMIN" in values:
        values |= {"FZMIN": 0.2 * load, "FZMAX": 1.8 * load, "VERTICAL_STIFFNESS": load * rng.uniform(40, 60)}
    return Tire(model, values, effects=MODELS[model].effects, signs="adapted-sae", name=f"made tire {seed}")


#: Ranges that exclude many of the drawn points; loads and pressures in units of the nominal ones.
NARROW = {"kappa": (-0.2, 0.4), "alpha": (-0.2, 0.1), "gamma": (-0.05, 0.08), "Fz": (0.3, 1.2), "p": (0.9, 1.1)}
MAGIC = ("mf96", "mf52", "mf61", "mf62")
#: Two tires of each: a coefficient that one of them has below its generic value is likely to be above it in the other.
MADE = [(model, seed) for model in MAGIC for seed in range(2)]


@pytest.fixture(params=[*MADE, ("fiala", 0), ("brush", 0)], ids=lambda p: f"{p[0]}-{p[1]}")
def tire(request):
    """Return a tire of every model."""
    return made_tire(*request.param)


@pytest.fixture(params=slow_relatives(MODELS))
def model_tire(request):
    """Return one tire of every model, for laws of its lines that take long."""
    return made_tire(request.param, 0)


@pytest.fixture(params=MADE, ids=lambda p: f"{p[0]}-{p[1]}")
def magic_tire(request):
    """Return a tire of every Magic Formula."""
    return made_tire(*request.param)


@pytest.fixture(scope="session")
def made():
    """Return the function that makes a tire of a model from a seed."""
    return made_tire


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
            "p": rng.uniform(0.7, 1.3, n) * tire.values.get("NOMPRES", 1.0),
            "V": rng.uniform(2.0, 40.0, n),
            "phit": rng.uniform(-0.3, 0.3, n) * (rng.random(n) < 0.5),
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
    """Return a function that gives the size of a tire's forces, shape (n_forces, 1), to which errors are relative."""

    def scale(tire):
        load = tire.values["FNOMIN"]
        sizes = dict.fromkeys(tire.outputs, load * tire.values["UNLOADED_RADIUS"]) | {"Fx": load, "Fy": load}
        return np.array([[sizes[name]] for name in tire.outputs])

    return scale


@pytest.fixture(scope="session")
def narrowed():
    """Return a function that gives a tire known within narrow ranges only."""

    def narrow(tire):
        nominal = {"Fz": tire.values["FNOMIN"], "p": tire.values.get("NOMPRES", 1.0)}
        ranges = {name: tuple(nominal.get(name, 1.0) * end for end in NARROW[name]) for name in NARROW}
        ranges = {name: ends for name, ends in ranges.items() if name in tire.inputs}
        keys = {key: end for name, ends in ranges.items() for key, end in zip(RANGES[name], ends, strict=True)}
        values = {**tire.values, **{key: end for key, end in keys.items() if key in tire.values}}
        return replace(tire, values=values, ranges=ranges)

    return narrow
