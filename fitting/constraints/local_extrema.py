"""Smallest margins of a constraint between grid points: local minimization over the inputs with exact derivatives."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
from scipy.optimize import minimize

from ...numerics.arrays import FloatArray
from ...numerics.ties import graded
from ...symbolic.model import Model
from .buffered_function import BufferedFunction
from .constraint_functions import value_with_slopes
from .physical import Constraint

#: Number of grid points from which the minimization starts, and their least distance as a share of the range of an
#: input. A quantity has few extrema, and one on each side of a jump at zero slip.
STARTS, APART = 4, 0.15
#: Slope of a minimum, in sizes of the constraint over the range of an input, not counting slopes out of the range.
MIN_SLOPE = 1e-9


def local_extrema(
    model: Model,
    constraint: Constraint,
    points: FloatArray,
    distance: FloatArray,
    ranges: Mapping[str, tuple[float, float]],
    parameters: FloatArray,
) -> tuple[FloatArray, FloatArray]:
    """Return the points at which the margin of a constraint is locally smallest, and the bounded values there.

    `points`, shape (n_inputs, n): a grid. `distance`, shape (n,): margin of the constraint at the points. `ranges`:
    operating range of every input, in the model's order; `Constraint.within` may widen it. `parameters`, shape
    (n_parameters,). Returns: no point has a larger margin than the grid point from which it was found.
    """
    within = constraint.within(ranges)
    varied = [i for i, name in enumerate(within) if name in constraint.varied and within[name][0] < within[name][1]]
    if not varied:
        return points[:, :0], np.zeros(0)
    low, high = np.array(list(within.values()))[varied].T
    function = BufferedFunction(value_with_slopes(model, constraint.quantity, constraint.measure))
    function.arguments[1][:] = parameters
    extrema = [
        _descend(function, constraint, points[:, start], varied, low, high - low)
        for start in _apart(((points[varied].T - low) / (high - low)), distance)
    ]
    return np.stack([point for point, _ in extrema], axis=1), np.array([value for _, value in extrema])


def _apart(scaled: FloatArray, distance: FloatArray) -> list[int]:
    """Return the grid points with the smallest margins that are not next to each other."""
    chosen: list[int] = []
    left = np.array(distance)
    for _ in range(STARTS):
        best = int(np.argmin(graded(left)))
        if left[best] == np.inf:
            break
        chosen.append(best)
        left[np.abs(scaled - scaled[best]).max(axis=1) < APART] = np.inf
    return chosen


def _descend(
    function: BufferedFunction,
    constraint: Constraint,
    point: FloatArray,
    varied: Sequence[int],
    low: FloatArray,
    width: FloatArray,
) -> tuple[FloatArray, float]:
    """Return the local minimum of the margin that is reached from a point, and the value there."""

    def at(scaled: FloatArray) -> FloatArray:
        moved = point.copy()
        moved[varied] = low + scaled * width
        return moved

    def evaluated(scaled: FloatArray) -> tuple[float, FloatArray]:
        function.arguments[0][:] = at(scaled)
        value, slopes = function()
        return float(value[0]), slopes[varied] * width

    start = (point[varied] - low) / width
    value, slopes = evaluated(start)
    sign = 1.0 if value - constraint.lower <= constraint.upper - value else -1.0  # the nearer bound

    def downhill(scaled: FloatArray, slopes: FloatArray) -> FloatArray:
        """Return the descent within the range; 0 at a minimum."""
        descent = np.clip(scaled - sign * slopes / constraint.size, 0.0, 1.0) - scaled
        return np.where(np.abs(descent) > MIN_SLOPE, descent, 0.0)

    descent = downhill(start, slopes)
    if not descent.any():
        return point, value
    # Most minima are in a corner of the range, to which the descent points.
    corner = np.where(descent == 0.0, start, descent > 0.0)
    at_corner, slopes = evaluated(corner)
    if sign * at_corner < sign * value and not downhill(corner, slopes).any():
        return at(corner), at_corner

    def objective(scaled: FloatArray) -> tuple[float, FloatArray]:
        value, slopes = evaluated(scaled)
        return sign * value / constraint.size, sign * slopes / constraint.size

    end = minimize(
        objective, start, jac=True, method="L-BFGS-B", bounds=[(0.0, 1.0)] * len(varied),
        options={"ftol": 1e-13, "gtol": MIN_SLOPE, "maxiter": 50},
    )  # fmt: skip
    if end.fun < sign * value / constraint.size:
        return at(end.x), sign * constraint.size * float(end.fun)
    return point, value
