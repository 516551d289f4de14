"""Operating conditions at kinks and limits, and tires that have them: no load, standstill, zero slip, zero pressure."""

from __future__ import annotations

from dataclasses import replace
from itertools import product

import numpy as np

#: Coefficients of shifts and offsets: a tire without them is symmetric.
SHIFTS = ("QHZ", "PHX", "PHY", "PVX", "PVY", "RHX", "RHY", "QDZ6", "QDZ7", "QDZ8", "QDZ9", "QDZ10", "QDZ11", "SSZ1",
          "PEX4", "PEY3")  # fmt: skip
#: Limits of a file that may be 0.
LIMITS = ("FZMIN", "VXLOW", "PRESMIN")


def symmetric(tire):
    """Return a tire without shifts whose limits are 0."""
    values = {name: 0.0 if name.startswith(SHIFTS) else value for name, value in tire.values.items()}
    return replace(tire, values=values | {name: 0.0 for name in LIMITS if name in values})


def special_points(tire):
    """Return rows at every combination of special values, and rows next to them: shape (n_inputs, n)."""
    nominal = {name: tire.nominal(name) for name in tire.inputs}
    load = nominal["Fz"]
    special = {
        "Fz": (load, 0.0), "V": (nominal.get("V", 0.0), 0.0), "p": (nominal.get("p", 0.0), 0.0),
        "kappa": (0.0, 0.1, -1.0), "alpha": (0.0, -0.1), "gamma": (0.0, 0.05), "phit": (0.0, 0.01),
    }  # fmt: skip
    names = [name for name in special if name in tire.inputs]
    rows = [dict(zip(names, values, strict=True)) for values in product(*(special[name] for name in names))]
    rows += [
        {"Fz": -load}, {"Fz": 1e-6}, {"Fz": 1e-3, "alpha": 0.1}, {"Fz": 0.01 * load, "kappa": 0.1}, {"Fz": 3 * load},
        {"kappa": 1e-13}, {"alpha": 1e-7, "kappa": 1e-8}, {"kappa": 5.0, "alpha": 1.5}, {"V": -10.0}, {"V": 1e-3},
        {"V": 0.5, "kappa": -0.5}, {"phit": 1e-7}, {"phit": 1e-200}, {"alpha": np.pi / 2},
        {"alpha": -np.pi / 2, "kappa": 0.1}, {"alpha": 1.5, "phit": 0.3, "gamma": 0.2},
    ]  # fmt: skip
    return np.array([[row.get(name, nominal[name]) for row in rows] for name in tire.inputs])
