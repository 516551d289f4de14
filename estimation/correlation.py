"""The correlation length of residuals: how many rows of a slow recording carry the information of one independent row.

Three estimators were compared on noise of known correlation (`tests/estimation/test_correlation.py` repeats the study).
Geyer's sums of autocovariances are right for noise that fades within a few rows and for slow drift, but a ripple that
repeats with the wheel ends them early: with a fifth of the variance in a ripple they report 10.7 rows of 15.2, on
recordings of drive and brake a seventh. Variances of sums over stretches of rows average the ripple out, but need many
stretches, each much longer than the memory of the noise: of a length of 399 rows they report 177 at 20,000 rows and 16
at 2,000, so that intervals become too narrow. Geyer's sums over such stretches have neither fault. The longest of the
lengths at several stretches is used; it is about a tenth too long for white noise, and too long (3.3 instead of 1.5 at
equal parts of ripple and noise) where nearly all is ripple. No estimator converges for noise of unbounded memory, whose
correlation length grows with the recording.
"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from tirefmu.symbolic.errors import DataError

FloatArray = npt.NDArray[np.float64]
#: Rows that are added up before their autocovariances are taken, and the fewest sums for which that is done.
STRETCHES, FEWEST_SUMS = (1, 4, 16, 64), 200


def correlation_length(residual: npt.ArrayLike, segment: npt.ArrayLike | None = None) -> float:
    """Return the integrated autocorrelation time of a residual, in rows.

    1 + 2 sum rho_k over lags k, cut where the sum of two neighbors is no longer positive, and monotone: the initial
    monotone sequence of Geyer, Practical Markov chain Monte Carlo, 1992; the longest of those of rows and of sums over
    `STRETCHES` of rows. The residual is taken about 0, its expectation under a correct model, not about its mean: an
    error that lasts for a whole sweep correlates over all of it. Neither sums nor pairs span segments.

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
    known = np.isfinite(values)
    power = float(np.mean(values[known] ** 2))
    if power == 0.0:
        return 1.0
    numbers = np.zeros(len(values)) if segment is None else np.asarray(segment)
    edges = np.flatnonzero(np.diff(numbers)) + 1
    pieces = np.split(np.where(known, values, 0.0), edges), np.split(known.astype(np.float64), edges)
    longest = 1.0
    for stretch in STRETCHES:
        sums, rows = ([_summed(piece, stretch) for piece in each] for each in pieces)
        if stretch > 1 and sum(map(len, sums)) < FEWEST_SUMS:
            break
        # By how much the variance of a sum exceeds that of a sum of independent rows.
        counted = sum(float(np.sum(each)) for each in rows)
        excess = sum(float(np.sum(each**2)) for each in sums) / (power * counted) if counted else 0.0
        longest = max(longest, excess * _geyer(sums, [(each > 0.0).astype(np.float64) for each in rows]))
    return longest


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


def _summed(values: FloatArray, stretch: int) -> FloatArray:
    """Return sums over stretches of rows, without the rows that fill none."""
    whole = len(values) // stretch * stretch
    return np.asarray(values[:whole].reshape(-1, stretch).sum(axis=1))


def _geyer(pieces: list[FloatArray], known: list[FloatArray]) -> float:
    """Return the initial monotone sequence estimate over pieces that are 0 where they are not known."""
    products, pairs = np.zeros((2, max(len(piece) for piece in pieces)))
    for piece, mask in zip(pieces, known, strict=True):
        if len(piece):
            products[: len(piece)] += _autocorrelation(piece)
            pairs[: len(piece)] += np.round(_autocorrelation(mask))
    if products[0] <= 0.0:
        return 1.0
    rho = np.where(pairs > 0, products / np.maximum(pairs, 1.0), 0.0) / (products[0] / pairs[0])
    couples = rho[: len(rho) // 2 * 2].reshape(-1, 2).sum(axis=1)
    # Few pairs make a noisy sum: the sequence has to fall as well.
    ends = np.flatnonzero(couples <= 0.0)
    falling = np.minimum.accumulate(couples[: ends[0] if len(ends) else len(couples)])
    return max(1.0, float(2.0 * falling.sum() - 1.0))


def _autocorrelation(values: FloatArray) -> FloatArray:
    """Return sum over i of v_i v_(i+k) for each lag k, by fast transforms."""
    size = 2 ** int(np.ceil(np.log2(2 * len(values))))
    spectrum = np.fft.rfft(values, size)
    return np.asarray(np.fft.irfft(spectrum * np.conj(spectrum), size)[: len(values)])
