"""A quarter of a car on one wheel, coupled to a tire FMU with wheel inputs at a constant communication step."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

GRAVITY = 9.81
SLIPS = ("kappa_lagged", "tan_alpha_lagged")
RATES = tuple(f"der({name})" for name in SLIPS)
MOTION = ("V_x", "V_y", "omega")


@dataclass
class QuarterCar:
    """A mass on a wheel with a drive torque, a side force, a slope, and a brake that holds a wheel at rest.

    The host sets the velocities at the end of the step before it calls the FMU's step. `implicit` adds the change of
    the forces within the step, from the FMU's directional derivatives: the linearly implicit Euler method. Without it,
    the step must resolve the oscillation of the wheel's inertia on the tire's spring.
    """

    host: object
    load: float
    inertia: float
    radius: float
    implicit: bool
    slope: float = 0.0
    turning: bool = True
    V_x: float = 0.0
    V_y: float = 0.0
    omega: float = 0.0
    time: float = 0.0
    rows: list = field(default_factory=list)

    def start(self, V_x=0.0, V_y=0.0, omega=None):
        self.V_x, self.V_y, self.omega = V_x, V_y, V_x / self.radius if omega is None else omega
        self.host.initialize()
        assert self.host.set(V_x=V_x, V_y=V_y, omega=self.omega, Fz=self.load) == 0
        assert self.host.call("ExitInitializationMode") == 0
        return self

    def run(self, duration, size, drive=0.0, brake=0.0, side=0.0):
        """Simulate with constant torques, N m, and a side force, N; return time, velocities and forces by row."""
        mass, first = self.load / GRAVITY, len(self.rows)
        for _ in range(round(duration / size)):
            forces, by_motion = self._forces_at_the_end(size)
            into = np.array([[1 / mass, 0.0], [0.0, 1 / mass], [-self.radius / self.inertia, 0.0]])
            given = np.array([-GRAVITY * self.slope, side / mass, drive / self.inertia])
            system = np.eye(3) - size * into @ by_motion
            free = np.linalg.solve(system, size * (given + into @ forces))
            braked = np.linalg.solve(system, [0.0, 0.0, size / self.inertia])
            holding = -(self.omega + free[2]) / braked[2]
            change = free + np.clip(holding, -brake, brake) * braked
            self.rows.append((self.time, self.V_x, self.V_y, self.omega, *self.host.get("Fx", "Fy")))
            self.V_x, self.V_y, self.omega = np.array([self.V_x, self.V_y, self.omega]) + change
            self.host.set(V_x=self.V_x, V_y=self.V_y, omega=self.omega)
            assert self.host.step(self.time, size) == 0
            self.time += size
        return np.array(self.rows[first:]).T

    def _forces_at_the_end(self, size):
        """Return the forces at the end of a step with constant velocities, and their derivatives by the velocities."""
        self.host.set(V_x=self.V_x, V_y=self.V_y, omega=self.omega)
        forces = self.host.get("Fx", "Fy")
        if not self.implicit:
            return forces, np.zeros((2, 3))
        by_motion = self._derivatives(("Fx", "Fy", *RATES), MOTION)
        by_slips = self._derivatives(("Fx", "Fy", *RATES), SLIPS)
        carried = by_slips[:2] @ np.linalg.inv(np.eye(2) - size * by_slips[2:]) * size
        return forces + carried @ self.host.get(*RATES), by_motion[:2] + carried @ by_motion[2:]

    def _derivatives(self, unknowns, knowns):
        return np.array([self.host.derivative(unknowns, [known], [1.0])[1] for known in knowns]).T
