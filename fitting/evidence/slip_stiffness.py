"""Slip stiffness of the fitted tire compared with the slope of the data at zero slip."""

from __future__ import annotations

from dataclasses import dataclass
from math import nan

import numpy as np

from .residuals import Residuals
from .slope import SLOPE_WINDOW, read_slope

#: The force of each slip.
FORCES = {"kappa": "Fx", "alpha": "Fy"}
#: Standard errors that a slope has to exceed: 20 %, twice as much as the errors of interest. Judgement.
LEAST_SIGNIFICANT = 5.0


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
    error : float
        Standard error of the slope of the measured rows.
    """

    recording: str
    channel: str
    slip: str
    unit: str
    load: float
    read: float
    fitted: float
    conditions: int
    error: float = nan

    @property
    def off(self) -> float:
        """Relative error of the tire."""
        return self.fitted / self.read - 1.0

    @property
    def reliable_error(self) -> float:
        """Relative error of the tire beyond two standard errors of the data; 0 within them."""
        noise = 2.0 * self.error / self.read if np.isfinite(self.error) else 0.0
        return float(np.sign(self.off)) * max(abs(self.off) - noise, 0.0)


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
            load, read, fitted, errors = np.array(slopes).T
            level = np.abs(load[:, None] - loads).argmin(axis=1) if loads.size else np.zeros(len(load), dtype=int)
            for each in np.unique(level):
                selected = level == each
                at, data, tire = (float(np.abs(values[selected]).mean()) for values in (load, read, fitted))
                unit = "N/rad" if slip == "alpha" else "N"
                count = int(selected.sum())
                error = float(np.sqrt(np.sum(errors[selected] ** 2))) / count
                records.append(SlipStiffness(source, channel, slip, unit, at, data, tire, count, error))
    return tuple(records)


def _slopes(residuals: Residuals, number: int, slip: str, channel: str) -> list[tuple[float, float, float, float]]:
    """Return load, measured and fitted slope and standard error of each operating condition with rows near zero slip.

    A slope within `LEAST_SIGNIFICANT` of its standard errors is not one.
    """
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
        read = read_slope(x[rows], measured[rows], SLOPE_WINDOW[slip])
        fitted = read_slope(x[rows], residuals.computed[channel][rows], SLOPE_WINDOW[slip]).value
        if abs(read.value) > LEAST_SIGNIFICANT * read.error:
            found.append((float(table["Fz"].to_numpy()[rows].mean()), read.value, fitted, read.error))
    return found
