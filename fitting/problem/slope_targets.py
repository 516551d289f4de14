"""Slopes at zero slip as additional residuals of a fit: linear combinations of the residuals of rows near zero slip."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ...numerics.arrays import FloatArray, IntArray
from ...tires.code import CHUNK, Code


@dataclass(frozen=True, eq=False)
class SlopeTarget:
    """The slope of a force at zero slip, read from rows of one operating condition.

    The slope is linear in the forces: ``influence @ force``. The same combination of the computed forces is compared
    with it, so that a curve which the reading method does not follow exactly gives no error.

    - `group`: number of the recording.
    - `output`: index of the force.
    - `inputs`, shape (n_inputs, n): of the rows near zero slip, as the generated code takes them.
    - `influence`, shape (n,): derivative of the slope by the force of each row.
    - `force`, shape (n,): the measured force of each row.
    - `rows`, shape (n,): number of each row, counted over all rows of all recordings.
    - `slope`: of the measured rows.
    - `error`: its standard error.
    - `deviation`: standard deviation that the fit assumes: the standard error, and the model-form error.
    """

    group: int
    output: int
    inputs: FloatArray
    influence: FloatArray
    force: FloatArray
    rows: IntArray
    slope: float
    error: float
    deviation: float


def slope_residuals(targets: Sequence[SlopeTarget], code: Code, parameters: FloatArray) -> FloatArray:
    """Return computed minus measured slope of each target, shape (n_targets,)."""
    if not targets:
        return np.zeros(0)
    forces = code.forces(
        np.ascontiguousarray(np.concatenate([target.inputs for target in targets], axis=1)), parameters
    )
    computed, first = np.zeros(len(targets)), 0
    for i, target in enumerate(targets):
        last = first + len(target.influence)
        computed[i] = target.influence @ forces[target.output, first:last]
        first = last
    return np.asarray(computed - np.array([target.slope for target in targets]))


def slope_jacobian(targets: Sequence[SlopeTarget], code: Code, parameters: FloatArray, columns: IntArray) -> FloatArray:
    """Return the derivatives of the slopes by the parameters in some columns, shape (n_targets, n_columns)."""
    force, coefficient = code.entries
    index = {int(column): i for i, column in enumerate(columns)}
    freed = np.array([index.get(int(column), -1) for column in coefficient], dtype=int)
    jacobian = np.zeros((len(targets), len(columns)))
    for row, target in enumerate(targets):
        chosen = np.flatnonzero((force == target.output) & (freed >= 0))
        for chunk, entries in code.jacobian_chunks(target.inputs, parameters, CHUNK):
            jacobian[row, freed[chosen]] += (entries @ target.influence[chunk])[chosen]
    return jacobian
