"""The temperature at which friction is largest, from measured forces and recorded temperatures.

Around the fitted tire, forces are linear in the coefficients of `temp_friction` (to second order in the temperature)
and in the level of friction. The correlated residual determines their covariance, and with it whether friction has a
maximum within the recorded range.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from tirefmu.estimation.correlation import correlation_length
from tirefmu.measurements import Recording
from tirefmu.tires.tire import Tire

FloatArray = npt.NDArray[np.float64]

#: The effect with the coefficients TMU1 and TMU2, per K and per K^2 about TREF.
EFFECT = "temp_friction"
#: Percentiles of the recorded temperature within which a maximum can be determined; standard deviations of an interval.
RANGE, QUANTILE = (5.0, 95.0), 1.96
#: Steps of differences: of TMU1 and TMU2, and of the level as a share; Gauss-Newton steps.
STEPS, SHARE, ITERATIONS = (1e-5, 1e-7), 1e-4, 2


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
    low, high = np.nanpercentile(temperatures, RANGE)
    linear, curved = tire.values["TMU1"] - tire.values["TMUA"], _curvature(tire)
    covariance = np.zeros((2, 2))
    for _ in range(ITERATIONS):
        centered = tire.with_values(TMUA=0.0, TMU1=linear, TMU2=curved)
        change, covariance = _step(centered, recordings, column)
        linear, curved = linear + change[0], curved + change[1]
    if not curved < -QUANTILE * np.sqrt(covariance[1, 1]):
        return Optimum(np.nan, np.nan, False, float(low), float(high))
    value = tire.values["TREF"] - linear / (2.0 * curved)
    slope = np.array([-1.0, linear / curved]) / (2.0 * curved)
    half = QUANTILE * float(np.sqrt(slope @ covariance @ slope))
    determined = bool(low <= value <= high and half <= (high - low) / 2.0)
    return Optimum(*((value, half) if determined else (np.nan, np.nan)), determined, float(low), float(high))


def _curvature(tire: Tire) -> float:
    """Return the coefficient of the squared temperature in the whole factor of friction, to second order."""
    decay = tire.values["TMUA"]
    return tire.values["TMU2"] - tire.values["TMU1"] * decay + decay**2 / 2.0


def _step(tire: Tire, recordings: Sequence[Recording], column: str) -> tuple[FloatArray, FloatArray]:
    """Return the Gauss-Newton step of TMU1 and TMU2, and their covariance."""
    levels = [name for role in ("friction_x", "friction_y") if (name := tire.symbolic_model.leading(role))]
    steps = dict(zip(("TMU1", "TMU2"), STEPS, strict=True))
    steps |= {name: SHARE * abs(tire.values[name]) for name in levels}
    normal, right = np.zeros((len(steps), len(steps))), np.zeros(len(steps))
    for recording in recordings:
        for channel in (name for name in ("Fx", "Fy") if name in recording.table):
            residual, columns = _linearized(tire, recording, column, channel, steps)
            weight = 1.0 / (np.mean(residual**2) * correlation_length(residual, recording.segment_numbers()))
            normal += weight * columns @ columns.T
            right += weight * columns @ residual
    covariance = np.asarray(np.linalg.pinv(normal, hermitian=True), dtype=np.float64)
    return (covariance @ right)[:2], covariance[:2, :2]


def _linearized(
    tire: Tire, recording: Recording, column: str, channel: str, steps: dict[str, float]
) -> tuple[FloatArray, FloatArray]:
    """Return measured minus computed force, shape (n,), and derivatives by coefficients, shape (p, n); 0 if unknown."""
    table = recording.table.assign(T=recording.table[column]).drop(columns="t")

    def computed(changed: Tire) -> FloatArray:
        return changed.evaluate(table, signs=recording.signs)[channel].to_numpy(dtype=np.float64)

    now = computed(tire)
    residual = table[channel].to_numpy(dtype=np.float64) - now
    known = np.isfinite(residual)
    columns = [(computed(tire.with_values(**{name: tire.values[name] + step})) - now) / step
               for name, step in steps.items()]  # fmt: skip
    return np.where(known, residual, 0.0), np.where(known, np.stack(columns), 0.0)
