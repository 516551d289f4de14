"""Fit error of the delivered tires and its parts: training, cross-validation, hold-out; and which tire is delivered.

The residuals are those of the tires that a diagnosis delivers, evaluated over the recording as `tirefmu evaluate` does.
Offsets and drift of the recording are subtracted; they are in the result (`Diagnosis.recording`, ``removed``). The
improved tire is delivered if its predictive density on the hold-out set is the larger one.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np
import pandas as pd

from ...drawing.labels import drawn_unit
from ...measurements import Recording
from ...measurements.state_starts import with_fitted_starts
from ...numerics.arrays import BoolArray, FloatArray
from ...numerics.noise_floor import ErrorSplit, error_split
from ...numerics.ties import graded
from ...tires.evaluation import Conventions, evaluate
from ...tires.signs import convert_signs
from ...tires.tire import Tire
from ..least_squares import density_gains
from ..probing.effect_probing import Screen
from ..signals.disturbances import removed_at
from ..signals.outliers import short_range
from ..signals.signals import FORMULA_SIGNS, Signals

FitErrors = dict[str, dict[str, dict[str, float]]]


@dataclass(frozen=True, eq=False)
class DeliveredResiduals:
    """Residuals of the delivered tires over the compared rows of a recording, N and N m.

    - `signals`: of the solutions, over the compared rows.
    - `before`, `after`, shape (n_channels, n): of the baseline tire and the improved tire, in the sign convention of
      the computation.
    - `used`, shape (n_channels, n): false if a channel was not measured or is an outlier.
    """

    signals: Signals
    before: FloatArray
    after: FloatArray
    used: BoolArray

    def outlier_rows(self) -> dict[str, list[int]]:
        """Return the rows that are outliers by channel, counted from 0."""
        outliers = zip(self.signals.channels, np.isfinite(self.before) & ~self.used, strict=True)
        return {name: self.signals.table_rows[rows].tolist() for name, rows in outliers}


def delivered_residuals(before: FloatArray, after: FloatArray, signals: Signals) -> DeliveredResiduals:
    """Return the residuals of both tires over the compared rows of a recording.

    `before`, `after`, shape (n_channels, n_rows): of the baseline tire and the improved tire (`residual_of`).
    """
    first, last = (residual[:, signals.table_rows] for residual in (before, after))
    used = [short_range(np.nan_to_num(row), np.isfinite(row))[1] for row in first]
    return DeliveredResiduals(signals, first, last, signals.present & used)


def fitted_residuals(before: Screen, after: Screen) -> DeliveredResiduals:
    """Return the residuals of both solutions as the fits computed them, from inputs without noise.

    A state that follows the direction of slip follows noise of the slip, too. Whether a tire with states is better is
    therefore decided with these inputs.
    """
    return DeliveredResiduals(after.signals, before.solution.residual, after.solution.residual, after.signals.present)


def without_skew(recording: Recording, signals: Signals) -> Recording:
    """Return a recording with inputs that are delayed by the skew, as the forces are.

    `signals`: of this recording.
    """
    if not signals.skew:
        return recording
    table, names = recording.table, [name for name in signals.names if name in recording.table]
    t, inputs = table["t"].to_numpy(dtype=np.float64), table[names].to_numpy(dtype=np.float64).T
    late = replace(signals, t=t, inputs=inputs).delayed(signals.skew).inputs
    return replace(recording, table=table.assign(**dict(zip(names, late, strict=True))))


def computed_by(tire: Tire, recording: Recording) -> pd.DataFrame:
    """Return outputs and states of a tire in every row of a recording, in its signs.

    `recording`: without skew (`without_skew`).
    """
    recording = with_fitted_starts(tire, recording)
    inputs = [name for name in recording.table if name == "t" or name in tire.inputs]
    computed = evaluate(tire, recording.table[inputs], Conventions(recording.signs))
    return computed[[*tire.outputs, *tire.states]]


def residual_of(computed: pd.DataFrame, screen: Screen, recording: Recording) -> FloatArray:
    """Return the residual of a tire in every row of a recording, shape (n_channels, n_rows), N and N m.

    `computed`: by the tire (`computed_by`). `screen`: of its solution. Offsets, drift, cross-talk and waves of the
    recording are subtracted. NaN if a channel was not measured.
    """
    channels = list(screen.signals.channels)
    both = (convert_signs(table[channels], recording.signs, FORMULA_SIGNS) for table in (recording.table, computed))
    measured, simulated = (table.to_numpy(dtype=np.float64).T for table in both)
    t = recording.table["t"].to_numpy(np.float64) if "t" in recording.table else np.arange(float(len(recording)))
    radius = screen.problem.simulator.tire.values["UNLOADED_RADIUS"]
    removed = removed_at(screen.problem.disturbances, screen.solution.disturbance, screen.signals, t, measured, radius)
    return np.asarray(measured - simulated - removed)


def error_splits(residual: FloatArray, residuals: DeliveredResiduals, recording: Recording) -> dict[str, ErrorSplit]:
    """Return the noise floor of each channel and the other parts of its error (`tirefmu.numerics.noise_floor`).

    They are those of the compared rows and of the rows between them, outside the hold-out set, without outliers: a
    floor must not depend on how many rows are compared. `residual`: of the delivered tire (`residual_of`).
    """
    rows, holdout, channels = residuals.signals.table_rows, residuals.signals.holdout, residuals.signals.channels
    every, begins = int(np.diff(rows).min()), rows[~holdout]
    followed = begins[np.isin(begins + every, rows)]
    fitted = np.unique(np.concatenate([begins, *(followed + offset for offset in range(1, every))]))
    rest = {}
    for name, row, used in zip(channels, residual, residuals.used, strict=True):
        scatter = short_range(np.nan_to_num(row[fitted]), np.isfinite(row[fitted]))[1]
        rest[name] = np.full(len(row), np.nan)
        rest[name][fitted[scatter]] = row[fitted[scatter]]
        rest[name][rows[~used]] = np.nan
    return error_split(recording.table, rest, recording.segment_numbers())


def fit_errors(
    before: Screen, after: Screen, residuals: DeliveredResiduals, splits: Mapping[str, ErrorSplit]
) -> FitErrors:
    """Return root mean square residuals of the delivered tires, with all errors of the recording removed.

    `before`, `after`: of the solutions of the baseline model and the improved model. `residuals`: of both delivered
    tires. `splits`: of the delivered tire. Returns: train, cv, holdout -> channel -> before, after, floor.
    """
    both, used, holdout = (residuals.before, residuals.after), residuals.used, residuals.signals.holdout
    validated = [residual + screen.change_without_block for residual, screen in zip(both, (before, after), strict=True)]
    parts = {
        "train": (both, used & ~holdout),
        "cv": (validated, (after.problem.inverse_noise > 0.0) & used),
        "holdout": (both, used & holdout),
    }
    return {
        part: {
            name: {"before": _rms(rows[0][i], mask[i]), "after": _rms(rows[1][i], mask[i]), "floor": splits[name].floor}
            for i, name in enumerate(after.signals.channels)
        }
        for part, (rows, mask) in parts.items()
    }


def _rms(residual: FloatArray, present: BoolArray) -> float:
    return float(np.sqrt(np.mean(residual[present] ** 2))) if present.any() else float("nan")


def reasons_against(residuals: DeliveredResiduals) -> tuple[str, ...]:
    """Return the reason why an improved tire is not delivered, or nothing."""
    gain = density_gain(residuals)
    if gain.sum() >= 0.0:  # NaN is a reason
        return ()
    worst = int(np.argmin(graded(gain)))  # of NaN, the first one
    held, name = residuals.used[worst] & residuals.signals.holdout, residuals.signals.channels[worst]
    before, after = (_rms(rows[worst], held) for rows in (residuals.before, residuals.after))
    return (
        f"it predicts the hold-out set worse than the baseline tire ({name}: {after:.3g} instead of {before:.3g} "
        f"{drawn_unit(name)})",
    )


def density_gain(residuals: DeliveredResiduals) -> FloatArray:
    """Return the increase of the logarithm of the predictive density of the hold-out set, shape (n_channels,)."""
    used, holdout = residuals.used, residuals.signals.holdout
    return np.asarray(density_gains(residuals.before, residuals.after, used & ~holdout, used & holdout).sum(axis=1))
