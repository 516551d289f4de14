"""Coefficients of the effect `temperature` from recorded temperatures, with intervals and a hold-out set.

Gauss-Newton steps find the logarithms of coefficients of a heat balance, start temperatures and the sensor's delay.

An infrared sensor is late. A delay that is not estimated is taken for heat capacity and conductance of the surface, and
through them for slow losses of heat: made recordings with a delay of 0.1 s had twice the error of prediction. Its
emissivity cannot be estimated: all temperatures above the surroundings scale with it, as with the share of the heat.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
import pandas as pd

from ...boundary.errors import DataError, nearest, no_single_text
from ...measurements import Recording
from ...numerics.arrays import BoolArray, FloatArray
from ...numerics.correlation import correlation_length
from ...symbolic.channels import channel
from ...tires.tire import Tire
from ..options import FitOptions
from .fitted_temperature import FittedTemperature
from .heat_balance import BLOCK, DELAY, DELAY_SPREAD, EFFECT, ZERO_CELSIUS, HeatBalance, integrated
from .optimum import EFFECT as FRICTION
from .optimum import QUANTILE, optimum_temperature

Used = Sequence[BoolArray]

#: The coefficients that a fit frees, in the logarithm; prior means are their neutral values. The others cannot be
#: separated from these in recordings at one speed; heat capacities and conductances are relative to THSHARE.
FREE = (
    "THCAPS", "THCAPB", "THCAPC", "THCAPG", "THCONS", "THCONB", "THCONG", "THROAD", "THAIR", "THSIDE", "THROLLB",
    "THROLL", "THSHAREX",
)  # fmt: skip
#: The recorded temperature of the tread by default.
RECORDED = "T"
#: Temperatures of the surroundings, K; how much warmer the coldest tread can be, K, and how much colder.
AROUND, TOO_WARM, COLDER = ("T_ambient", "T_road"), 60.0, 5.0
STARTS = ("THSTARTS", "THSTARTB", "THSTARTC", "THSTARTG")
#: A coefficient is determined if the data reduce the standard deviation of its logarithm below this share of the prior.
DETERMINED = 0.5
#: The share of the time that the hold-out fit uses.
FITTED_SHARE = 0.7
#: Standard deviations of the priors: of a logarithm, and of a start temperature about the first recorded one, K.
SPREAD, START_SPREAD = 1.0, 10.0
#: Noise, K, and its correlation length, blocks, before residuals are known; rounds that estimate them.
FIRST_NOISE, FIRST_LENGTH, ROUNDS = 2.0, 50.0, 2
#: Step of a difference of a logarithm, its largest change in one step, iterations, and the change that ends them, in
#: standard deviations of the result.
STEP, LONGEST_STEP, ITERATIONS, CONVERGED = 1e-4, 1.0, 20, 0.03
#: Halvings of a step that does not reduce the cost.
HALVINGS = 6


def temperature_column(options: FitOptions) -> str:
    """Return the recorded temperature to which a fit is requested, or ''."""
    return options.temperature or (RECORDED if EFFECT in (options.effects or ()) else "")


def forces_alone(options: FitOptions) -> FitOptions:
    """Return the options of the fit of the forces, in which effects of temperature have the recorded one."""
    return replace(options, **settings_of_forces(vars(options)))


def settings_of_forces(settings: Mapping[str, Any]) -> dict[str, Any]:
    """Return the same for options by name.

    >>> settings_of_forces({"effects": ["load_friction", "temperature"], "loss": "huber"})
    {'effects': ['load_friction'], 'loss': 'huber', 'temperature': None}
    """
    effects = settings.get("effects")
    no_single_text("effects", effects)
    chosen = {} if effects is None else {"effects": [name for name in effects if name != EFFECT]}
    return {**settings, **chosen, "temperature": None}


def with_temperature(recordings: Sequence[Recording], column: str) -> list[Recording]:
    """Return the recordings with time and a recorded temperature; raise `DataError` if there are none."""
    chosen = [recording for recording in recordings if {"t", column} <= {*recording.table}]
    for recording in chosen or recordings:
        check_temperature(recording, column)
    return chosen


def check_temperature(recording: Recording, column: str) -> None:
    """Raise `DataError` if a recording lacks time or temperature, or has temperatures that no tread has."""
    table = recording.table
    for name in ("t", column):
        if name not in table:
            near = nearest(name, list(map(str, table)))
            raise DataError(f"{recording.source}: a fit of the temperature needs the column {name!r}{near}")
    values = pd.to_numeric(table[column], errors="coerce").to_numpy(dtype=np.float64)
    if not np.isfinite(values).any():
        raise DataError(f"{recording.source}: column {column!r} has no number")
    low, high = channel(RECORDED).limits
    bad = np.flatnonzero((values < low) | (values > high))
    if bad.size:
        what = f"row {bad[0] + 1}: {column} is {values[bad[0]]:g}, but a tread has {low:g} to {high:g} deg C"
        raise DataError(f"{recording.source}: {what}: declare another unit")
    check_unit(recording, column, values)


def check_unit(recording: Recording, column: str, values: FloatArray) -> None:
    """Raise `DataError` if temperatures are probably in deg F: the coldest tread is much warmer than its surroundings.

    A tread that has cooled has the temperature of the air or of the road; 20 deg C are 68 deg F.
    """
    surroundings = [recording.table[name].to_numpy(dtype=np.float64) for name in AROUND if name in recording.table]
    if not surroundings:
        return
    around = float(np.nanmedian(surroundings[0])) - ZERO_CELSIUS
    coldest, in_celsius = float(np.nanmin(values)), (float(np.nanmin(values)) - 32.0) / 1.8
    if coldest - around > TOO_WARM and in_celsius >= around - COLDER:
        raise DataError(
            f"{recording.source}: {column} is never below {coldest:.0f} deg C in surroundings of {around:.0f} deg C: "
            f"in deg F? declare it: '{column} [deg F]'"
        )


def fit_temperature(tire: Tire, recordings: Sequence[Recording], column: str = "T") -> tuple[Tire, FittedTemperature]:
    """Fit the effect `temperature` of a tire to the recorded temperature of recordings.

    Parameters
    ----------
    tire : Tire
        With fitted forces, with or without the effect; its model has a place for it.
    recordings : sequence of Recording
        With time, speed and the recorded temperature of the tread.
    column : str
        The recorded temperature, deg C.

    Returns
    -------
    tuple
        The tire with the effect, whose effects of T have the predicted temperature; and the `FittedTemperature`.

    Raises
    ------
    DataError
        If a recording lacks the column or time, or its temperatures are impossible.

    References
    ----------
    Sorniotti, SAE 2009-01-0441; Harsh and Shyrokau, Applied Sciences 9 (2019) 5328.
    """
    for recording in recordings:
        check_temperature(recording, column)
    forces = replace(tire, effects=tire.has - {EFFECT})
    tire = replace(tire, effects={*tire.has, EFFECT})
    balances = HeatBalance.of_all(tire, recordings, column)
    used = [_first_part(balance) for balance in balances]
    early = solved(balances, used, FREE)
    held_out, constant = _held_out(balances, used, early)
    solution = solved(balances, [np.isfinite(balance.measured) for balance in balances], FREE, early)
    errors = np.concatenate([error[np.isfinite(error)] for error in solution.errors(balances)])
    values = solution.values()
    spread = {name: float(s) for name, s in zip(solution.free, solution.spread, strict=True)}
    optimum = optimum_temperature(forces, recordings, column) if FRICTION in tire.has else None
    fitted = FittedTemperature(
        column, _rms(errors), held_out, constant, solution.length * BLOCK, values,
        {name: float(np.exp(QUANTILE * s)) for name, s in spread.items()},
        tuple(name for name, s in spread.items() if s < DETERMINED * SPREAD),
        tuple(tuple(map(float, start)) for start in solution.starts),
        (solution.delay, QUANTILE * solution.delay_spread), optimum,
    )  # fmt: skip
    given = dict(zip(STARTS, fitted.starts[0], strict=True))
    return tire.with_values(**values, **given, THACT=1.0), fitted


def _first_part(balance: HeatBalance) -> BoolArray:
    end = balance.t[0] + FITTED_SHARE * (balance.t[-1] - balance.t[0])
    return np.asarray(np.isfinite(balance.measured) & (balance.t <= end))


def _held_out(
    balances: Sequence[HeatBalance], used: Sequence[BoolArray], early: ThermalSolution
) -> tuple[float, float]:
    """Return the rms error of the nodes that were not used, and that of their mean, K."""
    errors, constants = [], []
    for balance, error, part in zip(balances, early.errors(balances), used, strict=True):
        last = np.isfinite(balance.measured) & ~part
        errors.append(error[last])
        constants.append(balance.measured[last] - balance.measured[last].mean())
    return _rms(np.concatenate(errors)), _rms(np.concatenate(constants))


def _rms(values: FloatArray) -> float:
    return float(np.sqrt(np.mean(values**2)))


@dataclass(frozen=True)
class ThermalSolution:
    """Values of coefficients and starts.

    - `free`: names of coefficients; `center`, `x`, shape (p,): prior mean and value of their logarithms.
    - `starts`, shape (n_recordings, m): start temperatures, K.
    - `delay`: of the sensor, s.
    - `noise`, `length`: standard deviation of the residual of a block, K, and its correlation length in blocks.
    - `spread`, shape (p,), `delay_spread`: standard deviations of `x` and of `delay`.
    """

    free: tuple[str, ...]
    center: FloatArray
    x: FloatArray
    starts: FloatArray
    delay: float = DELAY
    noise: float = FIRST_NOISE
    length: float = FIRST_LENGTH
    spread: FloatArray = field(default_factory=lambda: np.empty(0))
    delay_spread: float = DELAY_SPREAD

    def values(self) -> dict[str, float]:
        """Return the coefficients by name."""
        return dict(zip(self.free, np.exp(self.x).tolist(), strict=True))

    def errors(self, balances: Sequence[HeatBalance]) -> list[FloatArray]:
        """Return predicted minus measured temperature at the nodes of each recording, K; NaN in pauses."""
        values = self.values()
        return [self.sensed(balance, balance.temperatures(values, start)) - balance.measured
                for balance, start in zip(balances, self.starts, strict=True)]  # fmt: skip

    def sensed(self, balance: HeatBalance, course: FloatArray) -> FloatArray:
        """Return what the sensor shows at the nodes, shape (n,), of temperatures, shape (n, m)."""
        return np.interp(balance.t - self.delay, balance.t, course[:, 0])


def solved(
    balances: Sequence[HeatBalance], used: Used, free: Sequence[str], begin: ThermalSolution | None = None
) -> ThermalSolution:
    """Return the coefficients with the largest posterior density, for the used nodes of recordings.

    The residual is correlated: its sum of squares is divided by the correlation length, so that a recording counts as
    many rows as it has independent ones.
    """
    solution = begin or _first(balances, free)
    for _ in range(ROUNDS):
        solution = _converged(balances, used, solution)
        errors = [error[part] for error, part in zip(solution.errors(balances), used, strict=True)]
        segments = [np.cumsum(np.isnan(balance.measured))[part] + 1e6 * i
                    for i, (balance, part) in enumerate(zip(balances, used, strict=True))]  # fmt: skip
        error = np.concatenate(errors)
        noise, length = float(np.sqrt(np.mean(error**2))), correlation_length(error, np.concatenate(segments))
        solution = replace(solution, noise=max(noise, 1e-3), length=length)
    return _converged(balances, used, solution)


def _first(balances: Sequence[HeatBalance], free: Sequence[str]) -> ThermalSolution:
    declared = balances[0].tire.symbolic_model.coefficients
    center = np.log([declared[name].default for name in free])
    starts = [np.full(len(b.states), b.measured[np.isfinite(b.measured)][0]) for b in balances]
    return ThermalSolution(tuple(free), center, center.copy(), np.stack(starts))


def _converged(balances: Sequence[HeatBalance], used: Used, solution: ThermalSolution) -> ThermalSolution:
    for _ in range(ITERATIONS):
        residual, jacobian = _linearized(balances, used, solution)
        normal = jacobian.T @ jacobian
        change = np.asarray(np.linalg.solve(normal, -jacobian.T @ residual), dtype=np.float64)
        p = len(solution.x)
        change *= min(1.0, LONGEST_STEP / max(float(np.abs(change[:p]).max(initial=0.0)), 1e-12))
        deviation = np.sqrt(np.diag(np.linalg.inv(normal)))
        spread, delay_spread = deviation[:p], float(deviation[-1])
        for halving in range(HALVINGS):
            moved = _moved(solution, change * 0.5**halving)
            if _cost(balances, used, moved) <= float(residual @ residual):
                break
        else:
            return replace(solution, spread=spread, delay_spread=delay_spread)
        solution = replace(moved, spread=spread, delay_spread=delay_spread)
        if (np.abs(change[:p]) < CONVERGED * spread).all():
            break
    return solution


def _moved(solution: ThermalSolution, change: FloatArray) -> ThermalSolution:
    x, starts = np.split(change[:-1], [len(solution.x)])
    return replace(
        solution, x=solution.x + x, starts=solution.starts + starts.reshape(solution.starts.shape),
        delay=max(0.0, solution.delay + float(change[-1])),
    )  # fmt: skip


def _prior(balances: Sequence[HeatBalance], solution: ThermalSolution) -> FloatArray:
    first = np.stack([b.measured[np.isfinite(b.measured)][:1] for b in balances])
    starts = (solution.starts - first) / START_SPREAD
    delay = (solution.delay - DELAY) / DELAY_SPREAD
    return np.concatenate([(solution.x - solution.center) / SPREAD, starts.ravel(), [delay]])


def _cost(balances: Sequence[HeatBalance], used: Used, solution: ThermalSolution) -> float:
    weight = 1.0 / (solution.noise * np.sqrt(solution.length))
    errors = [weight * error[part] for error, part in zip(solution.errors(balances), used, strict=True)]
    residual = np.concatenate([*errors, _prior(balances, solution)])
    return float(residual @ residual)


def _linearized(
    balances: Sequence[HeatBalance], used: Used, solution: ThermalSolution
) -> tuple[FloatArray, FloatArray]:
    """Return residual and Jacobian, prior included, in standard deviations."""
    weight = 1.0 / (solution.noise * np.sqrt(solution.length))
    p, (k, m) = len(solution.x), solution.starts.shape
    residuals, slopes = [], []
    for i, (balance, part, start) in enumerate(zip(balances, used, solution.starts, strict=True)):
        matrix, supply = balance.system(solution.values())
        course = integrated(balance.t, matrix, supply, start)
        now = solution.sensed(balance, course)
        columns = np.zeros((int(part.sum()), p + k * m + 1))
        for j in range(p):
            changed = replace(solution, x=solution.x + STEP * (np.arange(p) == j)).values()
            columns[:, j] = ((solution.sensed(balance, balance.temperatures(changed, start)) - now) / STEP)[part]
        for j, unit in enumerate(np.eye(m)):
            columns[:, p + i * m + j] = integrated(balance.t, matrix, np.zeros_like(supply), unit)[part, 0]
        columns[:, -1] = -np.gradient(course[:, 0], balance.t)[part]
        residuals.append(weight * (now - balance.measured)[part])
        slopes.append(weight * columns)
    spreads = np.concatenate([np.full(p, SPREAD), np.full(k * m, START_SPREAD), [DELAY_SPREAD]])
    return (np.concatenate([*residuals, _prior(balances, solution)]), np.concatenate([*slopes, np.diag(1.0 / spreads)]))
