"""What every explanation contains beside its coefficients: discrepancies of the functional form, errors of the bench.

The discrepancy of the model is a Gaussian process over the inputs of the core, in proportion to the forces (Kennedy and
O'Hagan, Bayesian calibration of computer models, JRSS B 63, 2001). The discrepancy of an effect is one in proportion to
its own response, as no formula of an effect is exact. Both are approximated by random Fourier features (Rahimi and
Recht, Random features for large-scale kernel machines, 2007).
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np
from scipy.ndimage import uniform_filter1d

from ...measurements.virtual_bench.bench_errors import DRIFT_WAVES, MAX_SKEW, half_waves
from ...numerics.arrays import FloatArray
from ..signals.disturbances import LAGS, load_error_responses, passed
from ..signals.signals import Signals
from ..signals.simulation import Simulator
from ..signals.skew import time_derivatives
from ..thresholds import BLOCK_LENGTH
from ..unexplained.features import CORE_INPUTS

#: Drift that may explain structure: largest number of half waves, and prior standard deviation of the k-th one times k,
#: in noise standard deviations. The quotient is derived: a random walk has it. The size and the number are conventions.
FAST_DRIFT_WAVES, FAST_DRIFT_PRIOR = 12, 2.0
#: Prior standard deviation of the first half wave of the drift of the grip, as a share of the forces. Convention.
GRIP_DRIFT = 0.01
#: Prior standard deviation of the relative error of the load that follows the direction of slip: benches hold the load
#: within 1 %. More is attributed to the tire. Convention.
LOAD_ERROR_PRIOR = 0.005

#: Features of each channel, of the model and of each effect. Convention: computing time.
FEATURES = 30
#: Inputs of which the magnitude counts: a discrepancy is symmetric between left and right, driving and braking.
SYMMETRIC = ("alpha", "kappa", "gamma", "phit")
#: Lengths of the moving averages from which noise of the inputs differs, s. Convention.
AVERAGED = (0.1, 0.4)
#: Moments that follow the side force: their own sign changes within a sweep.
OF_SIDE_FORCE = ("Mz", "Mx")


def model_discrepancy(signals: Signals, forces: FloatArray) -> FloatArray:
    """Return the features of each channel, N and N m, shape (n_channels, n, k).

    A moment may also have an even part, which does not change its sign with the side force: it is in proportion to the
    magnitude of the force in the plane of the road.

    `forces`, shape (n_channels, n): of the baseline model.
    """
    size = np.sqrt(np.mean(np.nan_to_num(forces) ** 2, axis=1))
    proportional, even = forces.copy(), np.zeros_like(forces)
    if "Fy" in signals.channels:
        side = signals.channels.index("Fy")
        plane = np.hypot(forces[side], forces[signals.channels.index("Fx")] if "Fx" in signals.channels else 0.0)
        for i, name in enumerate(signals.channels):
            if name in OF_SIDE_FORCE:
                proportional[i] = forces[side] * size[i] / max(size[side], 1e-12)
                even[i] = plane * size[i] / max(size[side], 1e-12)
    named = signals.named()
    functions = smooth_functions({name: named[name] for name in sorted(CORE_INPUTS)}, FEATURES)
    columns = np.concatenate([_by_channel(rows, functions) for rows in (proportional, even)], axis=-1)
    return np.asarray(columns[:, :, np.any(columns, axis=(0, 1))])


def fast_drift(signals: Signals, inverse_noise: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return drift of the zeros that is faster than the slow drift of the disturbances, and its prior deviations.

    Shapes (n_channels, n, k) and (k,). The k-th half wave of a random walk has a deviation in proportion to 1 / k. The
    waves remain slower than sweeps from side to side.

    `inverse_noise`, shape (n_channels, n): reciprocal standard deviation of the noise, 1/N and 1/(N m).
    """
    waves, rows = _waves(signals)[:, DRIFT_WAVES:], np.ones_like(inverse_noise)
    noise = [1.0 / float(np.median(row[row > 0.0])) if (row > 0.0).any() else 1.0 for row in inverse_noise]
    numbers = 1.0 + DRIFT_WAVES + np.arange(waves.shape[1])
    return _by_channel(rows, waves), np.concatenate([size * FAST_DRIFT_PRIOR / numbers for size in noise])


def grip_drift(signals: Signals, forces: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return drift of all forces in proportion, as of a surface that wears or is cleaned, and its prior deviations.

    Shapes (n_channels, n, k) and (k,). What an effect explains better than such a drift has to vary otherwise.

    `forces`, shape (n_channels, n): of the baseline model.
    """
    waves = _waves(signals)
    deviation = np.asarray(GRIP_DRIFT / (1.0 + np.arange(waves.shape[1])))
    return np.nan_to_num(forces)[:, :, None] * waves, deviation


def _waves(signals: Signals) -> FloatArray:
    """Return half waves over the recording that are slower than sweeps from side to side, shape (n, k)."""
    if not signals.timed:
        return np.zeros((len(signals.rows), 0))
    named, reversals = signals.named(), 0
    for slip in (named["alpha"], named["kappa"]):
        large = slip[np.abs(slip) > 0.5 * np.abs(slip).max()]
        reversals += int(np.count_nonzero(np.diff(np.sign(large))))
    waves = half_waves(passed(signals, signals.t[signals.rows]), min(FAST_DRIFT_WAVES, reversals // 2))
    return np.stack(waves, axis=-1)[:, 1:]


def effect_discrepancy(response: FloatArray, inputs: Mapping[str, FloatArray], seed: int = 0) -> FloatArray:
    """Return the features of an effect, N and N m, shape (n_channels, n, k).

    `response`, shape (n_channels, n): the change of the forces by the effect. `inputs`: those of which its error is a
    function, at the compared rows. `seed`: of the random functions.
    """
    return _by_channel(response, smooth_functions(inputs, FEATURES, seed))


def envelope(response: FloatArray, signals: Signals) -> FloatArray:
    """Return the root mean square of a response over the length of a block around each row, shape (n_channels, n)."""
    if not signals.timed:
        return response
    rows = round(BLOCK_LENGTH / float(np.median(np.diff(signals.t[signals.rows]))))
    return np.asarray(np.sqrt(np.maximum(uniform_filter1d(response**2, max(rows, 1), axis=1, mode="nearest"), 0.0)))


def _by_channel(rows: FloatArray, functions: FloatArray) -> FloatArray:
    """Return the products of each channel with all functions, shape (n_channels, n, n_channels * n_functions)."""
    columns = np.zeros((len(rows), len(rows), *functions.T.shape))  # a column has its rows in one place
    for i, row in enumerate(rows):
        columns[i, i] = row * functions.T
    return columns.reshape(len(rows), -1, rows.shape[1]).swapaxes(1, 2)


def smooth_functions(inputs: Mapping[str, FloatArray], number: int, seed: int = 0) -> FloatArray:
    """Return random functions of inputs, each of shape (n,), shape (n, number).

    Combined with independent coefficients of variance 1 they are a Gaussian process of variance 1 whose length scale is
    the standard deviation of each input. The same inputs and the same seed always give the same functions.
    """
    columns = np.stack([np.abs(column) if name in SYMMETRIC else column for name, column in inputs.items()])
    spread = np.std(columns, axis=1, keepdims=True)
    axes = ((columns - columns.mean(axis=1, keepdims=True)) / np.where(spread > 1e-9, spread, 1.0))[spread[:, 0] > 1e-9]
    rng = np.random.default_rng(seed)
    frequencies, phases = rng.standard_normal((len(axes), number)), rng.uniform(0.0, 2.0 * np.pi, number)
    return np.asarray(np.sqrt(2.0 / number) * np.cos(axes.T @ frequencies + phases))


def bench_errors(simulator: Simulator, parameters: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return the responses of the forces to errors of the bench that depend on the tire, and their prior deviations.

    Skew of the recording (first), distortion of fast changes by sampling and smoothing, and errors of the load that
    follow the direction of slip: shapes (n_channels, n, k) and (k,), with k = 0 without time.
    """
    signals = simulator.signals
    if not signals.timed:
        return np.zeros((*signals.measured.shape, 0)), np.zeros(0)
    step = float(np.median(np.diff(signals.t)))
    columns = time_derivatives(simulator, parameters) * [-1.0, 1.0]
    loads = load_error_responses(simulator, parameters)
    # A line between two rows is wrong by an eighth of the squared step times the second derivative.
    deviations = [0.5 * MAX_SKEW, step**2 / 8.0, *(LOAD_ERROR_PRIOR for _ in LAGS)]
    return np.concatenate([columns, loads], axis=-1), np.array(deviations)


def input_noise_responses(simulator: Simulator, parameters: FloatArray) -> FloatArray:
    """Return the change of the forces if fast variations of an input are noise, shape (n_channels, n, k).

    They are the differences from moving averages of the input, up to three deviations of the noise that was removed:
    larger ones are movements of the bench. A coefficient of 1 states that all of the variation is noise.
    """
    signals, at = simulator.signals, simulator.forces(parameters)
    if not signals.timed:
        return np.zeros((*at.shape, 0))
    step, responses = float(np.median(np.diff(signals.t))), []
    for i, name in enumerate(signals.names):
        limit = 3.0 * signals.origin.noise.get(name, 0.0)
        for seconds in AVERAGED if limit > 0.0 else ():
            average = uniform_filter1d(signals.inputs[i], 2 * round(0.5 * seconds / step) + 1, mode="nearest")
            inputs = signals.inputs.copy()
            inputs[i] -= np.clip(inputs[i] - average, -limit, limit)
            responses.append(simulator.with_signals(replace(signals, inputs=inputs)).forces(parameters) - at)
    moved = [np.nan_to_num(response) for response in responses if np.any(np.nan_to_num(response))]
    return np.stack(moved, axis=-1) if moved else np.zeros((*at.shape, 0))
