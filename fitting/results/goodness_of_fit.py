"""Goodness of fit of a tire by recording and channel, over fitted rows and over all rows."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import numpy.typing as npt

from tirefmu.estimation.noise_floor import noise_floor
from tirefmu.tires.code import fastest_code
from tirefmu.tires.tire import Tire

from ..data.fit_data import FitData
from ..problem.weighted_residuals import Rows
from .records import ChannelFit, quality

FloatArray = npt.NDArray[np.float64]


def channel_fits(
    data: FitData, tire: Tire, sources: Sequence[str], fitted: Sequence[str], effective: FloatArray
) -> tuple[ChannelFit, ...]:
    """Return the goodness of fit of each measured channel of each recording.

    Parameters
    ----------
    data : FitData
    tire : Tire
        In the signs of the data.
    sources : sequence of str
        Name of each recording.
    fitted : sequence of str
        The channels that were fitted.
    effective : ndarray, shape (n_recordings, n_outputs)
        Effective sample size.
    """
    units = {quantity.name: quantity.unit for quantity in tire.book.outputs}
    found = []
    for number, name in enumerate(sources):
        table = data.table[data.table["recording"] == number]
        rows = Rows.of(table, tire, fitted)
        computed = fastest_code(tire.book).forces(rows.inputs, tire.parameters())
        floors = noise_floor(
            table, dict(zip(tire.outputs, rows.measured.T - computed, strict=True)), with_history=False
        )
        included = table["included"].to_numpy()
        for index, channel in enumerate(tire.outputs):
            measured = rows.measured[:, index]
            n, rmse, r2, uncentred = quality(measured, computed[index])
            if n:
                floor, effective_rows = floors[channel].floor, float(effective[number, index])
                own = quality(measured[included], computed[index][included])[:3]
                found.append(
                    ChannelFit(name, channel, units[channel], n, rmse, r2, uncentred, floor, effective_rows, *own)
                )
    return tuple(found)
