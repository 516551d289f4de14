"""Error of the load that follows the direction of slip: response of the forces to it.

The controller of a bench lags behind the change of the loaded radius in a sweep, and load cells have hysteresis. The
recorded load is then too large while the slip grows and too small while it falls, or the reverse. All forces change in
proportion, as if friction and slip stiffness had a memory.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import numpy.typing as npt

from ...tires.states.transient import followed
from .simulation import Simulator

FloatArray = npt.NDArray[np.float64]

#: Time constants of the error behind the direction of slip, s: a load cell, and a controller.
LAGS = (0.0, 0.5)
#: Rate of change of slip, as a share of its root mean square, at which the error has three quarters of its size.
TURNING = 0.3


def load_error_responses(simulator: Simulator, parameters: FloatArray) -> FloatArray:
    """Return the change of the forces per relative error of the load, shape (n_channels, n, len(LAGS)).

    Parameters
    ----------
    simulator : Simulator
        Of a recording with time.
    parameters : ndarray, shape (n_parameters,)
    """
    signals = simulator.signals
    named = dict(zip(signals.names, signals.inputs, strict=True))
    slip = np.hypot(np.tan(named["alpha"]), named["kappa"])
    with np.errstate(divide="ignore", invalid="ignore"):
        rate = np.nan_to_num(np.gradient(slip, signals.t), posinf=0.0, neginf=0.0)
    direction = np.tanh(rate / (TURNING * float(np.sqrt(np.mean(rate**2))) + 1e-12))
    load, at = signals.names.index("Fz"), simulator.forces(parameters)
    responses = []
    for seconds in LAGS:
        rates = np.full(len(direction), 1.0 / seconds if seconds else np.inf)
        error = followed(signals.t, direction, rates, direction, hold=False).value
        inputs, step = signals.inputs.copy(), 0.01
        inputs[load] *= 1.0 + step * error
        responses.append((simulator.with_signals(replace(signals, inputs=inputs)).forces(parameters) - at) / step)
    return np.stack(responses, axis=-1)
