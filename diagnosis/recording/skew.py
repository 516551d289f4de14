"""Skew of a recording: forces that are recorded later or earlier than the inputs."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import numpy.typing as npt

from ..thresholds import MAX_SKEW
from .disturbances import SKEW, Disturbances
from .simulation import Simulator

FloatArray = npt.NDArray[np.float64]


def with_skew(disturbances: Disturbances, simulator: Simulator, parameters: FloatArray) -> Disturbances:
    """Return the disturbances with a common delay of all forces, for small delays proportional to it.

    Parameters
    ----------
    disturbances : Disturbances
    simulator : Simulator
        Of a recording with time.
    parameters : ndarray, shape (n_parameters,)
    """
    signals = simulator.signals
    every = simulator.with_signals(replace(signals, rows=np.arange(len(signals.t))))
    t = signals.t
    with np.errstate(divide="ignore", invalid="ignore"):
        rate = np.gradient(every.forces(parameters), t, axis=1)
    column = -np.nan_to_num(rate, posinf=0.0, neginf=0.0)[:, signals.rows]
    return disturbances.with_columns((SKEW,), column[:, :, None], np.array([MAX_SKEW]))
