"""The tire without hidden effects: Pacejka's sine of an arctangent, in ISO-W, in plain NumPy.

H. B. Pacejka, Tire and Vehicle Dynamics (2012), section 4.3, with few coefficients; `README.md` has the equations.
Hidden effects multiply or add at named places: `FACTORS` and `TERMS`.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from .draws import Draws, FloatArray

Inputs = Mapping[str, FloatArray]
#: What an effect changes: a place and a value per row.
Changes = Mapping[str, FloatArray | float]

FACTORS = ("mu_x", "mu_y", "K_x", "K_y", "G_x", "G_y", "trail")
TERMS = ("Fx", "Fy", "Mz", "slip", "E_y")
CHANNELS = ("Fx", "Fy", "Mz")
#: Effects that a baseline model may have, and the coefficients of each. A tire and its baseline model both lack one
#: with the probability `ABSENT`, so that a baseline model without it does not show that it is hidden.
ABSENT = 0.25
BASE = {
    "load_friction": ("mu_x_load", "mu_y_load"),
    "load_stiffness": ("K_y_load",),
    "combined_Gxa": ("G_x", "G_x_kappa"),
    "combined_Gyk": ("G_y", "G_y_alpha"),
}
#: Coefficients of every tire: ranges from which they are drawn.
CORE = {
    "mu_x": (1.0, 1.7), "C_x": (1.45, 1.75), "E_x": (-0.9, 0.3), "K_x": (14.0, 32.0),
    "mu_y": (0.95, 1.6), "C_y": (1.25, 1.55), "E_y": (-1.0, 0.2), "K_y": (13.0, 26.0),
    "trail": (0.08, 0.13), "C_t": (1.0, 1.2), "B_t": (6.0, 10.0),
}  # fmt: skip
#: Coefficients of Mz, which are fitted after those of the forces.
OF_TRAIL = ("trail", "C_t", "B_t")
OF_EFFECTS = {
    "mu_x_load": (-0.15, -0.04), "mu_y_load": (-0.2, -0.06), "K_y_load": (1.5, 2.6),
    "G_x": (5.0, 11.0), "G_x_kappa": (3.0, 9.0), "G_y": (6.0, 12.0), "G_y_alpha": (3.0, 8.0),
}  # fmt: skip


@dataclass(frozen=True)
class Tire:
    """A tire: nominal load (N), radius (m), pressure (Pa), speed (m/s), baseline effects, coefficients by name."""

    load: float
    radius: float
    pressure: float
    speed: float
    base: tuple[str, ...]
    values: Mapping[str, float]

    def with_values(self, names: Sequence[str], values: FloatArray) -> Tire:
        """Return the tire with other values of some coefficients."""
        return replace(self, values={**self.values, **dict(zip(names, values.tolist(), strict=True))})

    def forces(self, x: Inputs, changes: tuple[Changes, ...] = ()) -> dict[str, FloatArray]:
        """Return Fx, Fy (N) and Mz (N m), shape (n,), with what effects change at these inputs."""
        v, ratio = self.values, x["Fz"] / self.load
        factor = {name: np.prod([c.get(name, 1.0) + 0.0 * ratio for c in changes], axis=0) for name in FACTORS}
        term = {name: np.sum([0.0 * ratio, *(c.get(name, 0.0) + 0.0 * ratio for c in changes)], axis=0)
                for name in TERMS}  # fmt: skip
        slip, kappa = np.tan(x["alpha"]), x["kappa"]
        K_x = v["K_x"] * x["Fz"] * factor["K_x"]
        K_y = v["K_y"] * self.load * self._stiffness(ratio) * factor["K_y"]
        peak_x = v["mu_x"] * (1.0 + v.get("mu_x_load", 0.0) * (ratio - 1.0)) * factor["mu_x"] * x["Fz"]
        peak_y = v["mu_y"] * (1.0 + v.get("mu_y_load", 0.0) * (ratio - 1.0)) * factor["mu_y"] * x["Fz"]
        G_x = np.cos(np.arctan(v.get("G_x", 0.0) * np.cos(np.arctan(v.get("G_x_kappa", 0.0) * kappa)) * slip))
        G_y = np.cos(np.arctan(v.get("G_y", 0.0) * np.cos(np.arctan(v.get("G_y_alpha", 0.0) * slip)) * kappa))
        Fx = curve(K_x, v["C_x"], peak_x, v["E_x"], kappa) * G_x * factor["G_x"] + term["Fx"]
        pure = -curve(K_y, v["C_y"], peak_y, v["E_y"] + term["E_y"], slip + term["slip"]) * G_y * factor["G_y"]
        turned = np.arctan(np.sqrt(np.tan(slip) ** 2 + (K_x / K_y * kappa) ** 2))
        trail = v["trail"] * self.radius * ratio * np.cos(v["C_t"] * np.arctan(v["B_t"] * turned)) * np.cos(x["alpha"])
        Fy = pure + term["Fy"]
        return {"Fx": Fx, "Fy": Fy, "Mz": -trail * factor["trail"] * pure + term["Mz"]}

    def _stiffness(self, ratio: FloatArray) -> FloatArray:
        """Return the cornering stiffness over load relative to its coefficient: linear without load_stiffness."""
        peak = self.values.get("K_y_load")
        return ratio if peak is None else np.asarray(np.sin(2.0 * np.arctan(ratio / peak)))


def curve(K: FloatArray, C: float, peak: FloatArray, E: FloatArray | float, slip: FloatArray) -> FloatArray:
    """Return the Magic Formula with slope K at zero slip."""
    argument = K / (C * peak) * slip
    return np.asarray(peak * np.sin(C * np.arctan(argument - E * (argument - np.arctan(argument)))))


def drawn_tire(draws: Draws, hidden: tuple[str, ...]) -> Tire:
    """Return a random tire whose baseline model lacks the hidden effects."""
    load, radius, pressure = draws.choice(((1100.0, 0.24, 85e3), (4200.0, 0.32, 230e3), (7500.0, 0.37, 300e3)))
    absent = [name for name in BASE if draws.chance(ABSENT)]
    base = tuple(name for name in BASE if name not in (*hidden, *absent))
    names = [*CORE, *(name for effect in base for name in BASE[effect])]
    ranges = {**CORE, **OF_EFFECTS}
    values = {name: draws.between(*ranges[name]) for name in names}
    return Tire(load, radius, pressure, draws.choice((11.0, 16.0, 22.0)), base, values)
