"""The unknown numbers of an estimate: entries of the car and factors of the tires, as standardized deviations."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from ....boundary.errors import TireError
from ....tires import Tire
from .car import Car
from .car_entries import ENTRIES
from .log import Log

FloatArray = npt.NDArray[np.float64]

AXLES = ("front", "rear")
#: Scaling factors of a tire: lateral friction and cornering stiffness. The longitudinal ones follow them, but for
#: entries of the car: no channel of a log is the longitudinal force of a wheel, so that they are no findings.
FACTORS = ("LMUY", "LKY")
ALONG = {"LMUX": ("LMUY", "grip"), "LKX": ("LKY", "slip_stiffness")}
#: Prior probability that a factor changed. Judgement: who compares a drive expects other tires as likely as not.
CHANGED = 0.5
#: Prior standard deviation of the logarithm of a factor (it hardly matters for what a drive determines); standard
#: deviations of one that changed, each as likely. Judgement: tires change by some percent to a half.
FACTOR_SPREAD, CHANGES = 0.5, (0.05, 0.15, 0.5)
#: Largest difference of equal tires, two standard deviations: side forces of a repeated bench measurement scatter by
#: 1 to 2 %.
SAME = 0.02
#: What has no influence without these channels.
NEEDS: dict[str, tuple[str, ...]] = {
    "ax_offset": ("ax",), "ay_offset": ("ay",), "roll_gradient": ("ay",), "x": ("ay", "ax"),
    "y": ("ay", "ax"), "yaw_rate_offset": ("yaw_rate",), "reference_x": ("vy", "beta", "heading"),
    "reference_y": ("speed", "heading"), "heading_offset": ("beta", "heading"),
    "motion_delay": ("speed", "beta", "vy", "x"), "misalignment": ("ay", "ax"), "ay_gain": ("ay",),
    "yaw_rate_gain": ("yaw_rate",), "wheel_delay": ("omega",), "radius_front": ("omega",), "radius_rear": ("omega",),
    "grip_front": ("omega",), "grip_rear": ("omega",), "wheel_inertia": ("omega",),
    "unequal_front": ("omega",), "unequal_rear": ("omega",),
}  # fmt: skip


@dataclass(frozen=True)
class Unknowns:
    """The unknowns, functions of standardized deviations z.

    An entry of the car is center + spread z, one that cannot be negative center exp(spread z / center); a factor is
    exp(spread z).

    - `car`: names of the entries with an uncertainty. `factors`: pairs of axle and factor.
    - `center`, `spread`, shape (n,): of the entries, then 0 and `FACTOR_SPREAD` of the factors.
    """

    car: tuple[str, ...]
    factors: tuple[tuple[str, str], ...]
    center: FloatArray
    spread: FloatArray

    def __len__(self) -> int:
        return len(self.car) + len(self.factors)

    def car_values(self, car: Car, z: FloatArray) -> dict[str, float]:
        """Return all entries of the car, `cg_to_rear`, and factors under such names as `LKY_front`."""
        entries = {**car.values, **{name: float(self.entry(i, z[i], np.exp)) for i, name in enumerate(self.car)}}
        places = {f"{name}_{axle}": self.factor(axle, name) for axle, name in self.factors}
        factors = {name: float(np.exp(self.spread[i] * z[i])) for name, i in places.items()}
        return {**entries, **factors, "cg_to_rear": entries["wheelbase"] - entries["cg_to_front"]}

    def entry(self, i: int, z: Any, exp: Any) -> Any:
        """Return an entry of the car for its deviation; `exp`: the exponential of NumPy or CasADi."""
        center, spread = self.center[i], self.spread[i]
        if ENTRIES[self.car[i]].lower >= 0.0 and center > 0.0:
            return center * exp(spread / center * z)
        return center + spread * z

    def factor(self, axle: str, name: str) -> int:
        """Return the index of a factor."""
        return len(self.car) + self.factors.index((axle, name))


def unknowns_of(car: Car, log: Log, tires: Mapping[str, Tire]) -> Unknowns:
    """Return what a log can say something about: entries of the car with an uncertainty, and the factors."""
    lags = any(tire.lags for tire in tires.values())
    names = tuple(
        name
        for name, uncertainty in car.uncertainties.items()
        if uncertainty > 0.0
        and (lags or name != "relaxation")
        and any(channel.startswith(start) for start in NEEDS.get(name, ("",)) for channel in log.channels)
    )
    factors = tuple((axle, name) for axle in AXLES for name in FACTORS)
    center = np.array([car.values[name] for name in names] + [0.0] * len(factors))
    spread = np.array([car.uncertainties[name] for name in names] + [FACTOR_SPREAD] * len(factors))
    return Unknowns(names, factors, center, spread)


def check_factors(tires: Mapping[str, Tire]) -> None:
    """Raise unless every factor scales a force of each tire.

    Raises `TireError` with the model and the factors that it lacks.
    """
    for axle, tire in tires.items():
        load = tire.nominal("Fz")
        lacking = [name for name in FACTORS if not _scales(tire, name, load)]
        if lacking:
            raise TireError(
                f"the {axle} tire ({tire.model}) has no factor {', '.join(lacking)} that scales its forces: "
                "fit or convert it to mf52, mf61 or mf62"
            )


def _scales(tire: Tire, name: str, load: float) -> bool:
    if name not in tire.values:
        return False
    scaled = tire.with_values(**{name: 0.9 * tire.values[name]})
    slips = np.array([-0.02, 0.02, 0.1])
    before, after = (compared.forces(alpha=slips, Fz=load, code="numpy")["Fy"] for compared in (tire, scaled))
    return bool(np.abs(after - before).max() > 1e-6 * np.abs(before).max())
