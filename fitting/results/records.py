"""The records of a fit result: fitted coefficients, goodness of fit by channel, bounds, cross-validation, bootstrap."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from math import isinf, nan

import numpy as np

from ...numerics.arrays import FloatArray

#: Change of a channel without a bound, as a share of its standard deviation, and reduction of its error, from which a
#: bound has a consequence. Judgement.
VISIBLE_CHANGE, VISIBLE_GAIN = 0.02, 0.01


@dataclass(frozen=True)
class FittedCoefficient:
    """A coefficient after a fit, in the signs of `FitResult.signs`.

    - `guess`, `lower`, `upper`, `value`: the guess is the initial value of the fit.
    - `at_bound`: the value is at one of its bounds.
    - `determined`: false if the coefficient has no influence at the measured rows; it then has its default, or the
      value of the start tire or the recipe.
    - `stage`: the last stage that freed and determined it.
    - `interval`: half the width of its 95 % interval under time-correlated noise; infinite if the data determine it
      only together with others, NaN at a bound, or if no stage with all its rows freed it. It contains `other`.
    - `from_family`: the data hardly determine the value, it comes from the family (`FitOptions.family`).
    - `other`: its value in a second solution that the data do not distinguish from this one; None without one.
    """

    name: str
    unit: str
    guess: float
    lower: float
    upper: float
    value: float
    at_bound: bool
    determined: bool
    stage: str
    interval: float = nan
    from_family: bool = False
    other: float | None = None

    @property
    def identified(self) -> bool:
        """Whether the data determine it by itself: with influence, not at a bound, and with no infinite interval."""
        return self.determined and not self.at_bound and not isinf(self.interval)

    def mirrored(self) -> FittedCoefficient:
        """Return the same with the opposite sign."""
        guess, lower, upper, value = (0.0 - number for number in (self.guess, self.upper, self.lower, self.value))
        other = None if self.other is None else 0.0 - self.other  # 0.0 - number: no -0.0
        return replace(self, guess=guess, lower=lower, upper=upper, value=value, other=other)


@dataclass(frozen=True)
class ChannelFit:
    """Goodness of fit of a channel of a recording.

    - `rows`: all measured rows, also those that were excluded from the fit.
    - `rmse`: over all rows, in the channel's unit.
    - `r2`: coefficient of determination over all rows: 1 - residual variance over variance about the mean.
    - `r2_uncentred`: 1 - sum of squared residuals over sum of squares, as in the Trento report.
    - `noise_floor`, `explained_by_inputs`, `explained_by_time`, `between_repeats`: the parts of `fitted_rmse`, whose
      squares add up to its square (`tirefmu.numerics.noise_floor`): what no model of inputs and time could remove,
      what a function of the inputs explains, what changes slowly for another reason (time, the past, or detail that is
      finer than such a function), what differs between repeats.
    - `effective_rows`: effective sample size: the residuals of the last stage are correlated in time.
    - `fitted_rmse`, `fitted_r2`: the same over the fitted rows, without excluded ones.
    """

    recording: str
    channel: str
    unit: str
    rows: int
    rmse: float
    r2: float
    r2_uncentred: float
    noise_floor: float = nan
    effective_rows: float = nan
    fitted_rows: int = 0
    fitted_rmse: float = nan
    fitted_r2: float = nan
    explained_by_inputs: float = nan
    explained_by_time: float = nan
    between_repeats: float = nan

    @property
    def above_floor(self) -> float:
        """RMSE over the fitted rows divided by the noise floor; NaN if one of them is not known."""
        return self.fitted_rmse / max(self.noise_floor, 1e-300) if self.noise_floor >= 0.0 else nan

    @property
    def spread(self) -> float:
        """Standard deviation of the measured values of the fitted rows, in the channel's unit."""
        return float(self.fitted_rmse / np.sqrt(max(1.0 - self.fitted_r2, 1e-300)))

    @property
    def model_error(self) -> float:
        """Error beyond the noise floor, as a share of `spread`."""
        beyond = float(np.sqrt(max(self.fitted_rmse**2 - self.noise_floor**2, 0.0)))
        return beyond / self.spread if self.spread > 0.0 else nan


@dataclass(frozen=True)
class BoundConsequence:
    """What changes if the bound of a coefficient is moved and the stage is solved again, in adapted SAE.

    - `value`: of the coefficient then; NaN if no solution was found.
    - `channel`: the channel that changes most.
    - `rmse_at_bound`, `rmse_beyond`: root mean square error of this channel, in its unit.
    - `change`: largest change of the channel at a measured row, as a share of its standard deviation.
    """

    name: str
    value: float = nan
    channel: str = ""
    rmse_at_bound: float = nan
    rmse_beyond: float = nan
    change: float = nan

    @property
    def matters(self) -> bool | None:
        """Whether the bound changes the tire visibly; None if no solution was found."""
        if not np.isfinite(self.change):
            return None
        gain = 1.0 - self.rmse_beyond / self.rmse_at_bound if self.rmse_at_bound > 0.0 else 0.0
        return bool(self.change > VISIBLE_CHANGE or gain > VISIBLE_GAIN)

    def text(self) -> str:
        """Return the consequence in a few words."""
        if self.matters is None:
            return "no solution beyond the bound"
        if not self.matters:
            return "no consequence"
        rmse = f"RMSE of {self.channel} {self.rmse_at_bound:.3g} -> {self.rmse_beyond:.3g}"
        return f"beyond the bound, at {self.value:.4g}: {rmse}, {self.channel} changes by up to {self.change:.1%}"


@dataclass(frozen=True)
class HeldOut:
    """Prediction error of a channel of a recording at operating conditions that were not fitted.

    Attributes
    ----------
    recording, channel, unit : str
        The recording, the output and its SI unit.
    rows : int
        Number of predicted rows.
    in_sample, held_out : float
        Root mean square error over all rows: of the fit of all data, and of the fits without the operating condition of
        the row.
    """

    recording: str
    channel: str
    unit: str
    rows: int
    in_sample: float
    held_out: float


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


def quality(measured: FloatArray, computed: FloatArray) -> tuple[int, float, float, float]:
    """Return measured rows, RMSE, centred and uncentred R2.

    `measured`, `computed`, shape (n,). Returns: NaN if a channel has no variation or a measured row has no computed
    value.

    >>> quality(np.array([1.0, 2.0, 3.0]), np.array([1.0, 2.0, 2.0]))[2]
    0.5
    """
    return Moments.of(measured, computed).quality


@dataclass(frozen=True)
class Moments:
    """Sums over measured and computed values, from which the goodness of fit of parts of the rows together follows.

    - `n`: number of measured rows.
    - `mean`: of the measured values.
    - `squares`, `about`, `total`: sums of squares: of the residuals, of the measured values about their mean, and of
      the measured values.

    >>> measured, computed = np.array([1.0, 2.0, 3.0]), np.array([1.0, 2.0, 2.0])
    >>> (Moments.of(measured[:1], computed[:1]) + Moments.of(measured[1:], computed[1:])).quality[2]
    0.5
    """

    n: int = 0
    mean: float = 0.0
    squares: float = 0.0
    about: float = 0.0
    total: float = 0.0

    @classmethod
    def of(cls, measured: FloatArray, computed: FloatArray) -> Moments:
        """Return the sums of rows, shape (n,) each; NaN is not measured."""
        rows = np.isfinite(measured)
        y, residual = measured[rows], (computed - measured)[rows]
        if not len(y):
            return cls()
        mean = float(y.mean())
        return cls(len(y), mean, *(float(np.sum(values**2)) for values in (residual, y - y.mean(), y)))

    def __add__(self, other: Moments) -> Moments:
        """Return the sums of both parts (Chan, Golub and LeVeque, 1983)."""
        n = self.n + other.n
        if not self.n or not other.n:
            return self if self.n else other
        between = other.mean - self.mean
        return Moments(
            n, self.mean + between * other.n / n, self.squares + other.squares,
            self.about + other.about + between**2 * self.n * other.n / n, self.total + other.total,
        )  # fmt: skip

    @property
    def quality(self) -> tuple[int, float, float, float]:
        """Measured rows, RMSE, centred and uncentred R2; see `quality`."""
        if not self.n:
            return 0, float("nan"), float("nan"), float("nan")
        centred = 1 - self.squares / self.about if self.about > 0 else float("nan")
        uncentred = 1 - self.squares / self.total if self.total > 0 else float("nan")
        return self.n, (self.squares / self.n) ** 0.5, centred, uncentred
