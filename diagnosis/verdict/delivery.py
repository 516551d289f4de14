"""Whether the improved tire is delivered: if its predictive density on the hold-out set is the larger one."""

from __future__ import annotations

import numpy as np

from ...drawing.labels import drawn_unit
from ...numerics.arrays import FloatArray
from ...numerics.ties import graded
from .fit_error import DeliveredResiduals, FitErrors


def reasons_against(errors: FitErrors, residuals: DeliveredResiduals) -> tuple[str, ...]:
    """Return the reason why an improved tire is not delivered, or nothing.

    `errors`: of the delivered tires (`fit_error.fit_errors`). `residuals`: of the same tires, from which the errors are
    computed.
    """
    gain = density_gain(residuals)
    if gain.sum() >= 0.0:  # NaN is a reason
        return ()
    worst = list(errors["holdout"])[int(np.argmin(graded(gain)))]  # of NaN, the first one
    error, unit = errors["holdout"][worst], drawn_unit(worst)
    return (
        f"it predicts the hold-out set worse than the baseline tire ({worst}: {error['after']:.3g} instead of "
        f"{error['before']:.3g} {unit})",
    )


def density_gain(residuals: DeliveredResiduals) -> FloatArray:
    """Return by how much the logarithm of the predictive density of the hold-out set increases, shape (n_channels,).

    Residuals are normal with the standard deviation that the tire has on the fitted rows: a tire that fits these better
    is more certain, and loses more where it is wrong.
    """
    return np.asarray(_log_density(residuals, residuals.after) - _log_density(residuals, residuals.before))


def _log_density(residuals: DeliveredResiduals, rows: FloatArray) -> FloatArray:
    squares = np.where(residuals.used, rows, 0.0) ** 2
    fitted, held = residuals.used & ~residuals.holdout, residuals.used & residuals.holdout
    variance = np.sum(squares, axis=1, where=fitted) / np.maximum(fitted.sum(axis=1), 1)
    variance = np.where(variance > 0.0, variance, 1e-300)
    return np.asarray(-0.5 * (held.sum(axis=1) * np.log(variance) + np.sum(squares, axis=1, where=held) / variance))
