"""Structure that drift of the channels' zeros explains as well.

The baseline model contains slow drift. A zero that drifts faster, while a bench changes pressure or load in few steps,
resembles an effect of that input. Such structure disappears if the drift may be faster.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import numpy.typing as npt

from tirefmu.measurements.virtual_bench.bench_errors import half_waves

from ..probing.effect_probing import Screen
from ..recording.disturbances import passed
from ..recording.signals import Signals
from ..thresholds import DRIFT_WAVES, FAST_DRIFT_PRIOR, FAST_DRIFT_WAVES, MIN_RETAINED_GAIN
from .structure import Structure

FloatArray = npt.NDArray[np.float64]


def is_drift(screen: Screen, structure: Structure) -> bool:
    """Return whether structure gains little if the zeros of the channels may drift as a random walk does.

    Parameters
    ----------
    screen : Screen
        Of the model without the structure.
    structure : Structure
    """
    problem, signals = screen.problem, screen.signals
    waves = _waves(signals)
    if not waves:
        return False
    names, columns, deviations = [], [], []
    for i, channel in enumerate(signals.channels):
        noise = 1.0 / float(np.median(problem.inverse_noise[i][signals.present[i]]))
        for k, wave in waves.items():
            column = np.zeros(signals.measured.shape)
            column[i] = wave
            names.append(f"fast_drift{k}_{channel}")
            columns.append(column)
            deviations.append(noise * FAST_DRIFT_PRIOR / k)
    disturbances = problem.disturbances.extended(tuple(names), np.stack(columns, axis=-1), np.array(deviations))
    drifting = replace(problem, disturbances=disturbances)
    tested = Screen(drifting, drifting.at(screen.solution.parameters, screen.solution.free))
    weighted = problem.inverse_noise[:, :, None] * structure.columns
    tested.learn_noise({0: weighted})
    gains = tested.baseline.loss - tested.response(weighted).loss
    return float(gains.sum()) < MIN_RETAINED_GAIN * float(structure.gains.sum())


def _waves(signals: Signals) -> dict[int, FloatArray]:
    """Return half waves of drift that the baseline model does not contain, slower than sweeps from side to side."""
    if not signals.timed:
        return {}
    named, reversals = signals.named(), 0
    for slip in (named["alpha"], named["kappa"]):
        large = slip[np.abs(slip) > 0.5 * np.abs(slip).max()]
        reversals += int(np.count_nonzero(np.diff(np.sign(large))))
    waves = half_waves(passed(signals, signals.t[signals.rows]), min(FAST_DRIFT_WAVES, reversals // 2))
    return dict(enumerate(waves[DRIFT_WAVES + 1 :], DRIFT_WAVES + 1))
