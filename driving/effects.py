"""What each effect of the library would add to the side forces of a drive."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import replace

import numpy as np
import numpy.typing as npt
import pandas as pd

from tirefmu.diagnosis.diagnose import with_library
from tirefmu.diagnosis.probing.candidates import candidates_for, counts_from_neutral
from tirefmu.tires import Tire

from .unknowns import AXLES

FloatArray = npt.NDArray[np.float64]

#: What a drive has of the inputs of an effect.
INPUTS = frozenset({"kappa", "alpha", "Fz", "V", "t", "Fy"})
#: Smallest change of a force, per static load, that is a change: that of rounding is none.
MIN_CHANGE = 1e-5


def effect_columns(
    wheels: pd.DataFrame, tires: Mapping[str, Tire], loads: tuple[float, float]
) -> list[tuple[str, FloatArray]]:
    """Return name and added side force per static load, shape (n, 2), of each effect at a typical size.

    `wheels`: `wheel_table`. `loads`: of the axles, N. An effect occurs once for each form and size; both axles have it.
    """
    tables = [wheels[wheels["axle"] == i + 1][["t", "kappa", "alpha", "Fz", "V"]] for i in range(len(AXLES))]
    with_effects = [with_library(tires[axle]) for axle in AXLES]
    bases = [tire.evaluate(table, signs="iso")["Fy"] for tire, table in zip(with_effects, tables, strict=True)]
    columns = []
    for name, values in _sizes(with_effects[0]):
        forces = [
            replace(tire, effects=tire.has | {name}).with_values(**values).evaluate(table, signs="iso")["Fy"]
            for tire, table in zip(with_effects, tables, strict=True)
        ]
        added = np.stack([2.0 * (forces[i] - bases[i]) / loads[i] for i in range(len(AXLES))], axis=1)
        if np.isfinite(added).all() and np.abs(added).max() > MIN_CHANGE:
            columns.append((name, added))
    return columns


def _sizes(tire: Tire) -> Iterator[tuple[str, dict[str, float]]]:
    """Yield the effects whose inputs a drive has, with the coefficients of each form at a typical size."""
    declared = tire.symbolic_model.coefficients
    for name, candidate in candidates_for(tire).items():
        if "Fy" not in candidate.channels or not set(candidate.requires) <= INPUTS:
            continue
        for form in candidate.forms:
            for point in form.points():
                for probe in point.probes:
                    values = {key: value for key, (value,) in point.grid.items()}
                    for key, size in probe.items():
                        neutral = declared[key].neutral
                        values[key] = size + (neutral if neutral and counts_from_neutral(declared[key]) else 0.0)
                    yield name, values
