"""The function of an interval at all intervals of a grid, and what the motion within them adds to its residuals."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import numpy.typing as npt

from .inputs.grid import Grid
from .interval import CHUNK, Added, Interval, Linear

FloatArray = npt.NDArray[np.float64]

#: Gauss points of an interval, from its middle, in its length.
POINTS = (-1.0 / np.sqrt(12.0), 1.0 / np.sqrt(12.0))


def interval_data(grid: Grid, share: float = 0.0) -> FloatArray:
    """Return the data of the intervals, shape (n_data, n): means, weights, steering and its slopes, speeds of rims.

    Steering and slopes are those at both ends; `share`: the line over the interval, moved by a share of its length.
    """
    sampled = np.isfinite(grid.means)
    weights = np.where(sampled, 1.0 / np.where(sampled, grid.noise, 1.0), 0.0)
    lines = np.stack([grid.steer, grid.steer_slopes[:2], grid.steer_slopes[2:]])
    lines = lines + share * np.diff(lines, axis=1)
    return np.concatenate([np.where(sampled, grid.means, 0.0), weights, lines.reshape(6, -1), grid.rims])


def curved(grid: Grid, interval: Interval, added: Added, states: FloatArray, z: FloatArray) -> Added:
    """Return added forces with the difference between Gauss's quadrature of two points and the midpoint rule.

    Over an interval, the motion is a parabola through its nodes with the curvature at them. The steering is a line with
    the mean of the channel: at Gauss points, a parabola with the same mean has the same values.
    """
    inner = np.flatnonzero(np.bincount(np.concatenate([grid.left, grid.right])) == 2)
    bend, inside = np.zeros_like(states), np.zeros((grid.n_nodes, 1))
    bend[inner], inside[inner] = states[inner + 1] - 2.0 * states[inner] + states[inner - 1], 1.0
    ends = np.stack([grid.left, grid.right])
    curvature = bend[ends].sum(axis=0) / np.maximum(inside[ends].sum(axis=0), 1.0)
    (left, right), of_tires = states[ends], added.tires(z)
    correction = -evaluated(interval.residual_chunk, grid, states, of_tires, interval_data(grid)).values
    for share in POINTS:
        at = (left + right) / 2 + share * (right - left) - curvature / 12
        half = (right - left + share * curvature) / 2
        moved = np.stack([at - half, at + half])
        data = interval_data(grid, share)
        correction += evaluated(interval.residual_chunk, grid, moved, of_tires, data).values / len(POINTS)
    return replace(added, correction=correction)


def evaluated(
    function: Any, grid: Grid, states: FloatArray, z: FloatArray, data: FloatArray, more: FloatArray | None = None
) -> Linear:
    """Return a function of `Interval` at all intervals.

    `states`: of the nodes, shape (n_nodes, n_states), or of both ends of the intervals, shape (2, n, n_states).
    `more`, shape (n, n_more): its last argument.
    """
    left, right = states if states.ndim == 3 else (states[grid.left], states[grid.right])
    n, m, width = len(grid.t), function.size1_out(0), 2 * left.shape[1] + len(z)
    values, jacobian = np.empty((n, m)), np.empty((n, m, width))
    constant = np.concatenate([z, grid.used])
    for first in range(0, n, CHUNK):
        rows = np.minimum(np.arange(first, first + CHUNK), n - 1)  # the last interval fills the last chunk
        results = [np.empty((CHUNK, m)), np.empty((CHUNK, m * width))]
        last = [] if more is None else [more[rows]]
        _call(function, [left[rows], right[rows], data.T[rows], np.tile(constant, (CHUNK, 1)), *last], results)
        some = slice(first, min(first + CHUNK, n))
        count = some.stop - first
        values[some] = results[0][:count]
        jacobian[some] = results[1][:count].reshape(count, width, m).transpose(0, 2, 1)
    return Linear(values, jacobian)


def _call(function: Any, arguments: list[FloatArray], results: list[FloatArray]) -> None:
    """Evaluate a CasADi function on arrays, one row a column of it, without copies into its own matrices."""
    buffer, trigger = function.buffer()
    stored = [np.ascontiguousarray(argument) for argument in arguments]
    for i, argument in enumerate(stored):
        buffer.set_arg(i, memoryview(argument.data))
    for i, result in enumerate(results):
        buffer.set_res(i, memoryview(result.data))
    trigger()
