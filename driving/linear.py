"""The linearized functions of all intervals, and side forces that are added to those of the tires."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from .interval import BALANCE

FloatArray = npt.NDArray[np.float64]


@dataclass(frozen=True)
class Linear:
    """Functions of all intervals at a point, shape (n, n_functions), and their Jacobian by left node, right node, z."""

    values: FloatArray
    jacobian: FloatArray

    def weighted(self, weights: FloatArray) -> Linear:
        """Return the functions times weights, shape (n, n_functions)."""
        return Linear(self.values * weights, self.jacobian * weights[:, :, None])

    def with_columns(self, n: int) -> Linear:
        """Return the functions with n further unknowns, on which they do not depend."""
        return Linear(self.values, np.concatenate([self.jacobian, np.zeros((*self.values.shape, n))], axis=2))

    def cost(self, z: FloatArray) -> float:
        """Return half the sum of squares, priors included."""
        return 0.5 * float(np.sum(self.values**2) + z @ z)


@dataclass(frozen=True)
class Added:
    """Side forces per static load beyond the tires': `offset`, shape (n, 2), and `columns`, shape (n, 2, n_u).

    The columns are for further unknowns u, the last ones of z, whose prior is the standard normal distribution.
    """

    offset: FloatArray
    columns: FloatArray

    def tires(self, z: FloatArray) -> FloatArray:
        """Return the unknowns before u."""
        return z[: len(z) - self.columns.shape[2]]

    def residuals(self, of_tires: Linear, z: FloatArray) -> Linear:
        """Return residuals, per static load, with these forces, from those without them."""
        n = self.columns.shape[2]
        linear = of_tires.with_columns(n)
        linear.values[:, -len(BALANCE) :] -= self.offset + self.columns @ z[len(z) - n :]
        linear.jacobian[:, -len(BALANCE) :, linear.jacobian.shape[2] - n :] = -self.columns
        return linear
