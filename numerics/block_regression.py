"""Linear regression with noise that is correlated in time: estimates, covariances, cross-validation.

There are two covariances of the estimate. The jackknife omits one block of time at a time (the cluster variance CR3:
Bell and McCaffrey, Bias reduction in standard errors for linear regression with multi-stage samples, 2002). The other
is propagated from the autocovariance of the noise.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise

import numpy as np
import numpy.typing as npt
from scipy import fft

from .arrays import BoolArray, FloatArray, IntArray


@dataclass(frozen=True, eq=False)
class BlockSums:
    """Cross products of columns and a residual for each block.

    - `matrix`, shape (n_blocks, m, m).
    - `target`, shape (n_blocks, m).
    - `power`, shape (n_blocks,): sum of squares of the residual.
    """

    matrix: FloatArray
    target: FloatArray
    power: FloatArray


def block_sums(columns: FloatArray, residual: FloatArray, edges: IntArray) -> BlockSums:
    """Return cross products by block.

    `columns`, shape (n_channels, n, m): weighted. `residual`, shape (n_channels, n): weighted. `edges`, shape (n_blocks
    + 1,): first row of each block, and the number of all rows.
    """
    m = columns.shape[-1]
    matrix, target, power = [], [], []
    for first, last in pairwise(edges.tolist()):
        part = columns[:, first:last].reshape(-1, m)
        rest = residual[:, first:last].ravel()
        matrix.append(part.T @ part)
        target.append(part.T @ rest)
        power.append(rest @ rest)
    return BlockSums(np.array(matrix), np.array(target), np.array(power))


@dataclass(frozen=True, eq=False)
class Regression:
    """Regression of a residual on columns.

    - `estimate`, shape (m,).
    - `jackknife`, shape (m, m): covariance of the estimate by the jackknife over blocks.
    - `loss`, shape (n_blocks,): sum of squared residuals in each block with the estimate from the other blocks.
    - `inverse`, shape (m, m): inverse of the normal matrix with the priors.
    - `others`, shape (n_blocks, m): the estimate without each block.
    """

    estimate: FloatArray
    jackknife: FloatArray
    loss: FloatArray
    inverse: FloatArray
    others: FloatArray


def regression(sums: BlockSums, belief: FloatArray, pull: FloatArray | None = None) -> Regression:
    """Return the regression, and the estimates without each block.

    `belief`, shape (m,): precision (inverse variance) of the prior of each coefficient, with mean 0. `pull`, shape
    (m,): contribution of the priors to the target, if the residual belongs to coefficients away from the prior means.
    """
    matrix, target = sums.matrix.sum(axis=0) + np.diag(belief), sums.target.sum(axis=0)
    if pull is not None:
        target = target + pull
    scale = 1.0 / np.sqrt(np.maximum(np.diag(matrix), 1e-300))
    ridge = 1e-11 * np.eye(len(scale))
    whole = scale[:, None] * matrix * scale + ridge
    inverse = scale[:, None] * np.linalg.inv(whole) * scale
    estimate = inverse @ target
    without = scale[:, None] * (matrix - sums.matrix) * scale + ridge
    others = scale * np.linalg.solve(without, (scale * (target - sums.target))[:, :, None])[:, :, 0]
    loss = (
        sums.power
        - 2.0 * np.einsum("gm,gm->g", others, sums.target)
        + np.einsum("gm,gmk,gk->g", others, sums.matrix, others)
    )
    n = len(sums.power)
    spread = others - others.mean(axis=0)
    return Regression(estimate, (n - 1) / n * spread.T @ spread, loss, inverse, others)


def error_of_sum(gains: FloatArray) -> float:
    """Return the standard error of the sum of independent gains, shape (n_blocks,).

    >>> round(error_of_sum(np.array([1.0, 3.0])), 12)
    2.0
    """
    return float(np.sqrt(len(gains)) * np.std(gains, ddof=1))


def autocovariance(residual: FloatArray, present: BoolArray, lags: int) -> FloatArray:
    """Return covariances of channels over time, tapered, shape (n_channels, n_channels, lags + 1).

    `residual`, shape (n_channels, n): weighted, 0 if not present. `present`, shape (n_channels, n). `lags`: the largest
    lag; Parzen's taper makes the spectrum positive.
    """
    size = fft.next_fast_len(residual.shape[1] + lags + 1)
    waves, mask = fft.rfft(residual, size), fft.rfft(present.astype(np.float64), size)

    def products(x: npt.NDArray[np.complex128]) -> FloatArray:
        return np.asarray(fft.irfft(x.conj()[:, None] * x[None, :], size)[:, :, : lags + 1])

    count = np.maximum(products(mask), 1.0)
    lag = np.arange(lags + 1) / (lags + 1)
    taper = np.where(lag <= 0.5, 1.0 - 6.0 * lag**2 + 6.0 * lag**3, 2.0 * (1.0 - lag) ** 3)
    return np.asarray(products(waves) / count * taper)


def coloured_covariance(traces: FloatArray, covariance: FloatArray) -> FloatArray:
    """Return the covariance of products of traces and coloured noise, shape (m, m).

    `traces`, shape (n_channels, n, m): 0 in rows that are not used. `covariance`, shape (n_channels, n_channels, lags +
    1): from `autocovariance`.
    """
    _, n, m = traces.shape
    lags = covariance.shape[-1] - 1
    size = fft.next_fast_len(n + lags + 1)
    waves = fft.rfft(traces, size, axis=1)
    kernel = np.zeros((*covariance.shape[:2], size))
    kernel[:, :, : lags + 1] = covariance
    if lags:
        kernel[:, :, -lags:] = covariance.transpose(1, 0, 2)[:, :, :0:-1]
    spectrum = fft.rfft(kernel, axis=-1)
    coloured = fft.irfft(np.einsum("cdf,cfm->dfm", spectrum, waves), size, axis=1)[:, :n]
    return np.asarray(traces.reshape(-1, m).T @ coloured.reshape(-1, m))
