"""The correlation length of residuals: the number of correlated rows with the information of one independent row.

Three estimators were compared on noise of known correlation (`tests/estimation/test_correlation.py` repeats the study):

- Geyer's sums of autocovariances are correct for noise with a short correlation and for slow drift. A ripple with the
  wheel frequency truncates them: with a fifth of the variance in a ripple they give 10.7 rows instead of 15.2, in drive
  and brake recordings a seventh of the correct length.
- Variances of sums over batches of rows average the ripple. They require many batches, each much longer than the
  correlation of the noise: instead of 399 rows they give 177 with 20,000 rows and 16 with 2,000 rows, and the intervals
  are too narrow.
- Geyer's sums over such batches have neither error.

The module uses the maximum of the third estimator over several batch sizes. It is about a tenth too large for white
noise, and too large (3.3 instead of 1.5 with equal parts of ripple and noise) if ripple dominates. No estimator
converges for noise of unbounded memory, whose correlation length increases with the duration of the recording.
"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from tirefmu.symbolic.errors import DataError

FloatArray = npt.NDArray[np.float64]
#: Batch sizes: numbers of rows that are summed before autocovariances are computed; fewest sums for a batch size.
STRETCHES, FEWEST_SUMS = (1, 4, 16, 64), 200


def correlation_length(residual: npt.ArrayLike, segment: npt.ArrayLike | None = None) -> float:
    """Return the integrated autocorrelation time of a residual, in rows.

    1 + 2 sum rho_k over lags k, truncated at the first sum of two neighbors that is not positive, and monotone: the
    initial monotone sequence of Geyer, Practical Markov chain Monte Carlo, 1992; the maximum over the batch sizes
    `STRETCHES`. Autocovariances are about 0, the expectation under a correct model, not about the mean: a constant
    error of a whole sweep is fully correlated. Neither sums nor pairs span segments.

    Parameters
    ----------
    residual : array_like, shape (n,)
        In the order of time; NaN if not measured.
    segment : array_like of int, shape (n,), optional
        Number of the segment without gaps of each row; by default one segment.

    Returns
    -------
    float
        At least 1; 1 for a residual of 0, about 1.1 for white noise.

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
        # Variance of a sum relative to that of a sum of independent rows.
        counted = sum(float(np.sum(each)) for each in rows)
        excess = sum(float(np.sum(each**2)) for each in sums) / (power * counted) if counted else 0.0
        longest = max(longest, excess * _geyer(sums, [(each > 0.0).astype(np.float64) for each in rows]))
    return longest


def effective_sample_size(residual: npt.ArrayLike, segment: npt.ArrayLike | None = None) -> float:
    """Return the number of independent rows with the information of a correlated residual.

    Parameters
    ----------
    residual : array_like, shape (n,)
        Measured minus computed; NaN if not measured.
    segment : array_like of int, shape (n,), optional
        Number of the segment without gaps of each row; by default one segment.

    Returns
    -------
    float
        The number of finite residuals divided by their `correlation_length`.

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
    """Return sums over batches of rows, without an incomplete batch."""
    whole = len(values) // stretch * stretch
    return np.asarray(values[:whole].reshape(-1, stretch).sum(axis=1))


def _geyer(pieces: list[FloatArray], known: list[FloatArray]) -> float:
    """Return the initial monotone sequence estimate over segments with 0 for unknown values."""
    products, pairs = np.zeros((2, max(len(piece) for piece in pieces)))
    for piece, mask in zip(pieces, known, strict=True):
        if len(piece):
            products[: len(piece)] += _autocorrelation(piece)
            pairs[: len(piece)] += np.round(_autocorrelation(mask))
    if products[0] <= 0.0:
        return 1.0
    rho = np.where(pairs > 0, products / np.maximum(pairs, 1.0), 0.0) / (products[0] / pairs[0])
    couples = rho[: len(rho) // 2 * 2].reshape(-1, 2).sum(axis=1)
    # Sums of few pairs are noisy: the sequence is made monotone as well.
    ends = np.flatnonzero(couples <= 0.0)
    falling = np.minimum.accumulate(couples[: ends[0] if len(ends) else len(couples)])
    return max(1.0, float(2.0 * falling.sum() - 1.0))


def _autocorrelation(values: FloatArray) -> FloatArray:
    """Return sum over i of v_i v_(i+k) for each lag k, by fast transforms."""
    size = 2 ** int(np.ceil(np.log2(2 * len(values))))
    spectrum = np.fft.rfft(values, size)
    return np.asarray(np.fft.irfft(spectrum * np.conj(spectrum), size)[: len(values)])
