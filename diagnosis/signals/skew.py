"""Time between forces and inputs: the response to a small delay, and what happens between two rows."""

from __future__ import annotations

import numpy as np
from scipy.ndimage import maximum_filter1d

from ...measurements.virtual_bench.bench_errors import MAX_SKEW
from ...numerics.arrays import FloatArray
from ...numerics.smoothing import rate_of
from .simulation import Simulator


def time_derivatives(simulator: Simulator, parameters: FloatArray) -> FloatArray:
    """Return the first and second derivatives of the forces by time, shape (n_channels, n, 2), in s.

    A delay changes the forces by minus the first one.

    `simulator`: of a recording with time. `parameters`, shape (n_parameters,).
    """
    signals = simulator.signals
    rate = rate_of(simulator.with_signals(signals.everywhere).forces(parameters), signals.t)
    return np.stack([rate, rate_of(rate, signals.t)], axis=-1)[:, signals.rows]


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
    forces = simulator.with_signals(signals.everywhere).forces(parameters)
    missed = np.abs(np.diff(np.nan_to_num(forces), 6, axis=1)) / (20.0 * np.sqrt(3.0))
    reach = 1 + int(np.ceil(MAX_SKEW / float(np.median(np.diff(signals.t)))))
    wide = maximum_filter1d(np.pad(missed, ((0, 0), (3, 3))), 2 * reach + 1, axis=1)
    return np.asarray(wide[:, signals.rows])
