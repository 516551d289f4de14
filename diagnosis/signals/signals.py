"""Preprocessed recording: sign convention of the formula, smoothed inputs, time blocks.

The windows of smoothing are selected from the data (`tirefmu.numerics.smoothing`). Every eighth block is the hold-out
set, which no fit uses; confirmation, formulas and delivery are checked on it. Fx is excluded if kappa is always 0.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np
import pandas as pd
from scipy.interpolate import PchipInterpolator

from ...boundary.errors import DataError
from ...numerics.arrays import BoolArray, FloatArray, IntArray
from ...numerics.smoothing import smoothed
from ...symbolic.channels import OUTPUTS
from ...tires.signs import convert_signs
from ...tires.states.transient import rolled_distance
from ...tires.tire import Tire
from ..thresholds import (
    BLOCK_LENGTH,
    MAX_BLOCKS,
    MAX_ROWS,
    MIN_ROWS_OF_BLOCK,
    MIN_VARIATION,
)

#: Every n-th block is in the hold-out set, which no fit uses. Convention.
HOLDOUT_EVERY = 8
#: Minimum number of rows under load. Derived from `MIN_BLOCKS`: a block then has about 16 rows.
MIN_ROWS = 200
#: In time steps: a longer step is a gap in time, which separates segments of smoothing. Convention, as of a recording
#: (`Recording.segments`).
TIME_GAP = 5.0
#: Least number of blocks. A jackknife covariance of k responses requires more than k + 1 blocks. Convention.
MIN_BLOCKS = 12
#: Minimum number of blocks with measured outputs; with fewer, their scatter has too few degrees of freedom. Convention.
MIN_MEASURED_BLOCKS = 8

#: The sign convention of the computation: that of the coefficients' bounds and initial values.
FORMULA_SIGNS = "adapted-sae"


@dataclass(frozen=True)
class InputOrigin:
    """Where the inputs of signals come from.

    - `recorded`: inputs that the recording contains; the others have their nominal values.
    - `derived`: inputs that were computed from recorded ones.
    - `noise`: standard deviation of the noise that smoothing removed.
    """

    recorded: frozenset[str]
    derived: frozenset[str]
    noise: Mapping[str, float]


@dataclass(frozen=True, eq=False)
class Signals:
    """The signals of a recording that the diagnosis uses.

    - `names`: names of the inputs.
    - `t`, shape (m,), s: time of the rows over which transient slip is integrated: all rows, or every n-th of long
      recordings.
    - `inputs`, shape (n_inputs, m): smoothed, in the order of the tire's inputs, adapted SAE.
    - `rows`, shape (n,): rows of `t` and `inputs` at which forces are compared.
    - `table_rows`, shape (n,): the same rows, counted in the recording.
    - `channels`: measured outputs.
    - `measured`, shape (n_channels, n): adapted SAE.
    - `present`, shape (n_channels, n): false if a channel was not measured or is an outlier.
    - `block`, shape (n,).
    - `holdout`, shape (n,): rows of the hold-out set, which no fit uses; effects, formulas and the delivered tire are
      checked on them.
    - `origin`: of the inputs.
    - `timed`: whether the recording has a column t.
    - `excluded_channels`: measured channels that are not compared, and the reason.
    - `skew`, s: time by which the inputs were delayed, because the forces are recorded later.
    """

    names: tuple[str, ...]
    t: FloatArray
    inputs: FloatArray
    rows: IntArray
    table_rows: IntArray
    channels: tuple[str, ...]
    measured: FloatArray
    present: BoolArray
    block: IntArray
    holdout: BoolArray
    origin: InputOrigin
    timed: bool
    excluded_channels: Mapping[str, str] = field(default_factory=dict)
    skew: float = 0.0

    @cached_property
    def everywhere(self) -> Signals:
        """The signals with forces at all rows of `t`, for what is simulated: no force was measured between them."""
        return replace(self, rows=np.arange(len(self.t)))

    def delayed(self, seconds: float) -> Signals:
        """Return the signals with inputs that are delayed by a further time, s."""
        steps = np.diff(self.t, prepend=self.t[0])
        parts = np.split(np.arange(len(self.t)), np.flatnonzero(steps < 0.0))
        inputs = np.concatenate([_delayed(self.t[part], self.inputs[:, part], seconds) for part in parts], axis=1)
        return replace(self, inputs=inputs, skew=self.skew + seconds)

    def with_inputs_of(self, tire: Tire) -> Signals:
        """Return the signals with the inputs of a tire, in their order; those without signals are at nominal values."""
        by_name = dict(zip(self.names, self.inputs, strict=True))
        rows = [by_name[name] if name in by_name else np.full(len(self.t), tire.nominal(name)) for name in tire.inputs]
        return replace(self, names=tire.inputs, inputs=np.stack(rows))

    def named(self) -> dict[str, FloatArray]:
        """Return the inputs at the compared rows by name."""
        return dict(zip(self.names, self._compared, strict=True))

    @cached_property
    def _compared(self) -> FloatArray:
        """The inputs at the compared rows, shape (n_inputs, n)."""
        compared = self.inputs[:, self.rows]
        compared.flags.writeable = False  # shared by all callers
        return compared


def _delayed(t: FloatArray, rows: FloatArray, seconds: float) -> FloatArray:
    """Return inputs, shape (n_inputs, n), that are delayed; between rows they are monotonic cubic polynomials.

    A linear interpolation would cut off the ends of sweeps that a slow recording has few rows of.
    """
    advancing = np.concatenate([[True], np.diff(t) > 0.0])
    if advancing.sum() < 2:
        return rows
    at = np.clip(t - seconds, t[0], t[-1])
    with np.errstate(over="ignore"):  # it divides by slopes, of which a held input has very small ones
        return np.asarray(PchipInterpolator(t[advancing], rows[:, advancing], axis=1)(at))


def signals_of(
    table: pd.DataFrame, tire: Tire, signs: str, *, smooth: bool = True, derived: Collection[str] = ()
) -> Signals:
    """Preprocess a table.

    `table`: a recording in SI units. `tire`: determines the inputs and their nominal values. `signs`: sign convention
    of the table. `smooth`: whether noise is removed from the inputs. Raises `DataError` if there are too few rows or
    time blocks, no measured output or no load, or if an input is not finite.
    """
    if len(table) < MIN_ROWS:
        raise DataError(f"the recording has {len(table)} rows: a diagnosis needs at least {MIN_ROWS}")
    if "Fz" not in table:
        raise DataError("the recording has no column 'Fz': a diagnosis needs the load")
    given = convert_signs(table, signs, FORMULA_SIGNS)
    timed = "t" in given
    t = _finite(given, "t") if timed else np.arange(len(given), dtype=np.float64)
    columns, noise, names, outputs = {}, {}, tire.inputs, tire.outputs
    smoothed = {}  # determines channels and rows, so that they are the same with and without smoothing
    for name in names:
        columns[name] = _finite(given, name) if name in given else np.full(len(given), tire.nominal(name))
        smoothed[name] = columns[name]
        if timed and name in given and name != "distance":
            smoothed[name], deviation = _smoothed_by_segment(columns[name], t)
            if smooth:
                columns[name], noise[name] = smoothed[name], deviation
    speed = columns["V"] if "V" in columns else given.get("V")  # a model or a table may lack the speed
    if "distance" not in given and "distance" in columns and timed and speed is not None:
        columns["distance"] = rolled_distance(t, np.asarray(speed, dtype=float))
    inputs = np.stack([columns[name] for name in names])
    channels = tuple(name for name in OUTPUTS if name in given and name in outputs and given[name].notna().any())
    excluded = {}
    if len(channels) > 1 and "Fx" in channels and np.ptp(smoothed["kappa"]) < MIN_VARIATION["kappa"]:
        excluded["Fx"] = "kappa is always 0, so the channel contains no slip curve"
        channels = tuple(name for name in channels if name != "Fx")
    if not channels:
        raise DataError(f"the recording has no measured output: one of {', '.join(outputs)} is needed")
    loaded = np.flatnonzero(smoothed["Fz"] > MIN_VARIATION["Fz"] * tire.values["FNOMIN"])
    rows = loaded[:: max(1, -(-len(loaded) // MAX_ROWS))]
    if len(rows) < MIN_ROWS:
        raise DataError(f"the recording has {len(rows)} rows under load: a diagnosis needs at least {MIN_ROWS}")
    measured = np.stack([given[name].to_numpy(dtype=np.float64)[rows] for name in channels])
    block = _blocks(t[rows])
    recorded = frozenset(name for name in names if name in given) - set(derived) | ({"distance"} if timed else set())
    holdout = block % HOLDOUT_EVERY == HOLDOUT_EVERY // 2 + 1
    present = np.isfinite(measured)
    measured_blocks = len(np.unique(block[present.any(axis=0) & ~holdout]))
    if measured_blocks < MIN_MEASURED_BLOCKS:
        raise DataError(
            f"{', '.join(channels)}: measured in {measured_blocks} of {block[-1] + 1} equal parts of the recording: "
            f"a diagnosis needs at least {MIN_MEASURED_BLOCKS}"
        )
    measured = np.where(present, measured, 0.0)
    thin = np.arange(0, len(t), max(1, len(t) // (2 * MAX_ROWS)))
    simulated = np.union1d(thin, rows)
    return Signals(
        names, t[simulated], inputs[:, simulated], np.searchsorted(simulated, rows), rows, channels,
        measured, present, block, holdout,
        InputOrigin(recorded, frozenset(derived), noise), timed, excluded,
    )  # fmt: skip


def _finite(table: pd.DataFrame, name: str) -> FloatArray:
    """Return the values of a column, all of which must be finite."""
    values = table[name].to_numpy(dtype=np.float64)
    if not np.isfinite(values).all():
        raise DataError(f"row {int(np.flatnonzero(~np.isfinite(values))[0]) + 1}: {name} is not a finite number")
    return values


def _smoothed_by_segment(values: FloatArray, t: FloatArray) -> tuple[FloatArray, float]:
    """Return values smoothed within segments without a gap in time, and the standard deviation of their noise."""
    steps = np.diff(t)
    gaps = np.flatnonzero((steps <= 0.0) | (steps > TIME_GAP * np.median(steps[steps > 0.0]))) + 1
    parts = [smoothed(part) for part in np.split(values, gaps)]
    weights = [len(part) for part, _ in parts]
    noise = float(np.average([deviation for _, deviation in parts], weights=weights))
    return np.concatenate([part for part, _ in parts]), noise


def _blocks(t: FloatArray) -> IntArray:
    """Return the index of each row's time block; gaps in time are not counted. Few rows have fewer blocks."""
    steps = np.diff(t, prepend=t[0])
    typical = float(np.median(steps[1:]))
    run = np.cumsum(np.where((steps > 0.0) & (steps < TIME_GAP * typical), steps, typical))
    of_rows = min(MAX_BLOCKS, max(MIN_BLOCKS, len(t) // MIN_ROWS_OF_BLOCK))
    number = int(np.clip(round((run[-1] - run[0]) / BLOCK_LENGTH), MIN_BLOCKS, of_rows))
    return np.asarray(np.minimum((number * (run - run[0]) / (run[-1] - run[0])).astype(np.int64), number - 1))
