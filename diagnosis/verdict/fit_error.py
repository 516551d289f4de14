"""How far model and measurement are apart: before, after, and the noise floor, in training and out of it."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt
from scipy.signal import savgol_filter

from tirefmu.estimation.smoothing import WINDOW, noise_of

from ..probing.effect_probing import Screen
from ..recording.signals import Signals

FloatArray = npt.NDArray[np.float64]

Gap = dict[str, dict[str, dict[str, float]]]


def noise_floor(signals: Signals) -> dict[str, float]:
    """Return each channel's noise without a model: scatter about local parabolas, correlation allowed for.

    Parameters
    ----------
    signals : Signals

    Returns
    -------
    dict of str to float
        Root mean square, N and N m.
    """
    found = {}
    for name, force, there in zip(signals.channels, signals.measured, signals.present, strict=True):
        rest = force - savgol_filter(force, WINDOW, 2)
        parts = np.array_split(np.argsort(np.abs(force[there])), 10)
        power = float(np.mean([(1.4826 * np.median(np.abs(rest[there][part]))) ** 2 for part in parts]))
        whole = noise_of(force)[0] / (1.4826 * float(np.median(np.abs(rest))) + 1e-300)
        found[name] = float(np.sqrt(power)) * whole
    return found


def gaps(before: Screen, after: Screen) -> Gap:
    """Return root mean squared misfits, the recording's disturbances taken out.

    Parameters
    ----------
    before, after : Screen
        Of the start model's and the improved model's solution.

    Returns
    -------
    dict
        train, cv, holdout -> channel -> before, after, floor.
    """
    signals = after.signals
    floor = noise_floor(signals)
    rows = {"train": after.problem.root > 0.0, "holdout": signals.present & signals.holdout}
    told: Gap = {}
    for part, there in rows.items():
        told[part] = {
            name: {
                "before": _rms(before.solution.residual[i], there[i]),
                "after": _rms(after.solution.residual[i], there[i]),
                "floor": floor[name],
            }
            for i, name in enumerate(signals.channels)
        }
    left_out = [_left_out(screen) for screen in (before, after)]
    told["cv"] = {
        name: {
            "before": _rms(left_out[0][i], rows["train"][i]),
            "after": _rms(left_out[1][i], rows["train"][i]),
            "floor": floor[name],
        }
        for i, name in enumerate(signals.channels)
    }
    return told


def _left_out(screen: Screen) -> FloatArray:
    """Return residuals of each block by the other blocks' estimate, in N and N m."""
    residual = screen.residual.copy()
    for g, (first, last) in enumerate(zip(screen.edges[:-1], screen.edges[1:], strict=True)):
        residual[:, first:last] -= screen.tangent[:, first:last] @ screen.base.others[g]
    root = screen.problem.root
    return np.where(root > 0.0, residual / np.where(root > 0.0, root, 1.0), 0.0)


def _rms(residual: FloatArray, there: npt.NDArray[np.bool_]) -> float:
    return float(np.sqrt(np.mean(residual[there] ** 2))) if there.any() else float("nan")
