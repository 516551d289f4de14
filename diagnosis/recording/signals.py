"""A recording made ready for the diagnosis: in the formula's signs, inputs smoothed, cut into blocks of time."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np
import numpy.typing as npt
import pandas as pd

from tirefmu.estimation.smoothing import smoothed
from tirefmu.measurements.channels import OUTPUTS
from tirefmu.symbolic.errors import DataError
from tirefmu.tires.signs import convert_signs
from tirefmu.tires.tire import Tire
from tirefmu.tires.transient import rolled_distance

from ..thresholds import (
    BLOCK_LENGTH,
    HOLDOUT_EVERY,
    MAX_BLOCKS,
    MAX_ROWS,
    MIN_BLOCKS,
    MIN_KAPPA,
    MIN_LOAD,
    MIN_MEASURED_BLOCKS,
    MIN_ROWS,
    TIME_GAP,
)

FloatArray = npt.NDArray[np.float64]
IntArray = npt.NDArray[np.int64]

#: The convention in which the diagnosis computes: that of the coefficients' bounds and starts.
FORMULA_SIGNS = "adapted-sae"


@dataclass(frozen=True, eq=False)
class Signals:
    """What the diagnosis sees of a recording.

    Attributes
    ----------
    names : tuple of str
        The inputs.
    t : ndarray, shape (m,), s
        Of all rows; relaxation runs over all of them.
    inputs : ndarray, shape (n_inputs, m)
        Smoothed, in the order of the tire's inputs, adapted SAE.
    rows : ndarray of int, shape (n,)
        The rows at which forces are compared.
    channels : tuple of str
        The measured outputs.
    output_index : ndarray of int, shape (n_channels,)
        Where each channel stands among the model's outputs.
    measured : ndarray, shape (n_channels, n)
        Adapted SAE.
    present : ndarray of bool, shape (n_channels, n)
        False where a channel was not measured, or is an outlier.
    block : ndarray of int, shape (n,)
    holdout : ndarray of bool, shape (n,)
        The rows that no decision sees.
    recorded : frozenset of str
        The inputs that the recording has; others are at their nominal values.
    input_noise : mapping of str to float
        Standard deviation that smoothing took out.
    timed : bool
        Whether there is a column t.
    left_aside : mapping of str to str
        Measured channels that are not compared, and why.
    """

    names: tuple[str, ...]
    t: FloatArray
    inputs: FloatArray
    rows: IntArray
    channels: tuple[str, ...]
    output_index: IntArray
    measured: FloatArray
    present: npt.NDArray[np.bool_]
    block: IntArray
    holdout: npt.NDArray[np.bool_]
    recorded: frozenset[str]
    input_noise: Mapping[str, float]
    timed: bool
    excluded_channels: Mapping[str, str] = field(default_factory=dict)

    def named(self) -> dict[str, FloatArray]:
        """Return the inputs at the compared rows by name."""
        return dict(zip(self.names, self.inputs[:, self.rows], strict=True))


def signals_of(table: pd.DataFrame, tire: Tire, signs: str, *, smooth: bool = True) -> Signals:
    """Make a table ready.

    Parameters
    ----------
    table : pandas.DataFrame
        A recording in SI units.
    tire : Tire
        Names the inputs and their nominal values.
    signs : str
        The table's convention.
    smooth : bool
        Take the noise out of the inputs.

    Returns
    -------
    Signals

    Raises
    ------
    DataError
        If there are too few rows or blocks of time, no measured output, no load, or an input is no finite number.
    """
    if len(table) < MIN_ROWS:
        raise DataError(f"the recording has {len(table)} rows: a diagnosis needs {MIN_ROWS} at least")
    if "Fz" not in table:
        raise DataError("the recording has no column 'Fz': without the load nothing can be told apart")
    given = convert_signs(table, signs, FORMULA_SIGNS)
    t, timed = _clock(given)
    columns, noise, names, outputs = {}, {}, tire.inputs, tire.outputs
    for name in names:
        columns[name] = _input(given, name, tire)
        if smooth and timed and name in given and name != "distance":
            columns[name], noise[name] = _smoothed_by_segment(columns[name], t)
    speed = columns["V"] if "V" in columns else given.get("V")  # a model may do without speed, and a table too
    if "distance" not in given and "distance" in columns and timed and speed is not None:
        columns["distance"] = rolled_distance(t, np.asarray(speed, dtype=float))
    inputs = np.stack([columns[name] for name in names])
    channels = tuple(name for name in OUTPUTS if name in given and name in outputs and given[name].notna().any())
    excluded = {}
    if len(channels) > 1 and "Fx" in channels and np.abs(columns["kappa"]).max() < MIN_KAPPA:
        excluded["Fx"] = "kappa stays at 0: the channel shows no slip curve"
        channels = tuple(name for name in channels if name != "Fx")
    if not channels:
        raise DataError(f"the recording has no measured output: one of {', '.join(outputs)} is needed")
    loaded = np.flatnonzero(columns["Fz"] > MIN_LOAD * tire.values["FNOMIN"])
    rows = loaded[:: max(1, -(-len(loaded) // MAX_ROWS))]
    if len(rows) < MIN_ROWS:
        raise DataError(f"the recording has {len(rows)} rows under load: a diagnosis needs {MIN_ROWS} at least")
    measured = np.stack([given[name].to_numpy(dtype=np.float64)[rows] for name in channels])
    block = _blocks(t[rows])
    recorded = frozenset(name for name in names if name in given) | ({"distance"} if timed else set())
    output_index = np.array([outputs.index(name) for name in channels])
    holdout = block % HOLDOUT_EVERY == HOLDOUT_EVERY // 2 + 1
    present = np.isfinite(measured)
    measured_blocks = len(np.unique(block[present.any(axis=0) & ~holdout]))
    if measured_blocks < MIN_MEASURED_BLOCKS:
        raise DataError(
            f"{', '.join(channels)}: measured in {measured_blocks} of {block[-1] + 1} equal parts of the recording: "
            f"a diagnosis needs {MIN_MEASURED_BLOCKS} at least"
        )
    measured = np.where(present, measured, 0.0)
    return Signals(
        names, t, inputs, rows, channels, output_index, measured, present, block, holdout, recorded, noise, timed, excluded
    )  # fmt: skip


def _clock(table: pd.DataFrame) -> tuple[FloatArray, bool]:
    if "t" not in table:
        return np.arange(len(table), dtype=np.float64), False
    t = table["t"].to_numpy(dtype=np.float64)
    if not np.isfinite(t).all():
        raise DataError(f"row {int(np.flatnonzero(~np.isfinite(t))[0]) + 1}: t is no finite number")
    return t, True


def _input(table: pd.DataFrame, name: str, tire: Tire) -> FloatArray:
    if name not in table:
        return np.full(len(table), tire.nominal(name))
    values = table[name].to_numpy(dtype=np.float64)
    if not np.isfinite(values).all():
        raise DataError(f"row {int(np.flatnonzero(~np.isfinite(values))[0]) + 1}: {name} is no finite number")
    return values


def _smoothed_by_segment(values: FloatArray, t: FloatArray) -> tuple[FloatArray, float]:
    """Smooth within stretches without a gap in time."""
    steps = np.diff(t)
    gaps = np.flatnonzero((steps <= 0.0) | (steps > TIME_GAP * np.median(steps[steps > 0.0]))) + 1
    parts = [smoothed(part) for part in np.split(values, gaps)]
    weights = [len(part) for part, _ in parts]
    noise = float(np.average([deviation for _, deviation in parts], weights=weights))
    return np.concatenate([part for part, _ in parts]), noise


def _blocks(t: FloatArray) -> IntArray:
    """Return the number of the block of time of each row; gaps in time do not count."""
    steps = np.diff(t, prepend=t[0])
    typical = float(np.median(steps[1:]))
    run = np.cumsum(np.where((steps > 0.0) & (steps < TIME_GAP * typical), steps, typical))
    number = int(np.clip(round((run[-1] - run[0]) / BLOCK_LENGTH), MIN_BLOCKS, MAX_BLOCKS))
    return np.asarray(np.minimum((number * (run - run[0]) / (run[-1] - run[0])).astype(np.int64), number - 1))
