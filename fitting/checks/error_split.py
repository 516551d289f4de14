"""What the error of a model consists of: noise, a function of the inputs, of time or the past, differences of repeats.

The noise floor is what no model of inputs and time could remove. It is the scatter of the residual about short pieces
of a cubic in time, within a sweep. Every other row gives a second value: where two tires or two runs alternate, this
is smaller. Rows that are no time series have no such scatter; there, and where rows are few, the floor is that of
regressions on the inputs and the history of the slips, cross-validated (`tirefmu.numerics.noise_floor`). Pieces
that are too long, because the rows are few in time, contain changes of the model's error; the smallest of all values
counts.

The mean square above the floor has three parts, in this order: what a smooth function of the inputs explains; what
differs between repeats of an operating condition at equal slips, when smooth changes over time are removed; and the
rest, which changes slowly compared with the noise and therefore depends on time or on the past of the inputs.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise
from math import nan

import numpy as np
import pandas as pd

from ...numerics.arrays import FloatArray, IntArray
from ...numerics.noise_floor import (
    BLOCK,
    MAX_ROWS,
    MIN_ROWS,
    PARTS,
    SCALE,
    out_of_sample,
    random_features,
    slip_history,
    varying_inputs,
)
from ...numerics.ties import graded

#: Length of a piece of time that a cubic describes, s, its least number of rows, and its number of coefficients.
PIECE, MIN_PIECE, CUBIC = 0.25, 8, 4
#: Least share of the rows in such pieces for their scatter to count.
MIN_IN_PIECES = 0.5
#: Length scales, as shares of half the range, of inputs other than slips: forces depend on them weakly, but a tire may
#: differ at one of five loads.
SCALES = (SCALE, 0.3)
#: Parts of the range of an input, within which its values are equal in a comparison of repeats.
SLIP_PARTS = 20


@dataclass(frozen=True)
class ErrorSplit:
    """The parts of a root mean square error, in the unit of the channel; their squares add up to its square.

    - `noise`: the noise floor.
    - `inputs`: explained by a smooth function of the inputs, such as another form of the model.
    - `time`: explained by time or the past of the inputs: a lag, a memory, drift, a channel that is late.
    - `repeats`: differs between repeats of the same condition; 0 if nothing was repeated.
    """

    noise: float = nan
    inputs: float = nan
    time: float = nan
    repeats: float = nan


def error_split(
    table: pd.DataFrame, residuals: Mapping[str, FloatArray], segment: IntArray, cell: IntArray
) -> dict[str, ErrorSplit]:
    """Return the parts of the error of each channel of a recording.

    `table`: inputs of the recording in SI units; with ``t`` if known. `residuals`, shape (n_rows,): by channel:
    measured minus computed; NaN in rows that are not used. `segment`, shape (n_rows,): number of the piece without
    gaps. `cell`, shape (n_rows,): number of the operating condition and slip of a row. Returns: NaN with too few rows.

    >>> rng = np.random.default_rng(1)
    >>> t = np.arange(3000) / 50.0
    >>> alpha = 0.2 * np.sin(0.9 * t)
    >>> late = 50.0 * np.cos(0.9 * t)  # in proportion to the rate of alpha
    >>> table = pd.DataFrame({"t": t, "alpha": alpha})
    >>> cell = (alpha * 50.0).astype(int)
    >>> split = error_split(table, {"Fy": late + rng.normal(0.0, 10.0, 3000)}, np.zeros(3000, int), cell)["Fy"]
    >>> bool(9.0 < split.noise < 11.0), bool(split.time > 30.0 > 10.0 > split.inputs)
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
        scatter = _scatter(residual, segment, step) if step > 0.0 else (nan, nan)
        noise = float(np.nanmin([after_both, *scatter]))
        alternating = max(scatter[0] - noise, 0.0) if np.isfinite(scatter[0]) else 0.0
        differing = _between_segments(targets[i] - of_both[i], segment[rows], cell[rows]) + alternating
        repeats = min(differing, max(after_both - noise, 0.0))
        parts = (noise, total - after_inputs, after_inputs - noise - repeats, repeats)
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
    inputs, scales = varying_inputs(table)
    history = slip_history(table, t, step) if step > 0.0 else []
    regressions: list[FloatArray] = []
    for added in ([], history):
        candidates = []
        for scale in SCALES:
            lengths = [scale if fixed == SCALE else fixed for fixed in scales] + [1.0] * len(added)
            features = random_features([column[rows] for column in (*inputs, *added)], lengths)
            predicted = out_of_sample(features, targets, part)
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


def _scatter(residual: FloatArray, segment: IntArray, step: float) -> tuple[float, float]:
    """Return the mean square about cubics in time, of all rows and of every other row; NaN if too few are in pieces."""
    finite = np.flatnonzero(np.isfinite(residual))
    values, segments = residual[finite], segment[finite]
    edges = np.flatnonzero(np.diff(segments, prepend=-1, append=-1))
    variances = []
    for stride in (1, 2):
        length = max(MIN_PIECE, round(PIECE / (step * stride)))
        starts = np.concatenate(
            [np.arange(first + offset, last - stride * (length - 1), stride * length)
             for first, last in pairwise(edges.tolist()) for offset in range(stride)]
        ).astype(np.int64) if len(edges) > 1 else np.zeros(0, dtype=np.int64)  # fmt: skip
        if len(starts) * length < MIN_IN_PIECES * len(values) or not len(starts):
            variances.append(nan)
            continue
        basis, _ = np.linalg.qr(np.vander(np.linspace(-1.0, 1.0, length), CUBIC))
        pieces = values[starts[:, None] + stride * np.arange(length)]
        about = pieces - (pieces @ basis) @ basis.T
        variances.append(float(np.sum(about**2)) / (len(starts) * (length - CUBIC)))
    return variances[0], variances[1]


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
