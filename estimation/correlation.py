"""The correlation length of residuals: how many rows of a slow recording carry the information of one independent row.

Two estimators were compared on noise of known correlation (`tests/estimation/test_correlation.py` repeats the study).
The sums of autocovariances used here are right for noise that fades within a few rows and for slow drift (within 25 %
at 20,000 rows and a correlation length of 400). Variances of sums over stretches of rows, the alternative, need many
stretches, each much longer than the memory of the noise: they report 40 % of a correlation length of 400 there, and 4 %
of it at 2,000 rows, so that intervals become too narrow. Both report too much where the residual repeats with the
wheel (3.3 and 2.5 instead of 1.5 for equal parts of ripple and noise). Neither converges for noise of unbounded
memory, whose correlation length grows with the length of the recording.
"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from tirefmu.symbolic.errors import DataError

FloatArray = npt.NDArray[np.float64]


def correlation_length(residual: npt.ArrayLike, segment: npt.ArrayLike | None = None) -> float:
    """Return the integrated autocorrelation time of a residual, in rows.

    1 + 2 sum rho_k over lags k, cut where the sum of two neighbors is no longer positive, and monotone: the initial
    monotone sequence of Geyer, Practical Markov chain Monte Carlo, 1992. The residual is taken about 0, its
    expectation under a correct model, not about its mean: an error that lasts for a whole sweep correlates over all
    of it. Pairs of rows never span segments.

    Parameters
    ----------
    residual : array_like, shape (n,)
        In the order of time; NaN where nothing was measured.
    segment : array_like of int, shape (n,), optional
        Rows that were logged without a gap have one number; one segment where None.

    Returns
    -------
    float
        At least 1; 1 for white noise and for a residual of 0.

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
    values = np.asarray(residual, dtype=np.float64)
    if not np.isfinite(values).any():
        raise DataError("no residual is finite: its correlation length cannot be computed")
    products, pairs = _lagged_products(values, np.zeros(len(values)) if segment is None else np.asarray(segment))
    if products[0] <= 0.0:
        return 1.0
    rho = np.where(pairs > 0, products / np.maximum(pairs, 1.0), 0.0) / (products[0] / pairs[0])
    couples = rho[: len(rho) // 2 * 2].reshape(-1, 2).sum(axis=1)
    # Few pairs make a noisy sum: the sequence has to fall as well.
    ends = np.flatnonzero(couples <= 0.0)
    falling = np.minimum.accumulate(couples[: ends[0] if len(ends) else len(couples)])
    return max(1.0, float(2.0 * falling.sum() - 1.0))


def effective_sample_size(residual: npt.ArrayLike, segment: npt.ArrayLike | None = None) -> float:
    """Return the number of independent rows that carry the information of a correlated residual.

    Parameters
    ----------
    residual : array_like, shape (n,)
        Measured minus model; NaN where nothing was measured.
    segment : array_like of int, shape (n,), optional
        Rows that were logged without a gap have one number; one segment where None.

    Returns
    -------
    float
        The number of finite residuals over their `correlation_length`.

    Raises
    ------
    DataError
        If no residual is finite.

    Examples
    --------
    >>> noise = np.random.default_rng(0).standard_normal(2000)
    >>> bool(effective_sample_size(noise) > 1700.0), bool(effective_sample_size(np.repeat(noise, 8)) < 2300.0)
    (True, True)
    """
    values = np.asarray(residual, dtype=np.float64)
    return float(np.isfinite(values).sum() / correlation_length(values, segment))


def _lagged_products(values: FloatArray, segment: npt.NDArray[np.generic]) -> tuple[FloatArray, FloatArray]:
    """Return sums of products r_i r_(i+k), and the number of pairs, for each lag k."""
    pieces = np.split(values, np.flatnonzero(segment[1:] != segment[:-1]) + 1)
    products, pairs = np.zeros((2, max(len(piece) for piece in pieces)))
    for piece in pieces:
        known = np.isfinite(piece)
        products[: len(piece)] += _autocorrelation(np.where(known, piece, 0.0))
        pairs[: len(piece)] += np.round(_autocorrelation(known.astype(np.float64)))
    return products, pairs


def _autocorrelation(values: FloatArray) -> FloatArray:
    """Return sum over i of v_i v_(i+k) for each lag k, by fast transforms."""
    size = 2 ** int(np.ceil(np.log2(2 * len(values))))
    spectrum = np.fft.rfft(values, size)
    return np.asarray(np.fft.irfft(spectrum * np.conj(spectrum), size)[: len(values)])
