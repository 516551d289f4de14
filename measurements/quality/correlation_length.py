"""Correlation length of residuals: the integrated autocorrelation time, in rows."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike, NDArray

from tirefmu.symbolic.errors import DataError


def correlation_length(residuals: ArrayLike, segments: Sequence[slice] | None = None) -> float:
    """Return the integrated autocorrelation time of residuals, in rows.

    1 + 2 sum rho_k over lags k. The sum ends where that of two consecutive lags is no longer positive (initial positive
    sequence, Geyer, 1992). The residuals are not centered: those of a correct model have mean 0, and an error that is
    constant over a sweep is correlated over all of it. Pairs of rows do not span segments.

    Parameters
    ----------
    residuals : array_like, shape (n,)
        NaN where nothing was measured.
    segments : sequence of slice, optional
        `Recording.segments`. Default: one segment.

    Returns
    -------
    float
        In rows, 1 at least.

    Raises
    ------
    DataError
        If no residual is finite.

    Examples
    --------
    >>> correlation_length(np.repeat([1.0, -1.0, 1.0, 1.0, -1.0, -1.0, 1.0, -1.0], 10)) > 5.0
    True
    >>> correlation_length([0.0, 0.0])
    1.0
    """
    values = np.asarray(residuals, dtype=np.float64)
    if not np.isfinite(values).any():
        raise DataError("no residual is finite: the correlation length is undefined")
    products, pairs = _lagged(values, segments or [slice(0, len(values))])
    if products[0] <= 0.0:
        return 1.0
    rho = np.where(pairs > 0, products / np.maximum(pairs, 1.0), 0.0) / (products[0] / pairs[0])
    sums = rho[: len(rho) // 2 * 2].reshape(-1, 2).sum(axis=1)
    # Sums over few pairs of rows are noisy: the sequence has to decrease as well (Geyer's monotone sequence).
    ends = np.flatnonzero(sums <= 0.0)
    decreasing = np.minimum.accumulate(sums[: ends[0] if len(ends) else len(sums)])
    return max(1.0, float(2.0 * decreasing.sum() - 1.0))


def _lagged(values: NDArray[np.float64], segments: Sequence[slice]) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return the sum of products r_i r_(i+k) and the number of pairs for each lag k, by fast Fourier transforms."""
    longest = max(segment.stop - segment.start for segment in segments)
    products, pairs = np.zeros(longest), np.zeros(longest)
    for segment in segments:
        known = np.isfinite(values[segment])
        length = len(known)
        if length:
            products[:length] += _autocorrelation(np.where(known, values[segment], 0.0))
            pairs[:length] += np.round(_autocorrelation(known.astype(np.float64)))
    return products, pairs


def _autocorrelation(values: NDArray[np.float64]) -> NDArray[np.float64]:
    size = 2 ** int(np.ceil(np.log2(2 * len(values))))
    spectrum = np.fft.rfft(values, size)
    return np.asarray(np.fft.irfft(spectrum * np.conj(spectrum), size)[: len(values)])
