"""Noise floor of a channel, and what the error of a model above it consists of. Fit and diagnosis use the same one.

The noise floor is the scatter that no model of inputs and time could remove. It is the scatter of the residual about
short pieces of a cubic in time, within a sweep. The noise of a sensor is correlated over a few rows, and a cubic
follows part of it: the correlation of neighbors within the pieces determines that part, under a first-order
autoregression. Where neighbors differ more than by noise, two tires or two runs alternate; the scatter of every other
row counts then. Rows that are no time series have no such scatter; there, and where rows are few, the floor is that of
regressions on the inputs and the history of the slips, cross-validated over blocks of time. Pieces that are too long,
because the rows are few in time, contain changes of the model's error; the smaller value counts.

The mean square above the floor has three parts, in this order: what a smooth function of the inputs explains; what
differs between repeats of an operating condition at equal slips, when smooth changes over time are removed; and the
rest, which changes slowly compared with the noise: it depends on time, on the past of the inputs, or on detail of the
inputs that is finer than such a function.

A smooth function is a ridge regression on random Fourier features of the inputs, an approximation of a Gaussian kernel
(Rahimi and Recht, Random features for large-scale kernel machines, 2007).
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from itertools import pairwise
from math import nan

import numpy as np
import pandas as pd
from scipy.linalg import matmul_toeplitz
from scipy.linalg.lapack import dposv
from scipy.ndimage import uniform_filter1d

from .arrays import FloatArray, IntArray
from .smoothing import noise_of, rate_of
from .ties import graded

#: Length scales of the smooth function, as shares of half an input's range: of the slips, which a program sweeps
#: through the whole curve, and of all other inputs, on which forces depend weakly.
SLIP_SCALE, SCALE = 0.2, 1.5
SLIPS = ("kappa", "alpha")
OTHERS = ("gamma", "Fz", "p", "V", "T", "phit")
#: An input varies if its range exceeds this multiple of its noise, and this share of its largest magnitude.
MIN_RANGE_IN_NOISE, MIN_SHARE = 8.0, 0.01
#: Number of features, largest number of rows, and number of parts for cross-validation.
FEATURES, MAX_ROWS, PARTS = 240, 4000, 8
#: Length of a block of time, s, and its least number of rows.
BLOCK, MIN_ROWS = 0.5, 5
#: Penalties of the ridge regression that are tried, relative to the mean square of a feature.
PENALTIES = (1e-4, 1e-3, 1e-2, 1e-1)
#: Time over which the direction of a slip's change is averaged, s.
DIRECTION_TIME = 0.1
#: Length of a piece of time that a cubic describes, s, its least number of rows, and its number of coefficients.
PIECE, MIN_PIECE, CUBIC = 0.25, 8, 4
#: Least share of the rows in such pieces for their scatter to count. Longest duration of a piece in that of its rows.
MIN_IN_PIECES, MAX_STRETCH = 0.5, 1.5
#: Length scales, as shares of half the range, of inputs other than slips: forces depend on them weakly, but a tire may
#: differ at one of five loads.
SCALES = (SCALE, 0.3)
#: Standard errors by which the correlation of neighbors is below that of white noise if two tires alternate.
ALTERNATING = 4.0
#: Correlation times that the noise may have, as shares of a piece: up to 0.03 s, as sensors and filters have. With
#: longer ones the ripple of a wheel would count as several times its size.
CORRELATION_TIMES = (0.0, *np.geomspace(0.01, 0.125, 30).tolist())


@dataclass(frozen=True)
class ErrorSplit:
    """The parts of a root mean square error, in the unit of the channel; their squares add up to its square.

    - `floor`: the noise floor.
    - `inputs`: explained by a smooth function of the inputs, such as another form of the model.
    - `time`: the rest, which changes slowly: a lag, a memory, drift, a channel that is late, or finer detail.
    - `repeats`: differs between repeats of the same condition; 0 if nothing was repeated.
    """

    floor: float = nan
    inputs: float = nan
    time: float = nan
    repeats: float = nan


def error_split(
    table: pd.DataFrame, residuals: Mapping[str, FloatArray], segment: IntArray, cell: IntArray | None = None
) -> dict[str, ErrorSplit]:
    """Return the parts of the error of each channel of a recording.

    `table`: inputs of the recording in SI units; with ``t`` if known. `residuals`, shape (n_rows,): by channel:
    measured minus computed; NaN in rows that are not used. `segment`, shape (n_rows,): number of the piece without
    gaps. `cell`, shape (n_rows,): number of the operating condition and slip of a row; without it, repeats are not
    compared. Returns: NaN for a channel without used rows.

    >>> rng = np.random.default_rng(1)
    >>> t = np.arange(3000) / 50.0
    >>> alpha = 0.2 * np.sin(0.9 * t)
    >>> late = 50.0 * np.cos(0.9 * t)  # in proportion to the rate of alpha
    >>> table = pd.DataFrame({"t": t, "alpha": alpha})
    >>> cell = (alpha * 50.0).astype(int)
    >>> split = error_split(table, {"Fy": late + rng.normal(0.0, 10.0, 3000)}, np.zeros(3000, int), cell)["Fy"]
    >>> bool(9.0 < split.floor < 11.0), bool(split.time > 30.0 > 10.0 > split.inputs)
    (True, True)
    """
    n = len(table)
    timed = "t" in table and n > 1
    t = table["t"].to_numpy(dtype=np.float64) if timed else np.arange(n, dtype=np.float64)
    step = float(np.median(np.diff(t))) if timed else 0.0
    rows = _sample(n)
    targets = np.stack([residual[rows] for residual in residuals.values()])
    of_inputs, of_both = _regressions(table, t, step, rows, targets)
    splits = {}
    for i, (name, residual) in enumerate(residuals.items()):
        total = _mean_square(residual)
        after_inputs = min(total, _mean_square(targets[i] - of_inputs[i]))
        after_both = min(after_inputs, _mean_square(targets[i] - of_both[i]))
        scatter, of_alternating = _scatter(residual, segment, t) if step > 0.0 else (nan, nan)
        floor = float(np.fmin(after_both, scatter))
        differing = max(of_alternating - floor, 0.0) if np.isfinite(of_alternating) else 0.0
        if cell is not None:
            differing += _between_segments(targets[i] - of_both[i], segment[rows], cell[rows])
        repeats = min(differing, max(after_both - floor, 0.0))
        parts = (floor, total - after_inputs, after_inputs - floor - repeats, repeats)
        splits[name] = ErrorSplit(*(float(np.sqrt(max(part, 0.0))) for part in parts))
    return splits


def _sample(n: int) -> IntArray:
    """Return `MAX_ROWS` rows at most in their order: one at random of each few rows, not every second or third one."""
    edges = np.linspace(0, n, min(n, MAX_ROWS) + 1).astype(np.int64)
    return edges[:-1] + np.random.default_rng(0).integers(np.diff(edges))


def _regressions(
    table: pd.DataFrame, t: FloatArray, step: float, rows: IntArray, targets: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Return the targets as functions of the inputs, and of inputs and history, out of sample; zero if too few rows."""
    length = MIN_ROWS if step <= 0.0 else max(MIN_ROWS, round(BLOCK / (step * len(table) / len(rows))))
    part = (np.arange(len(rows)) // length) % PARTS
    inputs, scales = _varying_inputs(table)
    history = _slip_history(table, t, step) if step > 0.0 else []
    regressions: list[FloatArray] = []
    for added in ([], history):
        candidates = []
        for scale in SCALES:
            lengths = [scale if fixed == SCALE else fixed for fixed in scales] + [1.0] * len(added)
            features = _random_features([column[rows] for column in (*inputs, *added)], lengths)
            predicted = _out_of_sample(features, targets, part)
            candidates.append(np.where(np.isfinite(predicted), predicted, 0.0))
        regressions.append(_best(candidates, targets))
    return regressions[0], _best(regressions, targets)


def _best(candidates: Sequence[FloatArray], targets: FloatArray) -> FloatArray:
    """Return for each target the prediction with the smallest error, or zero if none reduces it."""
    options = [np.zeros_like(targets), *candidates]
    errors = np.array([[_mean_square(y - x) for x, y in zip(option, targets, strict=True)] for option in options])
    best = graded(np.where(np.isfinite(errors), errors, np.inf)).argmin(axis=0)
    return np.stack([options[k][i] for i, k in enumerate(best)])


def _mean_square(values: FloatArray) -> float:
    finite = values[np.isfinite(values)]
    return float(np.mean(finite**2)) if finite.size else nan


def _scatter(residual: FloatArray, segment: IntArray, t: FloatArray) -> tuple[float, float]:
    """Return the variance of the noise about cubics in time, and that of all rows if two tires or two runs alternate.

    NaN if too few rows are in pieces; the second value also if nothing alternates.
    """
    finite = np.flatnonzero(np.isfinite(residual))
    values, segments, t = residual[finite], segment[finite], t[finite]
    every = _pieces(values, segments, t, 1)
    if not len(every):
        return nan, nan
    variance, alternates = _about_cubics(every)
    other = _pieces(values, segments, t, 2)
    if alternates and len(other):
        return min(variance, _about_cubics(other)[0]), variance
    return variance, nan


def _pieces(values: FloatArray, segment: IntArray, t: FloatArray, stride: int) -> FloatArray:
    """Return the values in pieces of every `stride`-th row, shape (m, length); none if too few rows are in pieces.

    A piece does not extend over rows that are absent.
    """
    step = stride * float(np.median(np.diff(t))) if len(t) > MIN_PIECE else 0.0
    if step <= 0.0:
        return np.empty((0, MIN_PIECE))
    length = max(MIN_PIECE, round(PIECE / step))
    edges = np.flatnonzero(np.diff(segment, prepend=-1, append=-1)).tolist()
    starts = np.concatenate(
        [np.arange(first + offset, last - stride * (length - 1), stride * length, dtype=np.int64)
         for first, last in pairwise(edges) for offset in range(stride)]
    )  # fmt: skip
    starts = starts[t[starts + stride * (length - 1)] - t[starts] < MAX_STRETCH * step * (length - 1)]
    starts = starts if len(starts) * length >= MIN_IN_PIECES * len(values) else starts[:0]
    return np.asarray(values[starts[:, None] + stride * np.arange(length)])


def _about_cubics(pieces: FloatArray) -> tuple[float, bool]:
    """Return the variance of noise with a first-order autoregression from pieces, and whether their rows alternate.

    `pieces`, shape (m, length). Rows alternate if neighbors are less correlated than those of white noise, by more than
    `ALTERNATING` standard errors.

    >>> rng = np.random.default_rng(0)
    >>> noise = rng.normal(0.0, 0.75**0.5, 60_000)
    >>> for i in range(1, len(noise)):
    ...     noise[i] += 0.5 * noise[i - 1]
    >>> variance, alternates = _about_cubics(noise.reshape(-1, 12))
    >>> bool(0.95 < variance < 1.05), alternates
    (True, False)
    """
    number, length = pieces.shape
    basis, variance, correlation = _expected(length)
    about = pieces - (pieces @ basis) @ basis.T
    power, product = float(np.sum(about**2)), float(np.sum(about[:, 1:] * about[:, :-1]))
    measured = product / power if power > 0.0 else 0.0
    error = 1.0 / np.sqrt(number * (length - CUBIC))
    alternates = bool(measured < correlation[0] - ALTERNATING * error)
    return power / (number * float(np.interp(measured, correlation, variance))), alternates


@cache
def _expected(length: int) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return the basis of cubics, shape (length, CUBIC), and what they leave of noise of variance 1.

    Returns: basis; the sum of squares and the correlation of neighbors that are expected about a cubic, both of shape
    (n_times,), by correlation time; the correlation increases.
    """
    basis, _ = np.linalg.qr(np.vander(np.linspace(-1.0, 1.0, length), CUBIC))
    variance, product = [], []
    for share in CORRELATION_TIMES:
        decay = np.exp(-np.arange(length) / (share * length)) if share else np.eye(1, length)[0]
        followed = matmul_toeplitz(decay, basis)
        twice = basis @ (basis.T @ followed)
        variance.append(length - float(np.sum(basis * followed)))
        shared = basis[:-1] * (followed - 0.5 * twice)[1:] + (followed - 0.5 * twice)[:-1] * basis[1:]
        product.append((length - 1) * float(decay[1]) - float(np.sum(shared)))
    return basis, np.array(variance), np.array(product) / np.array(variance)


def _between_segments(rest: FloatArray, segment: IntArray, cell: IntArray) -> float:
    """Return the variance between segments in equal cells: that of their means without the contribution of noise."""
    finite = np.isfinite(rest)
    groups = pd.DataFrame({"cell": cell[finite], "segment": segment[finite], "rest": rest[finite]})
    means = groups.groupby(["cell", "segment"])["rest"].agg(["mean", "var", "size"]).reset_index()
    means = means[means["size"] >= MIN_ROWS]
    means = means[means.groupby("cell")["segment"].transform("size") > 1]
    if means.empty:
        return 0.0
    between = means.groupby("cell")["mean"].var()
    noise = (means["var"] / means["size"]).groupby(means["cell"]).mean()
    return max(float((between - noise).mean()), 0.0)


def _varying_inputs(table: pd.DataFrame) -> tuple[list[FloatArray], list[float]]:
    """Return the inputs that vary, from -1 to 1, and their length scales."""
    columns, scales = [], []
    for name in (*SLIPS, *OTHERS):
        if name not in table:
            continue
        values = table[name].to_numpy(dtype=np.float64)
        if not np.isfinite(values).all():  # not recorded here, but in another recording of the same fit
            continue
        lower, upper = np.quantile(values, [0.005, 0.995])
        noise = noise_of(values)[0] if len(values) > 3 * MIN_ROWS else 0.0
        if upper - lower > max(MIN_RANGE_IN_NOISE * noise, MIN_SHARE * float(np.abs(values).max())):
            columns.append(2.0 * (values - lower) / (upper - lower) - 1.0)
            scales.append(SLIP_SCALE if name in SLIPS else SCALE)
    return columns, scales


def _slip_history(table: pd.DataFrame, t: FloatArray, step: float) -> list[FloatArray]:
    """Return the direction in which each slip changes, and time, from -1 to 1."""
    width = max(3, round(DIRECTION_TIME / step))
    columns = [2.0 * (t - t[0]) / max(float(t[-1] - t[0]), 1e-9) - 1.0]
    for name in SLIPS:
        if name in table and float(np.ptp(table[name].to_numpy(dtype=np.float64))) > 0.0:  # False with NaN
            slope = rate_of(table[name].to_numpy(dtype=np.float64), t)
            slope = uniform_filter1d(slope, width, mode="nearest")
            columns.append(np.tanh(slope / (0.3 * float(np.sqrt(np.mean(slope**2))) + 1e-12)))
    return columns


def _random_features(columns: Sequence[FloatArray], scales: Sequence[float]) -> FloatArray:
    """Return random Fourier features, shape (n, FEATURES + 1); the same for the same inputs."""
    rng = np.random.default_rng(0)
    n = len(columns[0]) if columns else 0
    if not columns:
        return np.ones((n, 1))
    waves = rng.standard_normal((len(columns), FEATURES))
    at = np.stack([column / scale for column, scale in zip(columns, scales, strict=True)], axis=1)
    turned = np.cos(at @ waves + rng.uniform(0.0, 2.0 * np.pi, FEATURES)) * np.sqrt(2.0)
    return np.concatenate([turned, np.ones((n, 1))], axis=1)


def _out_of_sample(features: FloatArray, targets: FloatArray, part: IntArray) -> FloatArray:
    """Return a ridge regression of each target in parts that it did not use, with the best penalty.

    `features`, shape (n, n_features). `targets`, shape (n_targets, n): NaN in rows that are not used. `part`, shape
    (n,): from 0 to `PARTS` - 1. Returns shape (n_targets, n): NaN in rows that are not used, and of a target with too
    few rows.
    """
    predicted = np.full(targets.shape, np.nan)
    masks = np.isfinite(targets)
    for mask in {mask.tobytes(): mask for mask in masks}.values():
        same = np.flatnonzero((masks == mask).all(axis=1))
        if int(mask.sum()) >= PARTS * MIN_ROWS and len(features):
            at = np.ix_(same, np.flatnonzero(mask))
            predicted[at] = _predicted(features[mask], targets[at].T, part[mask]).T
    return predicted


def _predicted(features: FloatArray, targets: FloatArray, part: IntArray) -> FloatArray:
    pieces = [(features[part == k], targets[part == k]) for k in range(PARTS)]
    matrices, products = [x.T @ x for x, _ in pieces], [x.T @ y for x, y in pieces]
    matrix, product = np.sum(matrices, axis=0), np.sum(products, axis=0)
    predicted = np.empty((len(PENALTIES), *targets.shape))
    for number, ((x, _), block, own_product) in enumerate(zip(pieces, matrices, products, strict=True)):
        others, right = matrix - block, product - own_product
        for k, penalty in enumerate(PENALTIES):
            ridge = others.copy()
            ridge.flat[:: len(ridge) + 1] += penalty * len(features)
            predicted[k, part == number] = x @ dposv(ridge.T, right, overwrite_a=True)[1]  # symmetric: not copied
    best = np.sum((targets - predicted) ** 2, axis=1).argmin(axis=0)
    return np.asarray(predicted[best, :, np.arange(targets.shape[1])].T)
