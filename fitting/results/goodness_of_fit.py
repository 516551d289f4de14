"""Goodness of fit of a tire by recording and channel, over fitted rows and over all rows."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import pandas as pd

from ...numerics.arrays import FloatArray
from ...numerics.noise_floor import ErrorSplit, error_split
from ...tires.code import fastest_code
from ...tires.tire import Tire
from ..checks.residuals import Residuals
from ..data.fit_data import FitData
from ..problem.rows import BLOCK, Rows
from .records import ChannelFit, Moments


def channel_fits(data: FitData, residuals: Residuals, effective: FloatArray) -> tuple[ChannelFit, ...]:
    """Return the goodness of fit of each measured channel of each recording.

    `residuals`: of the fitted rows. `effective`, shape (n_recordings, n_outputs): effective sample size.
    """
    tire, sources = residuals.tire, residuals.sources
    units = {quantity.name: quantity.unit for quantity in tire.symbolic_model.outputs}
    channels = []
    for number, name in enumerate(sources):
        table = data.table if len(sources) == 1 else data.table[data.table["recording"] == number]
        every, included = _compared(table, tire, residuals.channels)
        splits = _splits(residuals, number)
        for index, channel in enumerate(tire.outputs):
            n, rmse, r2, uncentred = every[index].quality
            if n:
                split = splits.get(channel, ErrorSplit())
                quality = included[index].quality[:3]
                channels.append(
                    ChannelFit(
                        name, channel, units[channel], n, rmse, r2, uncentred, split.floor,
                        float(effective[number, index]), *quality, split.inputs, split.time, split.repeats,
                    )
                )  # fmt: skip
    return tuple(channels)


def _splits(residuals: Residuals, number: int) -> dict[str, ErrorSplit]:
    """Return the parts of the error of each channel of a recording over the fitted rows."""
    members = residuals.recording == number
    measured = {name: values[members] for name, values in residuals.measured_minus_computed.items()}
    present = {name: values for name, values in measured.items() if np.isfinite(values).any()}
    if not present:
        return {}
    return error_split(residuals.table[members], present, residuals.segment[members], residuals.cell[members])


def _compared(table: pd.DataFrame, tire: Tire, fitted: Sequence[str]) -> tuple[list[Moments], list[Moments]]:
    """Return the sums of each output over all rows and over the included ones."""
    every = [Moments() for _ in tire.outputs]
    included = list(every)
    for start in range(0, len(table), BLOCK):
        part = table.iloc[start : start + BLOCK]
        rows, fitted_rows = Rows.of(part, tire, fitted), part["included"].to_numpy()
        computed = fastest_code(tire.symbolic_model).forces(rows.inputs, tire.parameters())
        for index, measured in enumerate(rows.measured.T):
            every[index] += Moments.of(measured, computed[index])
            included[index] += Moments.of(measured[fitted_rows], computed[index][fitted_rows])
    return every, included
