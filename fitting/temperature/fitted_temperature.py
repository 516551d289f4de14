"""The record of a fit of the heat balance to recorded temperatures."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from .optimum import Optimum


@dataclass(frozen=True)
class FittedTemperature:
    """A fit of the heat balance to recorded temperatures.

    - `rmse`, `holdout_rmse`: K, over all rows, and over the last part of the time predicted from a fit to the rest.
    - `constant_rmse`: K, of the mean recorded temperature over the same last part, for comparison.
    - `correlation`: correlation length of the residual, s.
    - `values`, `intervals`: coefficients, and half their 95 % intervals as a factor (value / factor to value x factor).
    - `determined`: the coefficients that the data determine.
    - `starts`: the estimated start temperatures of each recording, K; time that goes backward begins another one.
    - `delay`: of the sensor, s, with half its 95 % interval.
    - `optimum`: the temperature of the largest friction, of a tire with `temp_friction`.
    """

    column: str
    rmse: float
    holdout_rmse: float
    constant_rmse: float
    correlation: float
    values: Mapping[str, float]
    intervals: Mapping[str, float]
    determined: tuple[str, ...]
    starts: tuple[tuple[float, ...], ...]
    delay: tuple[float, float]
    optimum: Optimum | None = None

    def text(self) -> str:
        """Return the errors and the coefficients that are not determined, in one sentence."""
        sensor = f"; the sensor is late by {self.delay[0]:.2f} +- {self.delay[1]:.2f} s"
        unclear = [name for name in self.values if name not in self.determined]
        rest = f"; not determined: {', '.join(unclear)}" if unclear else ""
        rest += f"; {self.optimum.text()}" if self.optimum else ""
        return (
            f"temperature {self.column}: rms error {self.rmse:.2f} K, {self.holdout_rmse:.2f} K on the hold-out set "
            f"(a constant: {self.constant_rmse:.2f} K){sensor}{rest}"
        )
