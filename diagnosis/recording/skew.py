"""Skew of a recording: forces that are recorded later than the inputs, and their response to a small delay."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import numpy.typing as npt

from .simulation import Simulator

FloatArray = npt.NDArray[np.float64]


def delay_response(simulator: Simulator, parameters: FloatArray) -> FloatArray:
    """Return the change of the forces per second of delay, shape (n_channels, n), N/s and N m/s.

    Parameters
    ----------
    simulator : Simulator
        Of a recording with time.
    parameters : ndarray, shape (n_parameters,)
    """
    signals = simulator.signals
    every = simulator.with_signals(replace(signals, rows=np.arange(len(signals.t))))
    with np.errstate(divide="ignore", invalid="ignore"):
        rate = np.gradient(every.forces(parameters), signals.t, axis=1)
    return np.asarray(-np.nan_to_num(rate, posinf=0.0, neginf=0.0)[:, signals.rows])
