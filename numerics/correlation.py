"""The correlation length of residuals: the number of correlated rows with the information of one independent row.

Three estimators were compared on noise of known correlation (`tests/numerics/test_correlation.py` repeats the study):

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

from ..boundary.errors import DataError
from .arrays import BoolArray, FloatArray, IndexArray

#: Batch sizes: numbers of rows that are summed before autocovariances are computed; fewest sums for a batch size.
STRETCHES, MIN_SUMS = (1, 4, 16, 64), 200
#: Numbers, with zeros appended to segments, that are transformed at a time.
MAX_VALUES = 1_000_000


def correlation_length(residual: npt.ArrayLike, segment: npt.ArrayLike | None = None) -> float:
    """Return the integrated autocorrelation time of a residual, in rows.

    1 + 2 sum rho_k over lags k, truncated at the first sum of two neighbors that is not positive, and monotone: the
    initial monotone sequence of Geyer, Practical Markov chain Monte Carlo, 1992; the maximum over the batch sizes
    `STRETCHES`. Autocovariances are about 0, the expectation under a correct model, not about the mean: a constant
    error of a whole sweep is fully correlated. Neither sums nor pairs span segments.

    `residual`, shape (n,): in the order of time; NaN if not measured. `segment`, shape (n,): number of the segment
    without gaps of each row; by default one segment. Returns: at least 1; 1 for a residual of 0, about 1.1 for white
    noise. Raises `DataError` if no residual is finite.

    >>> correlation_length(np.repeat([1.0, -1.0, 1.0, 1.0, -1.0, -1.0, 1.0, -1.0], 10)) > 5.0
    True
    >>> correlation_length([0.0, 0.0])
    1.0
    """
    values = np.asarray(residual, dtype=np.float64)
    if not np.isfinite(values).any():
        raise DataError("no residual is finite: its correlation length cannot be computed")
    finite = np.isfinite(values)
    power = float(np.mean(values[finite] ** 2))
    if power == 0.0:
        return 1.0
    numbers = np.zeros(len(values)) if segment is None else np.asarray(segment)
    edges = np.concatenate([[0], np.flatnonzero(np.diff(numbers)) + 1, [len(values)]])
    longest = 1.0
    for stretch in STRETCHES:
        if stretch > 1 and np.sum(np.diff(edges) // stretch) < MIN_SUMS:
            break
        sums, lengths = _summed(np.where(finite, values, 0.0), edges, stretch)
        rows, _ = _summed(finite.astype(np.float64), edges, stretch)
        # Variance of a sum relative to that of a sum of independent rows.
        counted = float(np.sum(rows))
        excess = float(np.mean(sums**2)) * len(sums) / (power * counted) if counted else 0.0
        longest = max(longest, excess * _geyer(sums, rows > 0.0, lengths))
    return longest


def effective_sample_size(residual: npt.ArrayLike, segment: npt.ArrayLike | None = None) -> float:
    """Return the number of independent rows with the information of a correlated residual.

    `residual`, shape (n,): measured minus computed; NaN if not measured. `segment`, shape (n,): number of the segment
    without gaps of each row; by default one segment. Returns: the number of finite residuals divided by their
    `correlation_length`. Raises `DataError` if no residual is finite.

    >>> noise = np.random.default_rng(0).standard_normal(2000)
    >>> bool(effective_sample_size(noise) > 1700.0), bool(effective_sample_size(np.repeat(noise, 8)) < 2300.0)
    (True, True)
    """
    values = np.asarray(residual, dtype=np.float64)
    return float(np.isfinite(values).sum() / correlation_length(values, segment))


def _summed(values: FloatArray, edges: IndexArray, stretch: int) -> tuple[FloatArray, IndexArray]:
    """Return sums over batches of rows, without the incomplete batch of each segment; and their number by segment."""
    lengths, incomplete = np.diff(edges) // stretch, np.diff(edges) % stretch
    whole = np.ones(len(values), dtype=np.bool_)
    within = np.arange(incomplete.sum()) - np.repeat(np.cumsum(incomplete) - incomplete, incomplete)
    whole[np.repeat(edges[1:] - incomplete, incomplete) + within] = False
    return np.asarray(values[whole].reshape(-1, stretch).sum(axis=1)), lengths


def _geyer(values: FloatArray, finite: BoolArray, lengths: IndexArray) -> float:
    """Return the initial monotone sequence estimate over segments with 0 for unknown values."""
    if not lengths.any():
        return 1.0
    products = _autocorrelation(values, lengths)
    if products[0] <= 0.0:
        return 1.0
    if finite.all():
        pairs = np.cumsum(np.cumsum(np.bincount(lengths)[:0:-1]))[::-1].astype(np.float64)
    else:
        pairs = np.round(_autocorrelation(finite.astype(np.float64), lengths))
    rho = np.where(pairs > 0, products / np.maximum(pairs, 1.0), 0.0) / (products[0] / pairs[0])
    couples = rho[: len(rho) // 2 * 2].reshape(-1, 2).sum(axis=1)
    # Sums of few pairs are noisy: the sequence is made monotone as well.
    ends = np.flatnonzero(couples <= 0.0)
    falling = np.minimum.accumulate(couples[: ends[0] if len(ends) else len(couples)])
    return max(1.0, float(2.0 * falling.sum() - 1.0))


def _autocorrelation(values: FloatArray, lengths: IndexArray) -> FloatArray:
    """Return sum over i of v_i v_(i+k) for each lag k within segments, by fast transforms of equal size."""
    starts, sums = np.cumsum(lengths) - lengths, np.zeros(lengths.max())
    sizes = 2 ** np.ceil(np.log2(2 * np.maximum(lengths, 1))).astype(np.intp)
    for size in np.unique(sizes[lengths > 0]).tolist():
        members = np.flatnonzero((sizes == size) & (lengths > 0))
        step = max(MAX_VALUES // size, 1)
        for some in (members[first : first + step] for first in range(0, len(members), step)):
            padded = np.zeros((len(some), size))
            for row, start, length in zip(padded, starts[some], lengths[some], strict=True):
                row[:length] = values[start : start + length]
            spectrum = np.fft.rfft(padded)
            del padded  # of a million rows each of these arrays is 17 MB
            power = np.einsum("ij,ij->j", spectrum.real, spectrum.real)
            power += np.einsum("ij,ij->j", spectrum.imag, spectrum.imag)
            lags = lengths[some].max()
            sums[:lags] += np.fft.irfft(power, size)[:lags]
    return sums
