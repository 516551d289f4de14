"""Coefficients of the effect `temperature` from recorded temperatures, with intervals and a hold-out set."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from ...measurements import Recording
from ...numerics.arrays import BoolArray, FloatArray
from ...tires.tire import Tire
from .fitted_temperature import FittedTemperature
from .heat_balance import BLOCK, EFFECT, HeatBalance
from .optimum import EFFECT as FRICTION
from .optimum import QUANTILE, optimum_temperature
from .selection import check_temperature
from .solution import SPREAD, ThermalSolution, solved

#: The coefficients that a fit frees, in the logarithm; prior means are their neutral values. The others cannot be
#: separated from these in recordings at one speed; heat capacities and conductances are relative to THSHARE.
FREE = (
    "THCAPS", "THCAPB", "THCAPC", "THCAPG", "THCONS", "THCONB", "THCONG", "THROAD", "THAIR", "THSIDE", "THROLLB",
    "THROLL", "THSHAREX",
)  # fmt: skip
STARTS = ("THSTARTS", "THSTARTB", "THSTARTC", "THSTARTG")
#: A coefficient is determined if the data reduce the standard deviation of its logarithm below this share of the prior.
DETERMINED = 0.5
#: The share of the time that the hold-out fit uses.
FITTED_SHARE = 0.7


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
