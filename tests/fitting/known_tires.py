"""Complete tires with plausible values of all coefficients of Fx, Fy and Mz, and their recordings on a virtual bench.

Made up for this purpose, in the size of a Formula SAE tire: loads of 400 to 2,800 N, 70 to 97 kPa.
"""

from __future__ import annotations

from math import radians

import numpy as np

from tirefmu.measurements import (
    ChannelNoise,
    Noise,
    Program,
    Recording,
    VirtualBench,
    alpha_sweeps,
    concatenate,
    kappa_sweeps,
)
from tirefmu.symbolic.models import MODELS
from tirefmu.tires import Tire

#: In adapted SAE; a model uses the coefficients that it has.
VALUES = {
    "FNOMIN": 1500.0, "UNLOADED_RADIUS": 0.25, "NOMPRES": 8.3e4, "INFLPRES": 8.3e4, "LONGVL": 11.0,
    "PCX1": 1.55, "PDX1": 1.4, "PDX2": -0.14, "PDX3": 3.0, "PEX1": -0.2, "PEX2": 0.3, "PEX3": -0.1, "PEX4": 0.1,
    "PKX1": 28.0, "PKX2": 3.0, "PKX3": 0.15, "PHX1": 0.0015, "PHX2": -0.0008, "PVX1": 0.02, "PVX2": 0.008,
    "PPX1": -0.4, "PPX2": 0.6, "PPX3": -0.2, "PPX4": -0.4,
    "RBX1": 13.0, "RBX2": 10.0, "RBX3": 60.0, "RCX1": 1.05, "REX1": -0.4, "REX2": -0.15, "RHX1": 0.003,
    "PCY1": 1.4, "PDY1": 1.45, "PDY2": -0.18, "PDY3": 3.5, "PEY1": -0.4, "PEY2": -0.25, "PEY3": 0.12, "PEY4": 2.0,
    "PEY5": -15.0, "PKY1": 38.0, "PKY2": 1.7, "PKY3": 0.6, "PKY4": 1.7, "PKY5": 5.0, "PKY6": 1.4, "PKY7": 0.3,
    "PHY1": 0.0025, "PHY2": 0.0008, "PHY3": 0.03, "PVY1": 0.02, "PVY2": 0.01, "PVY3": 0.3, "PVY4": -0.15,
    "PPY1": -0.3, "PPY2": 0.5, "PPY3": -0.25, "PPY4": -0.4, "PPY5": 0.5,
    "RBY1": 11.0, "RBY2": 8.0, "RBY3": 0.012, "RBY4": 50.0, "RCY1": 1.04, "REY1": -0.3, "REY2": -0.1,
    "RHY1": 0.008, "RHY2": 0.003, "RVY1": 0.03, "RVY2": 0.012, "RVY3": 0.3, "RVY4": 12.0, "RVY5": 1.7, "RVY6": 12.0,
    "QBZ1": 8.0, "QBZ2": -1.2, "QBZ3": -0.3, "QBZ4": 1.0, "QBZ5": -1.5, "QBZ9": 12.0, "QBZ10": 0.3, "QCZ1": 1.2,
    "QDZ1": 0.11, "QDZ2": -0.015, "QDZ3": 0.3, "QDZ4": -4.0, "QDZ6": 0.004, "QDZ7": 0.0015, "QDZ8": 0.25,
    "QDZ9": 0.08, "QDZ10": 0.5, "QDZ11": -0.4, "QEZ1": -1.3, "QEZ2": 0.5, "QEZ3": -0.2, "QEZ4": 0.25, "QEZ5": -2.0,
    "QHZ1": 0.004, "QHZ2": 0.002, "QHZ3": 0.06, "QHZ4": 0.03, "PPZ1": 0.4, "PPZ2": -0.3,
    "SSZ1": 0.02, "SSZ2": 0.015, "SSZ3": 0.15, "SSZ4": 0.06,
}  # fmt: skip
#: Values of coefficients that have another meaning in a model.
EXCEPTIONS = {"mf96": {"PKY3": 0.1, "QBZ5": -0.15}}
NOMINAL = {"Fz0": VALUES["FNOMIN"], "R0": VALUES["UNLOADED_RADIUS"], "p0": VALUES["NOMPRES"], "V0": VALUES["LONGVL"]}
#: Nominal values.
NAMED = ("FNOMIN", "UNLOADED_RADIUS", "NOMPRES", "INFLPRES", "LONGVL")
CHANNELS = ("Fx", "Fy", "Mz")
#: The bench's noise in each, N and N m.
SIZES = {"Fx": 30.0, "Fy": 30.0, "Mz": 2.0}
LOADS = (400.0, 900.0, 1400.0, 2100.0, 2800.0)
PRESSURES = (7.0e4, 8.3e4, 9.7e4)


def known_tire(model: str) -> Tire:
    """Return the tire of a model, in adapted SAE."""
    values = {**VALUES, **EXCEPTIONS.get(model, {})}
    own = {name: value for name, value in values.items() if name in MODELS[model].coefficients}
    return Tire(model, own, signs="adapted-sae", name=f"known {model}")


def program(rows: int) -> Program:
    """Return sweeps of slip angle and of slip at all loads, inclinations and pressures, with about `rows` rows."""
    cambers = [radians(angle) for angle in (-2.0, 0.0, 4.0)]
    angles = [radians(angle) for angle in (0.0, -3.0, 6.0)]

    def at(rate: float) -> Program:
        parts = []
        for pressure in PRESSURES:
            held = {"p": pressure, "V": VALUES["LONGVL"]}
            parts.append(alpha_sweeps(LOADS, cambers, sample_rate=rate, held=held))
            parts.append(kappa_sweeps(LOADS[::2], angles, cambers, sample_rate=rate, held=held))
        return concatenate(parts, name="known tires")

    return at(100.0 * rows / len(at(100.0)))


def noise(level: float = 1.0, correlation_time: float = 0.0) -> Noise:
    """Return noise of the outputs with the size of a typical bench; correlation time in s."""
    return Noise({name: ChannelNoise(constant=level * size) for name, size in SIZES.items()}, correlation_time)


def recorded(tire: Tire, rows: int, *, seed: int = 0, level: float = 1.0, correlation_time: float = 0.0) -> Recording:
    """Return a recording of Fx, Fy and Mz; the duration of the program depends on the number of rows at 100 Hz."""
    bench = VirtualBench(tire, noise(level, correlation_time), seed)
    recording = bench.run(program(rows))
    table = recording.table.drop(columns=[name for name in ("Mx", "My") if name in recording.table])
    return Recording(table, recording.signs, recording.source, recording.about)


def moved(tire: Tire, share: float, seed: int) -> Tire:
    """Return the tire with every coefficient of the forces multiplied by up to 1 +- share, within its bounds."""
    rng = np.random.default_rng(seed)
    values = dict(tire.values)
    for name in (n for n in VALUES if n not in NAMED and n in tire.symbolic_model.coefficients):
        declaration = tire.symbolic_model.coefficients[name]
        values[name] = min(max(values[name] * rng.uniform(1 - share, 1 + share), declaration.lower), declaration.upper)
    return Tire(tire.model, values, effects=tire.has, signs=tire.signs)
