"""Correlation of the residuals of neighboring rows, and the variance of weighted sums of such residuals.

The noise of a channel is white noise plus noise that is autoregressive of order 1: rho_k = a phi^k for lags k > 0. The
two parameters follow from the correlation of neighboring rows and from the correlation length (method of moments). So a
sum with slowly changing weights has the variance that the correlation length gives. A sum whose weights change sign
faster than the noise, as that of a slip stiffness in a quick sweep, has its smaller variance.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.linalg.lapack import dtbtrs

from ...numerics.arrays import FloatArray, IntArray

#: Largest correlation phi of neighboring rows: a memory of 500 rows. Chunks of rows are much longer.
MAX_CORRELATED = 0.998


@dataclass(frozen=True)
class NoiseCorrelation:
    """The correlation ``share * decay**k`` of residuals that are k > 0 rows apart in a segment.

    - `share`, `decay`: between 0 and 1.
    """

    share: float
    decay: float

    @classmethod
    def of(cls, residual: FloatArray, segment: IntArray, length: float) -> NoiseCorrelation:
        """Return the correlation of residuals with a known correlation length.

        `residual`, shape (n,): in the order of time. `segment`, shape (n,). `length`: their correlation length in rows,
        1 at least (`tirefmu.numerics.correlation`).

        >>> NoiseCorrelation.of(np.ones(5), np.zeros(5, dtype=int), 3.0)
        NoiseCorrelation(share=1.0, decay=0.5)
        """
        power = float(residual @ residual)
        if length <= 1.0 or power == 0.0:
            return cls(0.0, 0.0)
        together = segment[1:] == segment[:-1]
        neighbors = max(float((residual[1:] * residual[:-1])[together].sum()) / power, 0.0)
        # length = 1 + 2 share decay / (1 - decay), neighbors = share decay, and the share is 1 at most.
        decay = max(1.0 - 2.0 * neighbors / (length - 1.0), (length - 1.0) / (length + 1.0))
        decay = min(decay, MAX_CORRELATED)
        return cls(min(0.5 * (length - 1.0) * (1.0 - decay) / decay, 1.0), decay)

    def covariance(self, weights: FloatArray, segment: IntArray) -> FloatArray:
        """Return the covariance of weighted sums of noise of variance 1.

        `weights`, shape (n_sums, n). `segment`, shape (n,). Returns shape (n_sums, n_sums).

        >>> NoiseCorrelation(1.0, 0.5).covariance(np.ones((1, 3)), np.array([0, 0, 1]))
        array([[4.]])
        """
        sums = CorrelatedSums(self, len(weights))
        sums.add(np.array(weights, dtype=np.float64), segment)
        return sums.covariance


class CorrelatedSums:
    """The covariance of weighted sums of noise of variance 1; rows are added in parts.

    The correlation matrix of autoregressive noise is A^-T D A^-1; A has 1 on its diagonal and -decay above it. So each
    weight is added to the next one, reduced by the decay, and what has been added up is squared. The share of the last
    row in the covariance depends on the next one: whether both are in one segment.

    `n`: number of sums.
    """

    def __init__(self, noise: NoiseCorrelation, n: int) -> None:
        self._noise, self._last = noise, np.zeros(n)
        self._segment: int | None = None  # of the last row
        self._before = np.zeros((n, n))  # without the last row

    @property
    def covariance(self) -> FloatArray:
        """The covariance of the rows so far, shape (n, n)."""
        return self._before + self._noise.share * np.outer(self._last, self._last)

    def add(self, weights: FloatArray, segment: IntArray) -> None:
        """Add the next rows.

        `weights`, shape (n_sums, n): by rows; it is overwritten. `segment`, shape (n,).
        """
        share, n = self._noise.share, weights.shape[1]
        if not n:
            return
        self._before += (1.0 - share) * (weights @ weights.T)
        if share == 0.0:
            return
        joined = self._noise.decay if self._segment == segment[0] else 0.0
        self._before += share * (1.0 - joined**2) * np.outer(self._last, self._last)
        weights[:, 0] += joined * self._last
        decay = np.append(np.where(segment[1:] == segment[:-1], self._noise.decay, 0.0), 0.0)
        bands = np.stack([np.ones(n), -decay])
        added = np.asarray(dtbtrs(bands, weights.T, uplo="L", diag="U", overwrite_b=1)[0]).T
        self._last, self._segment = added[:, -1].copy(), int(segment[-1])
        added *= np.sqrt(1.0 - decay**2)
        self._before += share * (added[:, :-1] @ added[:, :-1].T)
