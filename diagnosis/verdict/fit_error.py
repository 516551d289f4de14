"""Fit error of the delivered tires and noise floor: training, cross-validation, hold-out.

The residuals are those of the tires that a diagnosis delivers, evaluated over the recording as `tirefmu evaluate` does.
Offsets and drift of the recording are subtracted; they are in the result (`Diagnosis.recording`, ``removed``).
"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from tirefmu.estimation.noise_floor import NoiseFloor, noise_floor
from tirefmu.measurements import Recording
from tirefmu.tires.signs import convert_signs
from tirefmu.tires.tire import Tire

from ..probing.effect_probing import Screen
from ..recording.signals import FORMULA_SIGNS

FloatArray = npt.NDArray[np.float64]

FitErrors = dict[str, dict[str, dict[str, float]]]


def delivered_residual(tire: Tire, recording: Recording, screen: Screen) -> FloatArray:
    """Return the residual of a tire over a recording, shape (n_channels, n), N and N m.

    Parameters
    ----------
    tire : Tire
    recording : Recording
    screen : Screen
        Its offsets and drift of the recording are subtracted. All other errors of the recording (cross-talk, waves, skew)
        are part of the residual, as a tire that is used does not correct them.

    Returns
    -------
    ndarray
        At the compared rows, in the sign convention of the computation.
    """
    signals, disturbances = screen.signals, screen.problem.disturbances
    slow = [i for i, name in enumerate(disturbances.names) if name.startswith(("offset", "drift"))]
    inputs = [name for name in recording.table if name == "t" or name in tire.inputs]
    computed = tire.evaluate(recording.table[inputs], signs=recording.signs)
    forces = convert_signs(computed[list(signals.channels)], recording.signs, FORMULA_SIGNS)
    simulated = forces.to_numpy(dtype=np.float64)[signals.rows].T
    return np.asarray(
        signals.measured - simulated - disturbances.columns[:, :, slow] @ screen.solution.disturbance[slow]
    )


def floors_of(recording: Recording, screen: Screen) -> dict[str, NoiseFloor]:
    """Return the noise floor of each channel (`tirefmu.estimation.noise_floor`).

    Parameters
    ----------
    recording : Recording
    screen : Screen
        Of the model whose residual has the smooth function added.
    """
    signals = screen.signals
    residuals = np.where(signals.present, screen.solution.residual, np.nan)
    return noise_floor(recording.table.iloc[signals.rows], dict(zip(signals.channels, residuals, strict=True)))


def residual_sizes(screen: Screen) -> dict[str, float]:
    """Return the root mean square residual of each channel with all errors of the recording removed, training rows."""
    used = screen.problem.inverse_noise > 0.0
    return {name: _rms(screen.solution.residual[i], used[i]) for i, name in enumerate(screen.signals.channels)}


def fit_errors(
    before: Screen, after: Screen, residuals: tuple[FloatArray, FloatArray], floors: dict[str, NoiseFloor]
) -> FitErrors:
    """Return root mean square residuals of the delivered tires, with the disturbances of the recording removed.

    Parameters
    ----------
    before, after : Screen
        Of the solutions of the baseline model and the improved model.
    residuals : tuple of ndarray, shapes (n_channels, n)
        Residuals of both delivered tires (`delivered_residual`).
    floors : dict of str to NoiseFloor

    Returns
    -------
    dict
        train, cv, holdout -> channel -> before, after, floor, floor_with_history.
    """
    signals = after.signals
    rows = {"train": after.problem.inverse_noise > 0.0, "holdout": signals.present & signals.holdout}
    validated = tuple(
        residual + _change_without_block(screen) for screen, residual in zip((before, after), residuals, strict=True)
    )
    parts = {"train": residuals, "cv": validated, "holdout": residuals}
    return {
        part: {
            name: {
                "before": _rms(first[i], rows.get(part, rows["train"])[i]),
                "after": _rms(last[i], rows.get(part, rows["train"])[i]),
                "floor": floors[name].floor,
                "floor_with_history": floors[name].with_history,
            }
            for i, name in enumerate(signals.channels)
        }
        for part, (first, last) in parts.items()
    }


def _change_without_block(screen: Screen) -> FloatArray:
    """Return the change of the residuals of each block if it is not used for the estimate, N and N m."""
    change = np.zeros_like(screen.residual)
    for g, (first, last) in enumerate(zip(screen.edges[:-1], screen.edges[1:], strict=True)):
        shift = screen.baseline.others[g] - screen.baseline.estimate
        change[:, first:last] -= screen.tangent[:, first:last] @ shift
    inverse_noise = screen.problem.inverse_noise
    return np.where(inverse_noise > 0.0, change / np.where(inverse_noise > 0.0, inverse_noise, 1.0), 0.0)


def _rms(residual: FloatArray, present: npt.NDArray[np.bool_]) -> float:
    return float(np.sqrt(np.mean(residual[present] ** 2))) if present.any() else float("nan")
