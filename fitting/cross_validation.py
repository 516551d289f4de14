"""Blocked cross-validation: prediction error of a fitted tire at operating conditions that were not fitted.

Neighboring rows of a sweep are almost equal, so a random hold-out set of rows is no test. The hold-out sets contain
whole operating conditions: a load at an inclination and a pressure, with its up and down sweeps and its repeats.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from ..boundary.errors import FitError
from ..boundary.named_options import named
from ..measurements import Recording, TableLike, group_by_condition, recordings_from
from ..measurements.nominal_values import NOMINAL
from ..measurements.operating_conditions.levels import MAX_LEVELS
from ..numerics.arrays import FloatArray, IntArray
from ..tires.code import fastest_code
from ..tires.tire import Tire
from .fit import fit
from .fit_result import FitResult
from .problem.rows import Rows
from .results.records import HeldOut
from .temperature.temperature_fit import settings_of_forces


@dataclass(frozen=True)
class FoldTask:
    """The fit of the data without one fold: what any process needs to compute it."""

    recordings: tuple[Recording, ...]
    model: str
    options: Mapping[str, Any]


def tire_of_fold(task: FoldTask) -> Tire:
    """Return the tire that is fitted without a fold."""
    return fit(task.recordings, task.model, **task.options).tire


@named(fit)
def cross_validate(
    tables: TableLike | Iterable[TableLike],
    model: str | None = None,
    *,
    folds: int = 4,
    seed: int = 0,
    whole: FitResult | None = None,
    compute: Callable[[Callable[[FoldTask], Tire], Sequence[FoldTask]], Iterable[Tire]] = map,
    **options: Any,
) -> tuple[HeldOut, ...]:
    """Fit all data, then the data without each fold of operating conditions, and compare the errors.

    Parameters
    ----------
    tables : path, DataFrame or Recording, or a sequence of them
        The data of the fit.
    model : str, optional
        As for `tirefmu.fitting.fit`.
    folds : int
        Number of parts into which the operating conditions of each recording are divided at random.
    seed : int
        Of the random assignment of operating conditions to folds.
    whole : FitResult, optional
        The fit of all data, if it exists already.
    compute : callable
        Returns the tire of each task, in their order. Default: one after another, in this process
        (`tirefmu.applications.batch.intervals` distributes them).
    **options
        Options of `tirefmu.fitting.fit`.

    Returns
    -------
    tuple of HeldOut
        The errors of each recording and channel, predicted out of sample.

    Raises
    ------
    FitError
        If there are fewer than two folds, or fewer operating conditions than folds in every recording.
    """
    recordings = recordings_from(tables, signs=options.pop("signs", None))
    options = settings_of_forces(options)
    parts = assign_folds(recordings, folds, seed)
    whole = fit(recordings, model, **options) if whole is None else whole
    model = whole.tire.model
    # The coefficients refer to the nominal values, so all fits use those of the fit of all data.
    nominal = {name: whole.tire.values[key] for name, key in NOMINAL.items() if key in whole.tire.values}
    options = {**options, "nominal": nominal}
    tasks = [FoldTask(_training(recordings, parts, fold), model, options) for fold in range(folds)]
    predicted = [np.full((len(recording), len(whole.tire.outputs)), np.nan) for recording in recordings]
    for fold, tire in enumerate(compute(tire_of_fold, tasks)):
        for computed, recording, part in zip(predicted, recordings, parts, strict=True):
            held_out = part == fold
            if held_out.any():
                computed[held_out] = _computed(tire, replace(recording, table=recording.table[held_out]))
    return tuple(
        HeldOut(c.recording, c.channel, c.unit, c.rows, c.rmse, error)
        for c, error in zip(whole.channels, _errors(whole.channels, recordings, predicted, whole.tire), strict=True)
    )


def assign_folds(tables: TableLike | Iterable[TableLike], folds: int, seed: int = 0) -> list[IntArray]:
    """Return the fold of each row of each recording.

    Parameters
    ----------
    tables : path, DataFrame or Recording, or a sequence of them
        The data of the fit.
    folds, seed : int
        Number of folds, and the seed of the random assignment.

    Returns
    -------
    list of ndarray of int, each of shape (n,)
        For each recording the fold of each row, counted from 0.

    Raises
    ------
    FitError
        If there are fewer than two folds, or fewer operating conditions than folds in every recording.
    """
    if folds < 2:
        raise FitError(f"{folds} folds: at least two are required")
    parts = [_folds(recording, folds, np.random.default_rng(seed)) for recording in recordings_from(tables)]
    if not any(len(set(part)) == folds for part in parts):
        raise FitError(f"{folds} folds require at least {folds} operating conditions in one recording")
    return parts


def _training(recordings: Sequence[Recording], parts: Sequence[IntArray], fold: int) -> tuple[Recording, ...]:
    return tuple(
        replace(recording, table=recording.table[part != fold])
        for recording, part in zip(recordings, parts, strict=True)
        if (part != fold).any()
    )


def _folds(recording: Recording, folds: int, random: np.random.Generator) -> IntArray:
    """Return the fold of each row: operating conditions in random order, distributed evenly over the folds."""
    conditions = group_by_condition(recording, most_levels=MAX_LEVELS).labels
    indices = random.permutation(int(conditions.max(initial=0)) + 1)
    return np.asarray(indices[conditions] % folds, dtype=np.int64)


def _computed(tire: Tire, recording: Recording) -> FloatArray:
    """Return forces in adapted SAE, shape (n, n_forces)."""
    converted = tire.in_signs("adapted-sae")
    rows = Rows.of(recording.with_signs("adapted-sae").table, converted, ())
    return (
        fastest_code(converted.symbolic_model).forces(converted.effective_inputs(rows.inputs), converted.parameters()).T
    )


def _errors(
    channels: Sequence[Any], recordings: Sequence[Recording], predicted: Sequence[FloatArray], tire: Tire
) -> list[float]:
    """Return the root mean square error of every channel of the fit of all data."""
    names = list(dict.fromkeys(channel.recording for channel in channels))
    indices: Mapping[str, int] = {name: number for number, name in enumerate(names)}
    errors = []
    for channel in channels:
        number = indices[channel.recording]
        table = recordings[number].with_signs("adapted-sae").table
        residual = predicted[number][:, tire.outputs.index(channel.channel)] - table[channel.channel].to_numpy(
            dtype=float
        )
        errors.append(float(np.sqrt(np.nanmean(residual**2))))
    return errors
