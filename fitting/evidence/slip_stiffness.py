"""Slip stiffness of the fitted tire compared with the slope of the data at zero slip."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from .curves import SLOPE_WINDOW, slope_at_zero
from .residuals import Residuals

#: The force of each slip.
FORCES = {"kappa": "Fx", "alpha": "Fy"}


@dataclass(frozen=True)
class SlipStiffness:
    """The slope of a force at zero slip, at one load.

    Attributes
    ----------
    recording, channel, slip, unit : str
    load : float
        N.
    read, fitted : float
        Magnitude of the slope of the measured rows, and of the tire at the same rows, read in the same way and averaged
        over the operating conditions at that load.
    conditions : int
        Number of these operating conditions.
    """

    recording: str
    channel: str
    slip: str
    unit: str
    load: float
    read: float
    fitted: float
    conditions: int

    @property
    def off(self) -> float:
        """Relative error of the tire."""
        return self.fitted / self.read - 1.0


def slip_stiffnesses(residuals: Residuals) -> tuple[SlipStiffness, ...]:
    """Read slip stiffnesses from the data in each operating condition, and from the tire at the same rows.

    Parameters
    ----------
    residuals : Residuals

    Returns
    -------
    tuple of SlipStiffness
        By recording, channel and load; empty without a sweep through zero slip at zero other slip.
    """
    loads = np.array(residuals.levels.get("Fz", ()))
    records = []
    for number, source in enumerate(residuals.sources):
        for slip, channel in FORCES.items():
            if channel not in residuals.channels or slip not in residuals.table:
                continue
            slopes = _slopes(residuals, number, slip, channel)
            if not slopes:
                continue
            load, read, fitted = np.array(slopes).T
            level = np.abs(load[:, None] - loads).argmin(axis=1) if loads.size else np.zeros(len(load), dtype=int)
            for each in np.unique(level):
                selected = level == each
                at, data, tire = (float(np.abs(values[selected]).mean()) for values in (load, read, fitted))
                unit = "N/rad" if slip == "alpha" else "N"
                records.append(SlipStiffness(source, channel, slip, unit, at, data, tire, int(selected.sum())))
    return tuple(records)


def _slopes(residuals: Residuals, number: int, slip: str, channel: str) -> list[tuple[float, float, float]]:
    """Return load, measured slope and fitted slope of each operating condition with a sweep through zero slip."""
    table = residuals.table
    measured = table[channel].to_numpy(dtype=float)
    other = "kappa" if slip == "alpha" else "alpha"
    near = (residuals.recording == number) & np.isfinite(measured)
    x = table[slip].to_numpy(dtype=float)
    near &= np.abs(x) < SLOPE_WINDOW[slip]
    if other in table:
        near &= np.abs(table[other].to_numpy(dtype=float)) < 0.25 * SLOPE_WINDOW[other]
    found = []
    for condition in np.unique(residuals.condition[near]):
        rows = near & (residuals.condition == condition)
        read = slope_at_zero(x[rows], measured[rows], SLOPE_WINDOW[slip])
        fitted = slope_at_zero(x[rows], residuals.computed[channel][rows], SLOPE_WINDOW[slip])
        if np.isfinite(read) and np.isfinite(fitted) and read != 0:
            found.append((float(table["Fz"].to_numpy()[rows].mean()), read, fitted))
    return found
