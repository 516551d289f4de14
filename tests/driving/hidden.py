"""Tires with an effect that the tire of the file lacks, by laws of this program, and drives that excite it."""

from __future__ import annotations

import numpy as np
import road


class Tires:
    """Four tires of each of n drives, each with one effect or none; their states advance with the drives.

    `kinds`: n of `KINDS`, or ''. `size`, `scale`, shape (n,): of the effects, and their time constants or lengths.
    """

    def __init__(self, kinds, size, scale):
        self.of = {kind: np.array([name == kind for name in kinds]) for kind in KINDS}
        self.hot = self.of["hot friction"] | self.of["hot stiffness"]
        self.size, self.scale = size, scale
        self.slip, self.turned, self.heat, self.work, self.distance = np.zeros((5, 4, len(size)))

    def __call__(self, kappa, alpha, Fz, V, factors):
        """Return Fx and Fy in W axes."""
        acting = np.where(self.of["relaxation"], np.arctan(self.slip), alpha)
        friction, stiffness = np.ones_like(alpha), np.ones_like(alpha)
        for kind, values in (
            ("hot friction", 1.0 / (1.0 + self.size * self.heat)),
            ("speed", 1.0 - self.size * np.log(np.maximum(V, 1.0) / 15.0)),
            ("new tread", 1.0 + self.size * np.exp(-self.work / self.scale)),
            ("wear", 1.0 - self.size * np.minimum(self.distance, 2000.0) / 1000.0),
        ):
            friction = np.where(self.of[kind], values, friction)
        stiffness = np.where(self.of["hot stiffness"], 1.0 / (1.0 + self.size * self.heat), stiffness)
        changed = {
            **factors, "LMUX": factors["LMUX"] * friction, "LMUY": factors["LMUY"] * friction,
            "LKY": factors["LKY"] * stiffness,
        }  # fmt: skip
        Fx, Fy = road.tire_forces(kappa, acting, Fz, V, changed)
        self.wanted, self.V = np.tan(alpha), V
        self.power = (np.abs(Fy * self.wanted) + np.abs(Fx * kappa)) * V / road.TIRE["FNOMIN"]
        return Fx, Fy - np.where(self.of["hysteresis"], self.size * Fz * self.turned, 0.0)

    def advance(self, step):
        """Advance the states by a step, s, with the last inputs."""
        lag = np.exp(-step * self.V / np.where(self.of["relaxation"], self.scale, 1e-6))
        last, self.slip = self.slip, self.wanted + (self.slip - self.wanted) * lag
        self.heat = self.power + (self.heat - self.power) * np.exp(-step / np.where(self.hot, self.scale, 1.0))
        self.work, self.distance = self.work + step * self.power, self.distance + step * self.V
        change = self.slip - last
        end = np.sign(change)
        self.turned = end + (self.turned - end) * np.exp(-np.abs(change) / self.scale)


#: Effect of the library that is to be named, range of its size and of its scale, by kind. A kind that the tires of the
#: program always have lacks in the file.
KINDS = {
    "relaxation": ("relax_lat", (1.0, 1.0), (0.3, 0.7)),
    "hot friction": ("heat_friction", (0.1, 0.25), (3.0, 12.0)),
    "hot stiffness": ("heat_stiffness", (0.2, 0.4), (3.0, 12.0)),
    "speed": ("speed_friction", (0.15, 0.35), (1.0, 1.0)),
    "load friction": ("load_friction", (0.0, 0.0), (1.0, 1.0)),
    "load stiffness": ("load_stiffness", (0.0, 0.0), (1.0, 1.0)),
    "braking": ("combined_Gyk", (0.0, 0.0), (1.0, 1.0)),
    "new tread": ("break_in", (0.08, 0.15), (3.0, 10.0)),
    "wear": ("wear_drift", (0.1, 0.25), (1.0, 1.0)),
    "hysteresis": ("hysteresis_force", (0.02, 0.05), (0.01, 0.03)),
}


def file_tire(kind):
    """Return the tire of the file, which lacks the effect of a kind."""
    from dataclasses import replace

    full = road.file_tire()
    lacks = KINDS[kind][0] if kind else ""
    values = {"load_friction": {"PDY2": 0.0}}.get(lacks, {})
    return replace(full, effects=full.has - {lacks}).with_values(**values)


def demands(t, rng, friction):
    """Return the steering wheel angle (rad) and the wanted speed (m/s): turns and changes of lane, braking in turns."""
    a, b, phase = rng.uniform(0.8, 1.2, 3)
    speed = 15.0 + 3.5 * np.sin(2 * np.pi * t / (13.0 * a) + 6.0 * phase) + 0.5 * np.sin(2 * np.pi * t / (4.1 * b))
    turn = np.tanh(3.0 * np.sin(2 * np.pi * t / (9.0 * b))) + 0.4 * np.sin(2 * np.pi * t / (2.3 * a))
    size = 0.48 + 0.24 * np.sin(2 * np.pi * t / (21.0 * phase))
    wanted = road.G * np.minimum(friction, 1.0) * size * turn
    return road.CAR["ratio"] * wanted * (road.CAR["wheelbase"] / speed**2 + 0.001), speed


def made(kinds, seed, seconds):
    """Return the logs of drives, each with the effect of a kind ('' for none), and their motion."""
    rng = np.random.default_rng(seed)
    t, n = road.STEP * np.arange(round(seconds / road.STEP)), len(kinds)
    truths = [road.drawn_truth(rng) for _ in range(n)]
    for truth in truths:  # a car that does not spin
        for name in ("LMUY", "LKY"):
            truth.factors["rear"][name] = truth.factors["front"][name] * rng.uniform(1.08, 1.2)
    friction = np.array([min(truth.factors[axle]["LMUY"] for axle in ("front", "rear")) for truth in truths])
    wanted = [demands(t, rng, mu) for mu in friction]
    steer, speed = (np.stack([pair[i] for pair in wanted], axis=1) for i in (0, 1))
    ranges = [KINDS[kind] if kind else ("", (1.0, 1.0), (1.0, 1.0)) for kind in kinds]
    size, scale = (np.array([rng.uniform(*entry[i]) for entry in ranges]) for i in (1, 2))
    rows = road.Road(truths, Tires(kinds, size, scale)).run(steer, speed)
    return road.logs(rows, steer, truths, rng), rows, truths, np.stack([size, scale])
