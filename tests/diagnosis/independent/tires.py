"""Tires of four classes with random coefficients, adapted SAE: the core formula and the effects that a tire has."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from dataclasses import dataclass

import numpy as np

#: By class: nominal load (N), radius (m), pressure (Pa), speed (m/s), peak friction, slip stiffness over load.
CLASSES: Mapping[str, tuple[float, float, float, float, float, float]] = {
    "passenger": (4200.0, 0.315, 230e3, 16.7, 1.05, 20.0),
    "formula_student": (800.0, 0.228, 85e3, 11.2, 2.2, 38.0),
    "sport": (5200.0, 0.34, 210e3, 22.0, 1.35, 27.0),
    "truck": (27000.0, 0.5, 850e3, 13.9, 0.78, 9.5),
}
#: Typical coefficients of effects in the form of the book.
BOOK_SIZES: Mapping[str, Mapping[str, float]] = {
    "load_friction": {"PDY2": -0.18, "PDX2": -0.1},
    "load_stiffness": {"PKY2": 1.7},
    "load_curvature": {"PEY2": -0.7, "PEX2": 0.6},
    "camber_thrust": {"PKY6": 0.9, "PVY3": 0.25},
    "camber_stiffness": {"PKY3": 1.3},
    "camber_friction": {"PDY3": 7.0, "PDX3": 7.0},
    "pressure_stiffness": {"PPY1": 0.45, "PPX1": -0.35},
    "pressure_friction": {"PPY3": -0.16, "PPX3": -0.14},
    "combined_Gxa": {"RBX1": 11.0, "RBX2": 8.0, "RCX1": 1.08},
    "combined_Gyk": {"RBY1": 12.0, "RBY2": 8.0, "RCY1": 1.06},
    "plysteer": {"PHY1": 0.003},
    "conicity": {"PVY1": 0.02},
    "speed_friction": {"VMU1": -0.08},
    "residual_torque_Mzr": {"QDZ6": 0.006, "QDZ7": 0.003},
    "trail_load": {"QDZ2": -0.02, "QBZ2": -1.8},
    "Mz_from_Fx": {"SSZ1": 0.015, "SSZ2": 0.02},
}
#: Effects of either sign, and coefficients that the strength of a case does not multiply.
EITHER_SIGN = ("plysteer", "conicity", "curvature_asym", "temp_stiffness")
UNSCALED = ("PKY2", "RBX1", "RBX2", "RCX1", "RBY1", "RBY2", "RCY1")


@dataclass(frozen=True)
class Specimen:
    """A tire: nominal values in SI units, and coefficients by the names of the book, adapted SAE."""

    load: float
    radius: float
    pressure: float
    speed: float
    values: Mapping[str, float]

    @property
    def nominal(self) -> dict[str, float]:
        """The nominal values as options of the diagnosis."""
        return {"Fz0": self.load, "R0": self.radius, "p0": self.pressure, "V0": self.speed}


def specimen(rng: np.random.Generator, kind: str, effects: Collection[str], strengths: Mapping[str, float]) -> Specimen:
    """Return a tire of a class with effects in the form of the book.

    Parameters
    ----------
    rng : numpy.random.Generator
    kind : str
        A name of `CLASSES`.
    effects : collection of str
        Names of `BOOK_SIZES`.
    strengths : mapping of str to float
        By effect: factor on typical coefficients; 1 where absent.
    """

    def about(value: float, spread: float) -> float:
        return float(value * (1.0 + spread * rng.uniform(-1.0, 1.0)))

    load, radius, pressure, speed, friction, stiffness = CLASSES[kind]
    values = {
        "PCX1": about(1.58, 0.08), "PDX1": about(1.06 * friction, 0.12), "PEX1": about(-0.3, 1.5),
        "PKX1": about(1.1 * stiffness, 0.2), "PCY1": about(1.38, 0.08), "PDY1": about(friction, 0.12),
        "PEY1": about(-0.6, 0.9), "PKY1": about(stiffness, 0.2), "QBZ1": about(8.5, 0.2), "QCZ1": about(1.13, 0.05),
        "QDZ1": about(0.11, 0.25),
    }  # fmt: skip
    for effect in effects:
        sign = rng.choice([-1.0, 1.0]) if effect in EITHER_SIGN else 1.0
        for name, size in BOOK_SIZES[effect].items():
            factor = 1.0 if name in UNSCALED else strengths.get(effect, 1.0)
            values[name] = about(size, 0.15) * factor * float(sign)
    return Specimen(about(load, 0.1), about(radius, 0.05), pressure, speed, values)
