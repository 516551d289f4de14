"""Loss functions of residuals: squares, and robust losses that reduce the influence of outliers.

A loss rho of u = residual / scale is u^2/2 for small u. Its derivative divided by u is the robust weight of a row: with
it, gradient and Gauss-Newton matrix are those of weighted least squares at this point (Holland and Welsch, 1977; Huber,
Robust Statistics, 1981). With these constants each loss has 95 % of the efficiency of least squares under normal noise.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from ...boundary.errors import UnknownName
from ...numerics.arrays import FloatArray

#: Standard deviation of normal noise divided by the median of its magnitude.
PER_MEDIAN = 1.482602


@dataclass(frozen=True)
class Loss:
    """A loss as functions of v = |residual| / (constant scale).

    - `constant`: number of standard deviations above which the loss is less than the square; infinite for squares.
    - `value`: 2 rho / (constant scale)^2, v^2 for small v.
    - `weight`: robust weight, between 0 and 1.
    - `slope`: second derivative of the loss, 1 for small v: the information of a row relative to least squares.
    """

    name: str
    constant: float
    value: Callable[[FloatArray], FloatArray]
    weight: Callable[[FloatArray], FloatArray]
    slope: Callable[[FloatArray], FloatArray]

    def __reduce__(self) -> tuple[Callable[[str], Loss], tuple[str]]:
        """Let other processes find the loss by its name: the functions cannot be sent."""
        return loss_named, (self.name,)


#: The losses by name.
LOSSES = {
    loss.name: loss
    for loss in (
        Loss("squares", np.inf, np.square, np.ones_like, np.ones_like),
        Loss(
            "huber", 1.345,
            lambda v: np.where(v <= 1.0, v**2, 2.0 * v - 1.0),
            lambda v: 1.0 / np.maximum(v, 1.0),
            lambda v: (v <= 1.0).astype(float),
        ),
        Loss(
            "cauchy", 2.3849,
            lambda v: np.log1p(v**2),
            lambda v: 1.0 / (1.0 + v**2),
            lambda v: (1.0 - v**2) / (1.0 + v**2) ** 2,
        ),
    )
}  # fmt: skip


def loss_named(name: str) -> Loss:
    """Return a loss by name.

    `name`, one of "squares", "huber", "cauchy". Raises `UnknownName` if there is no such loss.

    >>> loss_named("huber").weight(np.array([0.5, 1.0, 4.0])).tolist()
    [1.0, 1.0, 0.25]
    """
    if name not in LOSSES:
        raise UnknownName("loss", name, LOSSES)
    return LOSSES[name]


def robust_scale(residual: FloatArray) -> float:
    """Return the standard deviation of the noise in residuals with outliers.

    `residual`, shape (n,).

    >>> noise = np.random.default_rng(0).normal(size=10_000)
    >>> noise[:500] = 1e6
    >>> bool(abs(robust_scale(noise) - 1.0) < 0.1)
    True
    """
    return PER_MEDIAN * float(np.median(np.abs(residual))) if residual.size else 0.0
