"""A mass on one wheel, coupled to a tire FMU with hub inputs by forces that are constant over a step."""

from __future__ import annotations

import numpy as np

GRAVITY = 9.81
FORCE = ("F_x_global", "F_y_global", "F_z_global")


class HubCar:
    """A mass that moves without turning; the wheel stands upright on a plane.

    Velocity and position at the end of a step are set before the FMU's step (the symplectic Euler method).
    """

    def __init__(self, host, mass, slope=0.0):
        self.host, self.mass = host, mass
        self.gravity = GRAVITY * np.array([-np.sin(np.arctan(slope)), 0.0, -np.cos(np.arctan(slope))])
        self.r, self.v, self.time = np.zeros(3), np.zeros(3), 0.0

    def start(self, height, velocity=(0.0, 0.0, 0.0), **values):
        self.r, self.v = np.array([0.0, 0.0, height]), np.array(velocity, dtype=float)
        self.host.start(**values, **self._moved())
        return self

    def run(self, duration, size, *names, **values):
        """Simulate; return rows of position, velocity, force and named outputs by step."""
        assert self.host.set(**values) == 0
        rows = []
        for _ in range(round(duration / size)):
            force = self.host.get(*FORCE)
            self.v = self.v + size * (force / self.mass + self.gravity)
            self.r = self.r + size * self.v
            assert self.host.set(**self._moved()) == 0
            assert self.host.step(self.time, size) == 0
            self.time += size
            rows.append([*self.r, *self.v, *force, *self.host.get(*names)])
        return np.array(rows).T

    def _moved(self):
        return dict(zip(("r_x", "r_y", "r_z", "v_x", "v_y", "v_z"), [*self.r, *self.v], strict=True))
