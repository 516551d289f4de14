"""The minimizing step of a quadratic model with linear bounds.

In the metric of the Cholesky factor of H, the minimum of g'p + p'Hp/2 subject to bounds on A p is the point of a
polyhedron nearest to the origin. This is a non-negative least-squares problem (Lawson and Hanson, Solving Least Squares
Problems, 1974, chapter 23).
"""

from __future__ import annotations

import numpy as np
from scipy.linalg import cholesky, solve_triangular
from scipy.optimize import nnls

from .arrays import FloatArray

#: Tolerance of a satisfied row, relative to its length times the length of the step.
ROUNDING = 1e-12


def best_step(
    gradient: FloatArray, matrix: FloatArray, rows: FloatArray, least: FloatArray, most: FloatArray
) -> tuple[FloatArray, float]:
    """Return the step that minimizes a quadratic model within bounds, and the reduction of the model.

    `gradient`, shape (n,). `matrix`, shape (n, n): positive definite. `rows`, shape (m, n). `least`, `most`, shape
    (m,): bounds of ``rows @ step``; infinite without a bound. A step of zero must be within them. Returns `step`, shape
    (n,). Raises `numpy.linalg.LinAlgError` if the matrix is not positive definite, or no step is found.

    >>> step, reduction = best_step(
    ...     np.array([-2.0, 1.0]), np.eye(2), np.eye(2), np.array([-9.0, 0.0]), np.array([0.5, 9.0])
    ... )
    >>> bool(np.allclose(step, [0.5, 0.0])), round(reduction, 9)
    (True, 0.875)
    """
    factor = cholesky(matrix, lower=True)
    pull = solve_triangular(factor, gradient, lower=True)
    size = float(np.linalg.norm(pull))
    if size == 0.0:
        return np.zeros(len(gradient)), 0.0
    sides = np.concatenate([rows, -rows])
    floors = np.concatenate([least, -most])
    reached = np.isfinite(floors)
    sides, floors = sides[reached], floors[reached]
    lengths = np.linalg.norm(sides, axis=1)
    binding = np.zeros(len(sides), dtype=np.bool_)
    # In the metric of the factor, relative to the unbounded minimum, divided by its distance from the start.
    nearest = np.zeros(len(gradient))
    while True:
        step = solve_triangular(factor, size * nearest - pull, lower=True, trans=1)
        crossed = sides @ step < floors - ROUNDING * lengths * np.linalg.norm(step)
        if not (crossed & ~binding).any():
            break
        binding |= crossed  # only the few active bounds enter the least-squares problem
        nearest = _nearest(factor, sides[binding], floors[binding], pull, size)
    return step, -float(gradient @ step + 0.5 * step @ matrix @ step)


def _nearest(factor: FloatArray, sides: FloatArray, floors: FloatArray, pull: FloatArray, size: float) -> FloatArray:
    """Return the shortest z with ``sides @ step >= floors`` for the step of z."""
    directions = solve_triangular(factor, sides.T, lower=True).T
    heights = (floors + directions @ pull) / size
    lengths = np.linalg.norm(directions, axis=1)
    system = np.concatenate([directions, heights[:, None]], axis=1) / np.where(lengths > 0, lengths, 1.0)[:, None]
    target = np.zeros(system.shape[1])
    target[-1] = 1.0
    try:
        factors, _ = nnls(system.T, target, maxiter=30 * len(system))
    except RuntimeError as error:
        raise np.linalg.LinAlgError(str(error)) from error
    rest = system.T @ factors - target
    if not rest[-1] < 0.0:
        raise np.linalg.LinAlgError("no step is within the bounds")
    return np.asarray(-rest[:-1] / rest[-1])
