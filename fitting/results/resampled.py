"""Intervals of coefficients beyond the linear analysis: from bootstrap replicates."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace


@dataclass(frozen=True)
class BootstrapInterval:
    """The 95 % percentile interval of a coefficient, in the signs of `FitResult.signs`.

    - `lower`, `upper`: percentiles 2.5 and 97.5 of the replicates, expanded around the value for sweeps that the fit
      follows and for few sweeps (`tirefmu.fitting.resampling.leverage`), within the bounds; NaN if the coefficient is
      not identifiable, because the regularization then determines its replicates.
    - `deviation`: standard deviation of the replicates, times the factor for sweeps that the fit follows.
    """

    name: str
    lower: float
    upper: float
    deviation: float

    def mirrored(self) -> BootstrapInterval:
        """Return the same with the opposite sign."""
        return replace(self, lower=0.0 - self.upper, upper=0.0 - self.lower)


@dataclass(frozen=True)
class Bootstrap:
    """The result of a block bootstrap by sweeps.

    - `replicates`: number of replicates in the intervals.
    - `failed`: number of further replicates that did not converge.
    - `sweeps`: number of sweeps that were weighted at random.
    """

    replicates: int
    failed: int
    sweeps: int
    seed: int
    intervals: tuple[BootstrapInterval, ...]

    def interval(self, name: str) -> BootstrapInterval | None:
        """Return the interval of a coefficient; None if no stage with all its rows freed it."""
        return next((interval for interval in self.intervals if interval.name == name), None)

    def mirrored(self, flips: Callable[[str], bool]) -> Bootstrap:
        """Return the same with the opposite sign of some coefficients."""
        return replace(
            self,
            intervals=tuple(interval.mirrored() if flips(interval.name) else interval for interval in self.intervals),
        )
