"""The function of an interval at all intervals of a grid, and what the motion within them adds to its residuals."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from typing import Any

import numpy as np
import numpy.typing as npt

from .inputs.grid import Grid
from .interval import BALANCE, CHUNK, Chunk, Interval
from .linear import AddedForces, Linear

FloatArray = npt.NDArray[np.float64]
IntArray = npt.NDArray[np.intp]

#: Gauss points of an interval, from its middle, in its length.
POINTS = (-1.0 / np.sqrt(12.0), 1.0 / np.sqrt(12.0))


def interval_data(grid: Grid, share: float = 0.0) -> FloatArray:
    """Return the data of the intervals, shape (n, n_data): means, weights, steering and its slopes, speeds of rims.

    Steering and slopes are those at both ends; `share`: the line over the interval, moved by a share of its length.
    """
    sampled = np.isfinite(grid.means)
    weights = np.where(sampled, 1.0 / np.where(sampled, grid.noise, 1.0), 0.0)
    lines = np.stack([grid.steer, grid.steer_slopes[:2], grid.steer_slopes[2:]])
    lines = lines + share * np.diff(lines, axis=1)
    means = np.where(sampled, grid.means, 0.0)
    rows = np.concatenate([means, weights, lines.reshape(6, -1), grid.rims, grid.rim_slopes, grid.behind])
    return np.ascontiguousarray(rows.T)


def curved(grid: Grid, interval: Interval, added: AddedForces, states: FloatArray, z: FloatArray) -> AddedForces:
    """Return added forces with the difference between Gauss's quadrature of two points and the midpoint rule.

    Over an interval, the motion is a parabola through its nodes with the curvature at them. The steering is a line with
    the mean of the channel: at Gauss points, a parabola with the same mean has the same values.
    """
    curvature = curvature_of(grid, states)
    left, right, of_tires = states[grid.left], states[grid.right], added.tires(z)
    correction = -values_of(interval.value_chunk, grid, states, of_tires, interval_data(grid))
    for share in POINTS:
        at = (left + right) / 2 + share * (right - left) - curvature / 12
        half = (right - left + share * curvature) / 2
        moved = np.stack([at - half, at + half])
        data = interval_data(grid, share)
        correction += values_of(interval.value_chunk, grid, moved, of_tires, data) / len(POINTS)
    return replace(added, correction=correction)


def curvature_of(grid: Grid, states: FloatArray) -> FloatArray:
    """Return the second differences of the means of the states over each interval; at the ends of a chain, the nearest.

    Nodes may alternate where the car settles faster than an interval, as the midpoint rule lets them; means do not.
    """
    middle, n = (states[grid.left] + states[grid.right]) / 2, len(grid.t)
    inner = np.pad(grid.segment[2:] == grid.segment[:-2], 1)[:n, None]
    bend = np.where(inner, np.diff(middle, 2, axis=0, prepend=middle[:1], append=middle[-1:]), 0.0)
    first, last = np.diff(grid.segment, prepend=-1) != 0, np.diff(grid.segment, append=-1) != 0
    return np.asarray(bend[np.arange(n) + first - last.astype(np.intp)])


def evaluated(
    chunk: Chunk, grid: Grid, states: FloatArray, z: FloatArray, data: FloatArray, more: FloatArray | None = None,
    further: int | None = None,
) -> Linear:  # fmt: skip
    """Return a function of `Interval` at all intervals.

    `states`: of the nodes, shape (n_nodes, n_states), or of both ends of the intervals, shape (2, n, n_states).
    `more`, shape (n, n_more): its last argument. `further`: number of unknowns after z; the balance of forces, the last
    values, then has derivatives by all unknowns, 0 by these.
    """
    n, m, few, of_nodes = len(grid.t), chunk.function.size1_out(0), len(chunk.depends), 2 * states.shape[-1]
    few_have = few if further is None else few - len(BALANCE)
    depends = *chunk.depends[:few_have], *[np.arange(len(z) + (further or 0))] * (few - few_have)
    by_z = tuple(np.zeros((n, len(some))) for some in depends)
    places: list[slice | IntArray] = [*[slice(None)] * few_have, *chunk.depends[few_have:]]
    linear = Linear(np.empty((n, m)), np.empty((n, few, of_nodes)), by_z, depends)
    for rows, (values, by) in _chunks(chunk.function, grid, states, z, data, more):
        linear.values[rows] = values
        by = by.reshape(len(by), -1, few)
        linear.by_nodes[rows] = by[:, :of_nodes].transpose(0, 2, 1)
        for i, (part, some, place) in enumerate(zip(by_z, chunk.depends, places, strict=True)):
            part[rows, place] = by[:, of_nodes + some, i]
    return linear


def values_of(chunk: Chunk, grid: Grid, states: FloatArray, z: FloatArray, data: FloatArray) -> FloatArray:
    """Return the values of a function of `Interval` at all intervals, shape (n, n_values); see `evaluated`."""
    return np.concatenate([values.copy() for _, (values, *_) in _chunks(chunk.function, grid, states, z, data)])


def _chunks(
    function: Any, grid: Grid, states: FloatArray, z: FloatArray, data: FloatArray, more: FloatArray | None = None
) -> Iterator[tuple[slice, list[FloatArray]]]:
    """Go through the intervals: which they are and the results of a function, until the next.

    Rows of arrays are columns of the CasADi function, which reads and writes them without copies into its own matrices.
    """
    left, right = states if states.ndim == 3 else (states[grid.left], states[grid.right])
    columns = [left, right, data, *([] if more is None else [more])]
    given = [np.empty((CHUNK, column.shape[1])) for column in columns]
    constant = np.tile(np.concatenate([z, grid.used]), (CHUNK, 1))
    results = [np.empty((CHUNK, function.size1_out(i))) for i in range(function.n_out())]
    buffer, evaluate = function.buffer()
    for i, argument in enumerate([*given[:3], constant, *given[3:]]):
        buffer.set_arg(i, memoryview(argument.data))
    for i, result in enumerate(results):
        buffer.set_res(i, memoryview(result.data))
    n = len(grid.t)
    for first in range(0, n, CHUNK):
        for column, argument in zip(columns, given, strict=True):  # the last interval fills the last chunk
            np.take(column, np.arange(first, first + CHUNK), axis=0, out=argument, mode="clip")
        evaluate()
        yield slice(first, min(first + CHUNK, n)), [part[: n - first] for part in results]
