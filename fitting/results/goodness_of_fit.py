"""Goodness of fit of a tire by recording and channel, over fitted rows and over all rows."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import numpy.typing as npt
import pandas as pd

from tirefmu.estimation.noise_floor import NoiseFloor, noise_floor
from tirefmu.tires.code import fastest_code
from tirefmu.tires.tire import Tire

from ..data.fit_data import FitData
from ..problem.rows import BLOCK, Rows
from .records import ChannelFit, Moments

FloatArray = npt.NDArray[np.float64]


def channel_fits(
    data: FitData, tire: Tire, sources: Sequence[str], fitted: Sequence[str], effective: FloatArray
) -> tuple[ChannelFit, ...]:
    """Return the goodness of fit of each measured channel of each recording.

    `tire`: in the signs of the data. `sources`: name of each recording. `fitted`: the channels that were fitted.
    `effective`, shape (n_recordings, n_outputs): effective sample size.
    """
    units = {quantity.name: quantity.unit for quantity in tire.symbolic_model.outputs}
    found = []
    for number, name in enumerate(sources):
        table = data.table if len(sources) == 1 else data.table[data.table["recording"] == number]
        every, included, floors = _compared(table, tire, fitted)
        for index, channel in enumerate(tire.outputs):
            n, rmse, r2, uncentred = every[index].quality
            if n:
                floor, effective_rows = floors[channel].floor, float(effective[number, index])
                own = included[index].quality[:3]
                found.append(
                    ChannelFit(name, channel, units[channel], n, rmse, r2, uncentred, floor, effective_rows, *own)
                )
    return tuple(found)


def _compared(
    table: pd.DataFrame, tire: Tire, fitted: Sequence[str]
) -> tuple[list[Moments], list[Moments], dict[str, NoiseFloor]]:
    """Return the sums of each output over all rows and over the included ones, and noise floors of fitted channels."""
    every = [Moments() for _ in tire.outputs]
    included = list(every)
    residuals = {channel: np.empty(len(table)) for channel in fitted}
    for start in range(0, len(table), BLOCK):
        part = table.iloc[start : start + BLOCK]
        rows, own = Rows.of(part, tire, fitted), part["included"].to_numpy()
        computed = fastest_code(tire.symbolic_model).forces(rows.inputs, tire.parameters())
        for index, (channel, measured) in enumerate(zip(tire.outputs, rows.measured.T, strict=True)):
            every[index] += Moments.of(measured, computed[index])
            included[index] += Moments.of(measured[own], computed[index][own])
            if channel in residuals:
                residuals[channel][start : start + BLOCK] = measured - computed[index]
    return every, included, noise_floor(table, residuals, with_history=False)
