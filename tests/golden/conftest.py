"""Fixtures of the tests on reference numbers: the plain transcription, and tires without neutral coefficients."""

from __future__ import annotations

import importlib.util
import json

import numpy as np
import pytest

#: Plausible nonzero values of coefficients that are zero in the golden files.
SILENT = {
    "Q_V1": 6e-4, "Q_V2": 0.04, "Q_FCX": 0.1, "Q_FCY": 0.25, "PFZ1": 0.7, "PCFX1": 0.15, "PCFX2": -0.15,
    "PCFX3": 0.2, "PCFY1": -0.2, "PCFY2": 0.07, "PCFY3": 0.7, "PPX1": -0.8, "PPX2": 0.7, "PPX3": -0.05,
    "PPX4": -0.4, "RBX3": 6.0, "QSX7": 0.7, "QSX8": 0.8, "QSX10": 0.1, "QSX12": 0.3, "QSX13": 0.01,
    "QSX14": -0.2, "PPMX1": -0.1, "PEY5": 5.0, "PKY5": 0.8, "PPY1": 0.4, "PPY2": 0.6, "PPY3": 0.1, "PPY4": 0.1,
    "RBY4": 4.0, "QSY2": 0.02, "QSY3": 4e-4, "QSY4": 4e-5, "QSY5": 0.3, "QSY6": -0.2, "QBZ10": 0.4, "QDZ10": 0.3,
    "QDZ11": -0.2, "QEZ3": 0.3, "PPZ1": -0.4, "PPZ2": 0.3, "SSZ1": 0.02, "SSZ2": -0.01, "SSZ3": 0.15, "SSZ4": -0.1,
    "PDXP2": 0.2, "PDXP3": 0.6, "PDYP2": -0.2, "PDYP3": 0.7, "PDYP4": 0.3, "PHYP3": 0.05, "PECP2": 0.1,
    "QBZ6": 0.6, "LMUV": 0.1, "PTX1": 1.2, "PTX2": 0.1, "PTX3": -0.3, "PTY1": 1.6, "PTY2": 2.0, "PHY3": 0.03,
    "FZMIN": 300.0, "Q_CAM1": 85.0, "Q_CAM2": 257.0, "Q_CAM3": 0.5,
}  # fmt: skip
SETS = {"mf52": "mf52_MagicFormula52", "mf61": "mf61_MagicFormula61", "mf62": "mf62_MagicFormula62"}
#: Values that a random tire does not change: lengths and ranges that depend on each other.
FIXED = ("UNLOADED_RADIUS", "RIM_RADIUS", "BOTTOM_OFFST", "NOMPRES", "INFLPRES", "PRESMIN", "PRESMAX", "KPUMIN",
         "KPUMAX", "ALPMIN", "ALPMAX", "CAMMIN", "CAMMAX")  # fmt: skip


@pytest.fixture(scope="session")
def sheet(golden):
    """Return the module of the transcription; pytest's import mode does not permit an import statement."""
    spec = importlib.util.spec_from_file_location("sheet", golden / "sheet.py")
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


@pytest.fixture(scope="session")
def parameters_of(golden):
    """Return a function: the numbers of a model's golden tire, .tir name to value."""

    def parameters(model):
        answer = json.loads((golden / f"{SETS[model]}_params.json").read_text(encoding="utf-8"))
        return {name: value for name, value in answer.items() if not isinstance(value, str)}

    return parameters


@pytest.fixture(scope="session")
def random_tire(parameters_of):
    """Return a function: a golden tire of a model with every number moved and none at neutral."""

    def tire(model, seed):
        rng = np.random.default_rng(seed)
        values = parameters_of(model)
        values |= {name: value for name, value in SILENT.items() if not values.get(name)}
        for name, value in values.items():
            scale = name.startswith("L") and name != "LMUV" and value == 1
            if name not in FIXED:
                values[name] = value * rng.uniform(*((0.8, 1.25) if scale else (0.9, 1.1)))
        if seed % 2 and model == "mf52":
            values |= {"Q_A1": rng.uniform(0.1, 0.2), "Q_A2": rng.uniform(0.02, 0.05)}
        return values | {"LFZO": 1.07, "VXLOW": 1.7}

    return tire


@pytest.fixture(scope="session")
def random_rows():
    """Return a function: n rows of inputs within and far outside a tire's range, half of them with turn slip."""

    def rows(values, n, seed):
        rng = np.random.default_rng(seed)

        def some(column, share, drawn):
            return np.where(rng.random(n) < share, drawn, column)

        V = rng.uniform(3.0, 60.0, n)
        V = some(some(V, 0.15, rng.uniform(-40.0, -2.0, n)), 0.15, rng.uniform(-1.7, 1.7, n))
        kappa = some(rng.uniform(-0.4, 0.4, n), 0.1, rng.uniform(-3.0, 2.0, n))
        Fz = some(rng.uniform(0.05, 1.9, n), 0.08, rng.uniform(2.5, 7.0, n)) * values["FNOMIN"]
        return {
            "kappa": some(kappa, 0.05, rng.choice([0.0, -1.0], n)),
            "alpha": some(rng.uniform(-0.3, 0.3, n), 0.1, rng.uniform(-1.2, 1.2, n)),
            "gamma": some(rng.uniform(-0.15, 0.15, n), 0.1, 0.0),
            "Fz": some(Fz, 0.08, rng.uniform(0.0, values["FZMIN"], n)),
            "p": rng.uniform(0.6, 1.5, n) * values["NOMPRES"],
            "V": some(V, 0.03, 0.0),
            "phit": some(rng.uniform(-0.15, 0.15, n), 0.5, 0.0),
        }

    return rows
