"""Intervals of coefficients beyond the linear analysis: from bootstrap replicates and from profile likelihoods."""

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
        return next((each for each in self.intervals if each.name == name), None)

    def mirrored(self, flips: Callable[[str], bool]) -> Bootstrap:
        """Return the same with the opposite sign of some coefficients."""
        return replace(self, intervals=tuple(one.mirrored() if flips(one.name) else one for one in self.intervals))


@dataclass(frozen=True)
class Profile:
    """The profile likelihood of a coefficient, in the signs of `FitResult.signs`.

    - `value`: at the largest likelihood.
    - `lower`, `upper`: the 95 % interval. If it ends at a bound of the coefficient, that bound; NaN if it does not end.
    - `lower_end`, `upper_end`: why it ends: "likelihood", "bound", "no solution" (no other coefficients satisfy the
      physical constraints beyond, or the solver fails), or "flat" (the likelihood does not decrease enough).
    - `values`, `deviances`: the curve in increasing order of values: twice the decrease of the log-likelihood, for
      noise that is correlated in time. The interval ends at 3.84.
    """

    name: str
    unit: str
    value: float
    lower: float
    upper: float
    lower_end: str
    upper_end: str
    values: tuple[float, ...]
    deviances: tuple[float, ...]

    def mirrored(self) -> Profile:
        """Return the same with the opposite sign."""
        return replace(
            self, value=0.0 - self.value, lower=0.0 - self.upper, upper=0.0 - self.lower,
            lower_end=self.upper_end, upper_end=self.lower_end,
            values=tuple(0.0 - value for value in reversed(self.values)), deviances=self.deviances[::-1],
        )  # fmt: skip
