"""Time between forces and inputs: skew, the response to a small delay, and what happens between two rows."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from scipy.ndimage import maximum_filter1d

from ...measurements.virtual_bench.bench_errors import MAX_SKEW
from ...numerics.arrays import FloatArray
from .simulation import Simulator


def delay_response(simulator: Simulator, parameters: FloatArray) -> FloatArray:
    """Return the change of the forces per second of delay, shape (n_channels, n), N/s and N m/s.

    `simulator`: of a recording with time. `parameters`, shape (n_parameters,).
    """
    signals = simulator.signals
    every = simulator.with_signals(replace(signals, rows=np.arange(len(signals.t))))
    with np.errstate(divide="ignore", invalid="ignore"):
        rate = np.gradient(every.forces(parameters), signals.t, axis=1)
    return np.asarray(-np.nan_to_num(rate, posinf=0.0, neginf=0.0)[:, signals.rows])


def between_rows(simulator: Simulator, parameters: FloatArray) -> FloatArray:
    """Return the standard deviation of what happens between two rows, shape (n_channels, n), N and N m.

    A recording does not say when between two rows an input changes. The polynomial through the six neighbors of a row
    misses the force there by a 20th of its sixth difference, which is small for a sweep and half of a step. The error
    is uniformly distributed, and moves by the largest skew of a bench.

    `parameters`, shape (n_parameters,).
    """
    signals = simulator.signals
    if not signals.timed or len(signals.t) < 7:
        return np.zeros(signals.measured.shape)
    every = simulator.with_signals(replace(signals, rows=np.arange(len(signals.t))))
    missed = np.abs(np.diff(np.nan_to_num(every.forces(parameters)), 6, axis=1)) / (20.0 * np.sqrt(3.0))
    reach = 1 + int(np.ceil(MAX_SKEW / float(np.median(np.diff(signals.t)))))
    wide = maximum_filter1d(np.pad(missed, ((0, 0), (3, 3))), 2 * reach + 1, axis=1)
    return np.asarray(wide[:, signals.rows])
