"""Coefficients of a host's model, fitted to the forces of a tire that it cannot have; those it lacks are neutral."""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import replace

import numpy as np
import numpy.typing as npt
import pandas as pd
from scipy.optimize import least_squares

from ...symbolic.models import MODELS
from ...tires import Tire
from ...tires.code import code_for
from .dialects import Host

FloatArray = npt.NDArray[np.float64]

#: Weight of a relative change of a coefficient against the relative error of the forces: coefficients without influence
#: keep their values.
CHANGE = 1e-3
#: Relative decrease of the cost at which the fit ends: further steps change no force by a tenth of its error.
ENOUGH = 1e-4


def lacked(rules: Host, model: str) -> tuple[str, ...]:
    """Return the coefficients of a model that a host's does not have: of its dialect, and unpublished ones.

    Not relaxation lengths: a host computes transient slip in its own way.
    """
    unpublished = {name for name, declared in MODELS[model].coefficients.items() if not declared.published}
    return (*rules.dialects[model].lacking, *sorted(unpublished.difference(MODELS[model].motion.relaxation)))


def acting(tire: Tire, lacking: Collection[str]) -> list[str]:
    """Return the coefficients among `lacking` that are not neutral in a tire."""
    declared = tire.symbolic_model.coefficients
    return [name for name in lacking if name in declared and tire.values[name] != declared[name].neutral]


def nearest(tire: Tire, forces: FloatArray, lacking: Collection[str], table: pd.DataFrame) -> Tire:
    """Return a tire with some neutral coefficients, all others fitted to forces.

    `tire`: where the fit starts. `forces`, shape (n_outputs, n): those of the tire's outputs, in its signs. `lacking`:
    coefficients that are neutral. `table`: the operating conditions of the forces, as for `Tire.evaluate`, n rows.

    Without the tire's QDZ2 the trail no longer changes with load; its mean is that of the table.

    >>> from tirefmu.tires import Tire
    >>> side = {"FNOMIN": 4000.0, "UNLOADED_RADIUS": 0.3, "PCY1": 1.3, "PDY1": 1.0, "PKY1": 20.0}
    >>> tire = Tire("mf96", {**side, "QBZ1": 8.0, "QCZ1": 1.1, "QDZ1": 0.1, "QDZ2": 0.02})
    >>> table = pd.DataFrame({"alpha": np.linspace(-0.1, 0.1, 41), "Fz": 5000.0})
    >>> fitted = nearest(tire, tire.evaluate(table)[list(tire.outputs)].to_numpy().T, ["QDZ2"], table)
    >>> fitted.values["QDZ2"], round(fitted.values["QDZ1"], 3)
    (0.0, 0.105)
    """
    declared, code = tire.symbolic_model.coefficients, code_for(tire.symbolic_model, "numpy")
    inputs = np.stack([np.broadcast_to(table.get(name, tire.nominal(name)), len(table)) for name in tire.inputs])
    inputs = tire.effective_inputs(inputs)
    sizes = np.sqrt(np.mean(forces**2, axis=1))
    sizes[sizes == 0.0] = 1.0
    neutral = {name: float(declared[name].neutral or 0.0) for name in acting(tire, lacking)}
    start = replace(tire, values={**tire.values, **neutral})
    owned = tire.symbolic_model.core.union(*(tire.symbolic_model.owned(name) for name in tire.has)) - {*lacking}
    names = [name for name in declared if name in owned and declared[name].fitted]
    places = [list(declared).index(name) for name in names]
    parameters = start.parameters()
    at_start: FloatArray = parameters[places]
    scale = np.maximum(np.abs(at_start), 0.1)

    def vector(change: FloatArray) -> FloatArray:
        changed = parameters.copy()
        changed[places] = at_start + scale * change
        return changed

    def residuals(change: FloatArray) -> FloatArray:
        errors = (code.forces(inputs, vector(change)) - forces) / sizes[:, None]
        return np.concatenate([errors.ravel() / np.sqrt(len(table)), CHANGE * change])

    def jacobian(change: FloatArray) -> FloatArray:
        matrix = code.jacobian_parameters(inputs, vector(change))[:, :, places] * scale / sizes[None, :, None]
        rows = matrix.transpose(1, 0, 2).reshape(-1, len(places)) / np.sqrt(len(table))
        return np.concatenate([rows, CHANGE * np.eye(len(places))])

    solution = least_squares(residuals, np.zeros(len(places)), jac=jacobian, method="lm", ftol=ENOUGH, max_nfev=200)
    factors = start.rescaled
    fitted = {name: float(value) / factors.get(name, 1.0)
              for name, value in zip(names, vector(solution.x)[places], strict=True)}  # fmt: skip
    return replace(tire, values={**start.values, **fitted})
