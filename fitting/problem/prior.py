"""A normal prior of the free coefficients of a problem, in its scaled variables."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ...numerics.arrays import FloatArray


@dataclass(frozen=True, eq=False)
class Prior:
    """A normal prior.

    - `center`, shape (n_free,): its mean.
    - `precision`, shape (n_free, n_free): inverse of its covariance.
    - `weight`: cost of one half of the squared distance from the mean: that of the noise of one row.
    """

    center: FloatArray
    precision: FloatArray
    weight: float

    def cost(self, x: FloatArray) -> float:
        """Return the cost at scaled free values.

        >>> Prior(np.zeros(2), np.eye(2), 0.01).cost(np.array([1.0, 1.0]))
        0.01
        """
        away = x - self.center
        return 0.5 * self.weight * float(away @ self.precision @ away)

    def gradient(self, x: FloatArray) -> FloatArray:
        """Return the derivatives of the cost, shape (n_free,)."""
        return np.asarray(self.weight * self.precision @ (x - self.center))

    @property
    def curvature(self) -> FloatArray:
        """The second derivatives of the cost."""
        return self.weight * self.precision
