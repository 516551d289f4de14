"""A road as a grid of heights along a reference line, as in ASAM OpenCRG: heights, and planes for hub inputs."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
import numpy.typing as npt
from numpy.typing import ArrayLike

from ...boundary.errors import DataError

FloatArray = npt.NDArray[np.float64]

#: Distances of points from nodes that are computed at a time.
_CHUNK = 2_000_000
#: Largest number, m or rad, and smallest distance of grid points, m: other values are not a road and overflow.
LARGEST, SMALLEST_STEP = 1e9, 1e-9


@dataclass(frozen=True)
class Road:
    """Heights over u, the length along a reference line, and v, the distance to its left.

    Heights are bilinear between the points of the grid. Beyond its edges they are those of the edges.

    `increment`: distance of the points of the reference line, m. `v`, shape (m,): increasing. `heights`, shape (n, m):
    at each point of the reference line, n at least 2. `headings`, shape (n,): direction of the reference line from the
    previous point; the first is not used. `start`: global x and y of its first point, m. Raises `DataError` if shapes
    do not fit, a number is not finite or too large, or v does not increase.

    Source: ASAM OpenCRG 1.2.

    >>> bump = Road(1.0, np.array([-1.0, 1.0]), np.array([[0.0, 0.0], [0.1, 0.2], [0.0, 0.0]]), np.zeros(3))
    >>> bump.height([0.5, 1.0], [0.0, -1.0]).round(3).tolist()
    [0.075, 0.1]
    """

    increment: float
    v: FloatArray
    heights: FloatArray
    headings: FloatArray
    start: tuple[float, float] = (0.0, 0.0)

    def __post_init__(self) -> None:
        n, m = self.heights.shape
        if n < 2 or m < 2 or self.v.shape != (m,) or self.headings.shape != (n,):
            raise DataError("a road needs 2 or more points along and across, and a heading for each along")
        numbers = np.concatenate([self.v, self.heights.ravel(), self.headings[1:], [self.increment, *self.start]])
        steps = np.array([self.increment, *np.diff(self.v)])
        if not np.all(np.abs(numbers) <= LARGEST) or np.any(steps < SMALLEST_STEP):
            raise DataError(
                f"a road needs finite numbers up to {LARGEST:g}, a positive increment of {SMALLEST_STEP:g} m or more, "
                "and v that increases"
            )

    @cached_property
    def nodes(self) -> FloatArray:
        """The points of the reference line, global, shape (n, 2), m."""
        steps = self.increment * self.ahead
        return np.asarray(np.array(self.start) + np.concatenate([np.zeros((1, 2)), np.cumsum(steps, axis=0)]))

    @cached_property
    def ahead(self) -> FloatArray:
        """The directions of the n - 1 parts of the reference line."""
        return np.stack([np.cos(self.headings[1:]), np.sin(self.headings[1:])], axis=-1)

    @cached_property
    def across(self) -> FloatArray:
        """At each point, the direction of the reference line: the grid line there is normal to it."""
        mean = np.concatenate([self.ahead[:1], self.ahead[:-1] + self.ahead[1:], self.ahead[-1:]])
        return np.asarray(mean / np.linalg.norm(mean, axis=-1, keepdims=True))

    def along_and_across(self, x: ArrayLike, y: ArrayLike) -> tuple[FloatArray, FloatArray]:
        """Return u (0 at the first point) and v of points.

        `x`, `y`: global, m. Returns `u`, `v`: of the nearest part of the reference line. Beyond its ends it continues
        straight.

        >>> turn = Road(1.0, np.array([-1.0, 1.0]), np.zeros((3, 2)), np.array([0.0, 0.0, np.pi / 2]))
        >>> [float(each.round(3)) for each in turn.along_and_across(0.9, 0.5)]
        [1.361, 0.1]
        """
        given = np.broadcast_arrays(np.asarray(x, dtype=float), np.asarray(y, dtype=float))
        points = np.stack([coordinate.ravel() for coordinate in given], axis=-1)
        nearest = np.concatenate([
            np.argmin(((part[:, None] - self.nodes) ** 2).sum(axis=-1), axis=1)
            for part in np.array_split(points, 1 + points.size * len(self.nodes) // _CHUNK)
        ])  # fmt: skip
        last = len(self.nodes) - 2
        past = np.einsum("ij,ij->i", points - self.nodes[nearest], self.across[nearest])
        i = np.clip(np.where(past < 0.0, nearest - 1, nearest), 0, last)
        # Between two grid lines, u changes in proportion to the distances from them: continuous everywhere.
        before = np.einsum("ij,ij->i", points - self.nodes[i], self.across[i])
        after = np.einsum("ij,ij->i", self.nodes[i + 1] - points, self.across[i + 1])
        straight = (before < 0.0) | (after < 0.0)
        u = i + np.where(straight, np.where(before < 0.0, before, self.increment - after) / self.increment,
                         before / np.where(straight, 1.0, before + after))  # fmt: skip
        ahead, arm = self.ahead[i], points - self.nodes[i]
        v = ahead[:, 0] * arm[:, 1] - ahead[:, 1] * arm[:, 0]
        return (u * self.increment).reshape(given[0].shape), v.reshape(given[0].shape)

    def height(self, x: ArrayLike, y: ArrayLike) -> FloatArray:
        """Return the height of the road, m, at global points, m."""
        u, v = self.along_and_across(x, y)
        n, m = self.heights.shape
        along, across = np.clip(u / self.increment, 0.0, n - 1.0), np.clip(v, self.v[0], self.v[-1])
        i = np.minimum(along.astype(int), n - 2)
        j = np.clip(np.searchsorted(self.v, across, side="right") - 1, 0, m - 2)
        a, b = along - i, (across - self.v[j]) / (self.v[j + 1] - self.v[j])
        low = (1.0 - b) * self.heights[i, j] + b * self.heights[i, j + 1]
        high = (1.0 - b) * self.heights[i + 1, j] + b * self.heights[i + 1, j + 1]
        return np.asarray((1.0 - a) * low + a * high)

    def plane(self, x: ArrayLike, y: ArrayLike, length: float = 0.1) -> dict[str, FloatArray]:
        """Return the plane of the road near points as hub inputs.

        `x`, `y`: global position of wheel centres, m. `length`: the slopes are those over this length, m, such as that
        of the contact patch: a tire does not follow each stone. Returns: ``road_z``, ``road_nx``, ``road_ny``,
        ``road_nz``.

        >>> slope = Road(1.0, np.array([-1.0, 1.0]), np.array([[0.0, 0.0], [0.1, 0.1]]), np.zeros(2))
        >>> {name: float(value.round(3)) for name, value in slope.plane(0.5, 0.0).items()}
        {'road_z': 0.05, 'road_nx': -0.1, 'road_ny': 0.0, 'road_nz': 1.0}
        """
        x, y, h = np.asarray(x, dtype=float), np.asarray(y, dtype=float), 0.5 * length
        z, ahead, behind, left, right = (
            self.height(x + h * dx, y + h * dy) for dx, dy in ((0, 0), (1, 0), (-1, 0), (0, 1), (0, -1))
        )
        fall = (behind - ahead) / length, (right - left) / length
        return {"road_z": z, "road_nx": fall[0], "road_ny": fall[1], "road_nz": np.ones_like(z)}
