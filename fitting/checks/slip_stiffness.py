"""Slip stiffness of the fitted tire compared with the slope of the data at zero slip."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field, replace
from math import nan

import numpy as np

from ...numerics.arrays import FloatArray, IntArray
from ...numerics.slip_slope import SLOPE_WINDOW, Slope, read_slope
from ..problem.rows import Rows
from ..problem.slope_targets import SlopeTarget
from .residuals import Residuals

#: The force of each slip.
FORCES = {"kappa": "Fx", "alpha": "Fy"}
#: Standard errors that a slope has to exceed: 20 %, twice as much as the errors of interest. Judgement.
MIN_SIGNIFICANT = 5.0
#: Relative deviation of the slope of a formula from that of a tire: no Magic Formula follows the slip stiffness of a
#: measured tire over five loads within 3 %. Judgement.
MODEL_ERROR = 0.05


class Compared:
    """A number read from the data, with its standard error, and from the tire."""

    read: float
    fitted: float
    error: float

    @property
    def off(self) -> float:
        """Relative error of the tire."""
        return self.fitted / self.read - 1.0

    @property
    def reliable_error(self) -> float:
        """Relative error of the tire beyond two standard errors of the data; 0 within them."""
        noise = 2.0 * self.error / self.read if np.isfinite(self.error) else 0.0
        return float(np.sign(self.off)) * max(abs(self.off) - noise, 0.0)


@dataclass(frozen=True)
class SlipStiffness(Compared):
    """The slope of a force at zero slip in one operating condition.

    - `load`: N; `at`: levels of the operating condition.
    - `read`, `fitted`: magnitude of the slope of the measured rows, and of the tire at the same rows, read in the same
      way.
    - `error`: standard error of the slope of the measured rows.
    """

    recording: str
    channel: str
    slip: str
    unit: str
    load: float
    read: float
    fitted: float
    error: float = nan
    at: dict[str, float] = field(default_factory=dict)


@dataclass(frozen=True, eq=False)
class ReadStiffness:
    """The slope of a force at zero slip, read from measured rows and averaged over operating conditions at one load.

    - `recording`: number of the recording.
    - `load`: N.
    - `value`, `error`: of the slope, signed, and its standard error.
    - `rows`, shape (m,): the rows of the table from which it was read.
    - `influence`, shape (m,): derivative of the slope by the force of these rows.
    """

    recording: int
    channel: str
    slip: str
    load: float
    value: float
    error: float
    rows: IntArray
    influence: FloatArray


def read_stiffnesses(
    residuals: Residuals, slopes: Sequence[tuple[str, str]] = tuple(FORCES.items())
) -> tuple[ReadStiffness, ...]:
    """Read slip stiffnesses from the measured rows in each operating condition, and average them by load.

    `slopes`: the slip and the channel of each slope. The result is by recording, channel and load; empty without a
    sweep through zero slip at zero other slip.
    """
    loads = np.array(residuals.levels.get("Fz", ()))
    stiffnesses = []
    for number in range(len(residuals.sources)):
        for slip, channel in slopes:
            if channel not in residuals.channels or slip not in residuals.table:
                continue
            by_level: dict[int, list[tuple[float, Slope]]] = {}
            for load, slope, _ in _slopes(residuals, number, slip, channel):
                level = int(np.abs(load - loads).argmin()) if loads.size else 0
                by_level.setdefault(level, []).append((load, slope))
            for level in sorted(by_level):
                slopes_of_level = [slope for _, slope in by_level[level]]
                count = len(slopes_of_level)
                stiffnesses.append(
                    ReadStiffness(
                        number, channel, slip,
                        float(np.mean([abs(load) for load, _ in by_level[level]])),
                        float(np.mean([slope.value for slope in slopes_of_level])),
                        float(np.sqrt(np.sum([slope.error**2 for slope in slopes_of_level]))) / count,
                        np.concatenate([slope.rows for slope in slopes_of_level]),
                        np.concatenate([slope.influence for slope in slopes_of_level]) / count,
                    )
                )  # fmt: skip
    return tuple(stiffnesses)


def slip_stiffnesses(residuals: Residuals) -> tuple[SlipStiffness, ...]:
    """Return slip stiffnesses read from the data, and the same combination of the tire's forces at the same rows.

    The result is by recording, channel and operating condition; empty without a sweep through zero slip at zero other
    slip.
    """
    return tuple(
        SlipStiffness(
            source, channel, slip, "N/rad" if slip == "alpha" else "N", abs(load), abs(slope.value),
            abs(float(slope.influence @ residuals.computed[channel][slope.rows])), slope.error, residuals.at(condition),
        )
        for number, source in enumerate(residuals.sources)
        for slip, channel in FORCES.items()
        if channel in residuals.channels and slip in residuals.table
        for load, slope, condition in _slopes(residuals, number, slip, channel)
    )  # fmt: skip


def slope_targets(residuals: Residuals) -> tuple[SlopeTarget, ...]:
    """Return the slip stiffnesses that are read from the data as residuals of a fit."""
    tire, table = residuals.tire, residuals.table
    return tuple(
        SlopeTarget(
            read.recording, tire.outputs.index(read.channel),
            np.ascontiguousarray(tire.effective_inputs(Rows.of(table.iloc[read.rows], tire, ()).inputs)),
            read.influence, table[read.channel].to_numpy(dtype=float)[read.rows],
            table.index.to_numpy()[read.rows], read.value, read.error,
            float(np.hypot(read.error, MODEL_ERROR * read.value)),
        )
        for read in read_stiffnesses(residuals)
    )  # fmt: skip


def _slopes(residuals: Residuals, number: int, slip: str, channel: str) -> Iterator[tuple[float, Slope, int]]:
    """Yield load, slope in rows of the table, and number of each operating condition with rows near zero slip.

    A slope within `MIN_SIGNIFICANT` of its standard errors is not one.
    """
    table = residuals.table
    measured = table[channel].to_numpy(dtype=float)
    other = "kappa" if slip == "alpha" else "alpha"
    near = (residuals.recording == number) & np.isfinite(measured)
    x = table[slip].to_numpy(dtype=float)
    near &= np.abs(x) < SLOPE_WINDOW[slip]
    if other in table:
        near &= np.abs(table[other].to_numpy(dtype=float)) < 0.25 * SLOPE_WINDOW[other]
    for condition in np.unique(residuals.condition[near]):
        rows = np.flatnonzero(near & (residuals.condition == condition))
        slope = read_slope(x[rows], measured[rows], SLOPE_WINDOW[slip])
        if abs(slope.value) > MIN_SIGNIFICANT * slope.error:
            load = float(table["Fz"].to_numpy()[rows].mean())
            yield load, replace(slope, rows=rows[slope.rows]), int(condition)
