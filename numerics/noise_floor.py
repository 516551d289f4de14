"""Noise floor of a channel: what remains of a model's residual if any smooth function of the inputs is added to it.

The smooth function is a ridge regression on random Fourier features of the inputs, an approximation of a Gaussian
kernel (Rahimi and Recht, Random features for large-scale kernel machines, 2007). It is cross-validated over blocks of
time, so that it cannot follow the noise. A model whose residual is at the floor lacks no effect of the inputs. A second
floor is that of functions that also depend on the direction in which the slips change and on slow time: a model whose
residual is at the first floor and far above the second one lacks a memory or an input that was not recorded.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
import pandas as pd
from scipy.linalg.lapack import dposv
from scipy.ndimage import uniform_filter1d

from .arrays import FloatArray, IntArray
from .smoothing import noise_of

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


@dataclass(frozen=True)
class NoiseFloor:
    """Noise floors of a channel, root mean square in its unit.

    - `floor`: with a smooth function of the recorded inputs.
    - `with_history`: with a smooth function of the inputs, the direction in which the slips change, and slow time.
    """

    floor: float
    with_history: float


def noise_floor(
    table: pd.DataFrame, residuals: Mapping[str, FloatArray], *, with_history: bool = True
) -> dict[str, NoiseFloor]:
    """Return the noise floors of the channels of a recording.

    `table`: inputs of the recording in SI units; with ``t`` if known. `residuals`, shape (n_rows,): by channel:
    measured minus computed; NaN in rows that are not used. `with_history`: whether to compute the second floor, too;
    otherwise it is NaN. Returns: at most the root mean square of the residual; NaN if a channel has too few rows.

    >>> rng = np.random.default_rng(1)
    >>> alpha = 0.2 * np.sin(np.linspace(0.0, 60.0, 3000))
    >>> missing = 50.0 * np.cos(20.0 * alpha)
    >>> table = pd.DataFrame({"t": np.arange(3000) / 50.0, "alpha": alpha})
    >>> floors = noise_floor(table, {"Fy": missing + rng.normal(0.0, 10.0, 3000)})
    >>> bool(9.0 < floors["Fy"].floor < 11.0)
    True
    """
    n = len(table)
    timed = "t" in table and n > 1
    t = table["t"].to_numpy(dtype=np.float64) if timed else np.arange(n, dtype=np.float64)
    step = float(np.median(np.diff(t))) if timed else 1.0
    rows = np.arange(n)[:: max(1, -(-n // MAX_ROWS))]
    length = max(MIN_ROWS, round(BLOCK / (step * (rows[1] - rows[0])))) if timed and step > 0.0 else MIN_ROWS
    part = (np.arange(len(rows)) // length) % PARTS
    inputs, scales = varying_inputs(table)
    columns = [(inputs, scales)]
    if with_history:
        history = slip_history(table, t, step) if timed and step > 0.0 else []
        columns.append(([*inputs, *history], [*scales, *[1.0] * len(history)]))
    targets = np.stack([residual[rows] for residual in residuals.values()])
    errors = [
        _cross_validated(random_features([column[rows] for column in history_inputs], lengths), targets, part)
        for history_inputs, lengths in columns
    ]
    floors = {}
    for i, (name, residual) in enumerate(residuals.items()):
        finite = residual[np.isfinite(residual)]
        scatter = float(np.sqrt(np.mean(finite**2))) if finite.size else float("nan")
        floor = min(scatter, float(errors[0][i])) if np.isfinite(errors[0][i]) else float("nan")
        second = float("nan")
        if with_history:
            second = min(floor, float(errors[1][i])) if np.isfinite(errors[1][i]) else floor
        floors[name] = NoiseFloor(floor, second)
    return floors


def varying_inputs(table: pd.DataFrame) -> tuple[list[FloatArray], list[float]]:
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


def slip_history(table: pd.DataFrame, t: FloatArray, step: float) -> list[FloatArray]:
    """Return the direction in which each slip changes, and time, from -1 to 1."""
    width = max(3, round(DIRECTION_TIME / step))
    columns = [2.0 * (t - t[0]) / max(float(t[-1] - t[0]), 1e-9) - 1.0]
    for name in SLIPS:
        if name in table and float(np.ptp(table[name].to_numpy(dtype=np.float64))) > 0.0:  # False with NaN
            with np.errstate(divide="ignore", invalid="ignore"):
                slope = np.gradient(table[name].to_numpy(dtype=np.float64), t)
            slope = uniform_filter1d(np.where(np.isfinite(slope), slope, 0.0), width, mode="nearest")
            columns.append(np.tanh(slope / (0.3 * float(np.sqrt(np.mean(slope**2))) + 1e-12)))
    return columns


def random_features(columns: Sequence[FloatArray], scales: Sequence[float]) -> FloatArray:
    """Return random Fourier features, shape (n, FEATURES + 1); the same for the same inputs."""
    rng = np.random.default_rng(0)
    n = len(columns[0]) if columns else 0
    if not columns:
        return np.ones((n, 1))
    waves = rng.standard_normal((len(columns), FEATURES))
    at = np.stack([column / scale for column, scale in zip(columns, scales, strict=True)], axis=1)
    turned = np.cos(at @ waves + rng.uniform(0.0, 2.0 * np.pi, FEATURES)) * np.sqrt(2.0)
    return np.concatenate([turned, np.ones((n, 1))], axis=1)


def _cross_validated(features: FloatArray, targets: FloatArray, part: IntArray) -> FloatArray:
    """Return the root mean square error of each target in parts that the regression did not use, the best penalty."""
    errors = targets - out_of_sample(features, targets, part)
    finite = np.isfinite(errors)
    squares, counts = np.where(finite, errors**2, 0.0).sum(axis=1), finite.sum(axis=1)
    return np.where(counts > 0, np.sqrt(squares / np.maximum(counts, 1)), np.nan)


def out_of_sample(features: FloatArray, targets: FloatArray, part: IntArray) -> FloatArray:
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
        for k, penalty in enumerate(PENALTIES):
            ridge = penalty * len(features) * np.eye(features.shape[1])
            predicted[k, part == number] = x @ dposv(matrix - block + ridge, product - own_product)[1]
    best = np.sum((targets - predicted) ** 2, axis=1).argmin(axis=0)
    return np.asarray(predicted[best, :, np.arange(targets.shape[1])].T)
