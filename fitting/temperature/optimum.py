"""The temperature at which friction is largest, from measured forces and recorded temperatures.

Around the fitted tire, forces are linear in the coefficients of `temp_friction` (to second order in the temperature),
in the level of friction, and in the delay of the sensor. The correlated residual determines their covariance, and with
it whether friction has a maximum within the recorded range. The delay is that between forces and temperature: the one
with which a heat balance describes the temperature also has what the balance lacks.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import pandas as pd

from ...measurements import Recording
from ...numerics.arrays import FloatArray
from ...numerics.correlation import correlation_length
from ...tires.evaluation import Conventions, evaluate
from ...tires.tire import Tire
from .heat_balance import DELAY, DELAY_SPREAD

#: The effect with the coefficients TMU1 and TMU2, per K and per K^2 about TREF.
EFFECT = "temp_friction"
#: Percentiles of the recorded temperature within which a maximum can be determined; standard deviations of an interval,
#: and of the curvature of friction that has one (a chance of 0.001, as for an effect in a diagnosis).
RANGE, QUANTILE, SIGNIFICANT = (5.0, 95.0), 1.96, 3.09
#: Steps of differences: of TMU1, TMU2 and the delay, s, and of the level as a share; Gauss-Newton steps.
STEPS, SHARE, ITERATIONS = (1e-5, 1e-7, 1e-3), 1e-4, 3


@dataclass(frozen=True)
class Optimum:
    """The temperature of the largest friction, deg C.

    - `value`, `half`: the temperature and half its 95 % interval; NaN unless `determined`.
    - `determined`: whether friction is significantly concave, with its maximum in the recorded range `low` to `high`.
    """

    value: float
    half: float
    determined: bool
    low: float
    high: float

    def text(self) -> str:
        """Return the result in one sentence.

        >>> Optimum(71.2, 1.4, True, 50.0, 90.0).text()
        'friction is largest at 71.2 +- 1.4 deg C'
        """
        if not self.determined:
            return (
                f"the temperature of the largest friction is not determined ({self.low:.0f} to {self.high:.0f} deg C)"
            )
        return f"friction is largest at {self.value:.1f} +- {self.half:.1f} deg C"


def optimum_temperature(tire: Tire, recordings: Sequence[Recording], column: str = "T") -> Optimum:
    """Return the temperature of the largest friction.

    `tire`: fitted, with the effect `temp_friction`. `recordings`: with forces and the recorded temperature `column`,
    deg C.
    """
    temperatures = np.concatenate([recording.table[column].to_numpy(dtype=np.float64) for recording in recordings])
    low, high = map(float, np.nanpercentile(temperatures, RANGE))
    linear, curved, delay = tire.values["TMU1"] - tire.values["TMUA"], _curvature(tire), DELAY
    covariance = np.zeros((3, 3))
    for _ in range(ITERATIONS):
        centered = tire.with_values(TMUA=0.0, TMU1=linear, TMU2=curved)
        change, covariance = _step(centered, recordings, column, delay)
        linear, curved, delay = linear + change[0], curved + change[1], delay + change[2]
    if not curved < -SIGNIFICANT * np.sqrt(covariance[1, 1]):
        return Optimum(np.nan, np.nan, False, low, high)
    value = tire.values["TREF"] - linear / (2.0 * curved)
    slope = np.array([-1.0, linear / curved, 0.0]) / (2.0 * curved)
    half = QUANTILE * float(np.sqrt(slope @ covariance @ slope))
    determined = bool(low <= value <= high and half <= (high - low) / 2.0)
    return Optimum(*((float(value), half) if determined else (np.nan, np.nan)), determined, low, high)


def _surface(recording: Recording, column: str, delay: float) -> pd.DataFrame:
    """Return a table without time whose T is the temperature of the surface, which the sensor shows later."""
    table, shown = recording.table, recording.table[column].to_numpy(dtype=np.float64, copy=True)
    if "t" not in table:
        return table.assign(T=shown)
    for number in np.unique(segment := recording.segment_numbers()):
        rows = np.flatnonzero(segment == number)
        t = table["t"].to_numpy(dtype=np.float64)[rows]
        shown[rows] = np.interp(t + delay, t, shown[rows])
    return table.assign(T=shown).drop(columns="t")


def _curvature(tire: Tire) -> float:
    """Return the coefficient of the squared temperature in the whole factor of friction, to second order."""
    decay = tire.values["TMUA"]
    return tire.values["TMU2"] - tire.values["TMU1"] * decay + decay**2 / 2.0


def _step(tire: Tire, recordings: Sequence[Recording], column: str, delay: float) -> tuple[FloatArray, FloatArray]:
    """Return the Gauss-Newton step of TMU1, TMU2 and the delay of the sensor, and their covariance."""
    levels = [name for role in ("friction_x", "friction_y") if (name := tire.symbolic_model.leading(role))]
    steps = dict(zip(("TMU1", "TMU2", "delay"), STEPS, strict=True))
    steps |= {name: SHARE * abs(tire.values[name]) for name in levels}
    prior = np.array([0.0, 0.0, DELAY_SPREAD**-2, *np.zeros(len(levels))])
    normal, right = np.diag(prior), prior * (DELAY - delay)
    for recording in recordings:
        for channel in (name for name in ("Fx", "Fy") if name in recording.table):
            residual, columns = _linearized(tire, recording, column, channel, steps, delay)
            weight = 1.0 / (np.mean(residual**2) * correlation_length(residual, recording.segment_numbers()))
            normal += weight * columns @ columns.T
            right += weight * columns @ residual
    covariance = np.asarray(np.linalg.pinv(normal, hermitian=True), dtype=np.float64)
    return (covariance @ right)[:3], covariance[:3, :3]


def _linearized(
    tire: Tire, recording: Recording, column: str, channel: str, steps: dict[str, float], delay: float
) -> tuple[FloatArray, FloatArray]:
    """Return measured minus computed force, shape (n,), and derivatives by unknowns, shape (p, n); 0 if unknown."""

    def computed(name: str = "", step: float = 0.0) -> FloatArray:
        table = _surface(recording, column, delay + (step if name == "delay" else 0.0))
        changed = tire.with_values(**{name: tire.values[name] + step}) if name in tire.values else tire
        return evaluate(changed, table, Conventions(recording.signs))[channel].to_numpy(dtype=np.float64)

    now = computed()
    residual = recording.table[channel].to_numpy(dtype=np.float64) - now
    present = np.isfinite(residual)
    columns = [(computed(name, step) - now) / step for name, step in steps.items()]
    return np.where(present, residual, 0.0), np.where(present, np.stack(columns), 0.0)
