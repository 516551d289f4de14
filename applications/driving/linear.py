"""Values and derivatives of the functions of all intervals, and what an effect adds to the forces of the tires."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from .interval import BALANCE, MOTION, FloatArray, IntArray


@dataclass(frozen=True)
class Linear:
    """Functions of all intervals at a point, and derivatives of the first ones or of all.

    `values`, shape (n, n_functions). `by_nodes`, shape (n, n_differentiated, 2 n_states): by left node and right node.
    `by_z`: of each function by the unknowns `depends`, shape (n, len(depends)): most depend on few.
    """

    values: FloatArray
    by_nodes: FloatArray
    by_z: tuple[FloatArray, ...]
    depends: tuple[IntArray, ...]

    def weigh(self, weights: FloatArray) -> None:
        """Multiply the functions by weights, shape (n, n_functions)."""
        self.values[:] *= weights
        self.by_nodes[:] *= weights[:, :, None]
        for by_z, weight in zip(self.by_z, weights.T, strict=True):
            by_z[:] *= weight[:, None]

    def part(self, rows: IntArray) -> Linear:
        """Return the functions of some intervals."""
        return Linear(self.values[rows], self.by_nodes[rows], tuple(by_z[rows] for by_z in self.by_z), self.depends)

    def by_all(self, some: slice, n_z: int) -> FloatArray:
        """Return the derivatives of some intervals by `n_z` unknowns, shape (n_some, n_differentiated, n_z)."""
        whole = np.zeros((*self.by_nodes[some].shape[:2], n_z))
        for i, (by_z, depends) in enumerate(zip(self.by_z, self.depends, strict=True)):
            whole[:, i, depends] = by_z[some]
        return whole

    def cost(self, z: FloatArray) -> float:
        """Return half the sum of squares of residuals and of the unknowns."""
        return 0.5 * float(np.sum(self.values**2) + z @ z)


@dataclass(frozen=True)
class AddedForces:
    """Side forces per static load beyond the tires', linear in the last unknowns and in the motion.

    `offset`, shape (n, 2). `columns`, shape (n, 2, n_last): by the last unknowns, of which `further` are none of tires
    and car; their prior is the standard normal distribution. `slopes`, shape (n, 2, 3): by `MOTION` in the middle of an
    interval. `correction`, shape (n, n_residuals): added to all residuals. `relative`, shape (n, 2, n_relative): the
    last columns over the side forces of the tires, as far as they are in proportion to these. `limits`, shape (2,
    further): of these unknowns.
    """

    offset: FloatArray
    columns: FloatArray
    slopes: FloatArray
    further: int = 0
    correction: FloatArray | float = 0.0
    relative: FloatArray | float = 0.0
    limits: FloatArray | float = 0.0

    def tires(self, z: FloatArray) -> FloatArray:
        """Return the unknowns of tires and car."""
        return z[: len(z) - self.further]

    def and_columns(self, columns: FloatArray, relative: FloatArray) -> AddedForces:
        """Return these forces and those of further unknowns."""
        both = np.concatenate([self.columns, columns], axis=2)
        return replace(self, columns=both, further=self.further + columns.shape[2], relative=relative)

    def act(self, values: FloatArray, z: FloatArray, left: FloatArray, right: FloatArray) -> None:
        """Add these forces to the values of the residuals of tires and car, per static load."""
        middle = (left + right)[:, : len(MOTION)] / 2
        values[:] += self.correction
        forces = self.offset + self.columns @ z[len(z) - self.columns.shape[2] :]
        values[:, -len(BALANCE) :] -= forces + np.einsum("kim,km->ki", self.slopes, middle)

    def slant(self, linear: Linear, n: int) -> None:
        """Add the derivatives of these forces to those of the residuals, by nodes of `n` states and by unknowns."""
        last = self.columns.shape[2]
        for first in (0, n):
            linear.by_nodes[:, -len(BALANCE) :, first : first + len(MOTION)] -= self.slopes / 2
        for axle, by_z in enumerate(linear.by_z[-len(BALANCE) :]):
            if by_z.size:
                by_z[:, by_z.shape[1] - last :] -= self.columns[:, axle]
