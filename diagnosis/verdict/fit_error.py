"""Fit error of the baseline and the improved model and noise floor: training, cross-validation, hold-out."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt
from scipy.signal import savgol_filter

from tirefmu.estimation.smoothing import WINDOW, noise_of

from ..probing.effect_probing import Screen
from ..recording.signals import Signals

FloatArray = npt.NDArray[np.float64]

FitErrors = dict[str, dict[str, dict[str, float]]]


def noise_floor(signals: Signals) -> dict[str, float]:
    """Return each channel's noise, estimated without a model: scatter about local parabolas, corrected for correlation.

    Parameters
    ----------
    signals : Signals

    Returns
    -------
    dict of str to float
        Root mean square, N and N m.
    """
    found = {}
    for name, force, present in zip(signals.channels, signals.measured, signals.present, strict=True):
        rest = force - savgol_filter(force, WINDOW, 2)
        parts = np.array_split(np.argsort(np.abs(force[present])), 10)
        power = float(np.mean([(1.4826 * np.median(np.abs(rest[present][part]))) ** 2 for part in parts]))
        correction = noise_of(force)[0] / (1.4826 * float(np.median(np.abs(rest))) + 1e-300)
        found[name] = float(np.sqrt(power)) * correction
    return found


def fit_errors(before: Screen, after: Screen) -> FitErrors:
    """Return root mean square residuals, with the disturbances of the recording removed.

    Parameters
    ----------
    before, after : Screen
        Of the solutions of the baseline model and the improved model.

    Returns
    -------
    dict
        train, cv, holdout -> channel -> before, after, floor.
    """
    signals = after.signals
    floor = noise_floor(signals)
    rows = {"train": after.problem.inverse_noise > 0.0, "holdout": signals.present & signals.holdout}
    errors: FitErrors = {}
    for part, present in rows.items():
        errors[part] = {
            name: {
                "before": _rms(before.solution.residual[i], present[i]),
                "after": _rms(after.solution.residual[i], present[i]),
                "floor": floor[name],
            }
            for i, name in enumerate(signals.channels)
        }
    cross_validated = [_cross_validated(screen) for screen in (before, after)]
    errors["cv"] = {
        name: {
            "before": _rms(cross_validated[0][i], rows["train"][i]),
            "after": _rms(cross_validated[1][i], rows["train"][i]),
            "floor": floor[name],
        }
        for i, name in enumerate(signals.channels)
    }
    return errors


def _cross_validated(screen: Screen) -> FloatArray:
    """Return the residuals of each block with the estimate from the other blocks, N and N m."""
    residual = screen.residual.copy()
    for g, (first, last) in enumerate(zip(screen.edges[:-1], screen.edges[1:], strict=True)):
        residual[:, first:last] -= screen.tangent[:, first:last] @ screen.baseline.others[g]
    inverse_noise = screen.problem.inverse_noise
    return np.where(inverse_noise > 0.0, residual / np.where(inverse_noise > 0.0, inverse_noise, 1.0), 0.0)


def _rms(residual: FloatArray, present: npt.NDArray[np.bool_]) -> float:
    return float(np.sqrt(np.mean(residual[present] ** 2))) if present.any() else float("nan")
