"""Made recordings with a temperature: plain NumPy, with nodes, laws of cooling and a force of their own.

Four nodes (surface, bulk of the tread, carcass, gas). The surface loses heat by radiation and by convection with a
power of the speed; conduction to the road has the length of a contact that grows with the root of the load; the sensor
has noise and a delay. Forces are a hyperbolic tangent of the slips.
"""

from __future__ import annotations

import numpy as np
import pandas as pd

RATE, DURATION = 10.0, 300.0
STEFAN = 5.67e-8


def recording(
    seed: int, *, friction: float = 0.0, optimum: float = 60.0, noise: float = 0.3, duration: float = DURATION
) -> pd.DataFrame:
    """Return a recording of sweeps of slip at several loads and speeds.

    `friction`: curvature of the friction over the temperature of the surface about `optimum`, 1/K^2.
    """
    random = np.random.default_rng(seed)
    t = np.arange(0.0, duration, 1.0 / RATE)
    block = (t // 15.0).astype(int)
    load = random.choice([600.0, 1100.0, 1700.0, 2300.0], block[-1] + 1)[block]
    speed = random.choice([9.0, 12.0, 16.0], block[-1] + 1)[block]
    width = random.uniform(0.05, 0.16, block[-1] + 1)[block]
    lateral = random.random(block[-1] + 1)[block] < 0.6
    alpha = np.where(lateral, width * np.sin(2 * np.pi * t / 7.5), 0.0)
    kappa = np.where(lateral, 0.0, width * np.sin(2 * np.pi * t / 7.5))
    ambient, road = 295.0 + 2.0 * random.random(), 303.0 + 3.0 * random.random()
    share, capacities = random.uniform(0.4, 0.6), np.array([120.0, 500.0, 900.0, 1200.0]) * random.uniform(0.8, 1.2)
    between = np.array([150.0, 60.0, 20.0]) * random.uniform(0.8, 1.2)
    state = np.array([310.0, 308.0, 306.0, 304.0])
    surface, forces = np.empty(len(t)), np.empty((2, len(t)))
    inner = 10
    for i in range(len(t)):
        mu = (1.6 - 1.2e-4 * load[i]) * (1.0 - friction * (state[0] - 273.15 - optimum) ** 2)
        slip = np.hypot(np.tan(alpha[i]), kappa[i])
        force = mu * load[i] * np.tanh(14.0 * slip / mu)
        forces[:, i] = [force * kappa[i] / max(slip, 1e-9), -force * np.tan(alpha[i]) / max(slip, 1e-9)]
        surface[i] = state[0]
        power = abs(forces[1, i] * speed[i] * np.sin(alpha[i])) + abs(forces[0, i] * speed[i] * kappa[i])
        for _ in range(inner):
            flow = between * (state[:-1] - state[1:])
            lost = 0.4 * speed[i] ** 0.8 * (state[0] - ambient) + 0.02 * STEFAN * (state[0] ** 4 - ambient**4)
            lost += 14.0 * np.sqrt(load[i] / 1500.0) * (state[0] - road)
            rolling = np.array([0.0, 0.004, 0.008, 0.0]) * load[i] * speed[i]
            heat = np.array([share * power - lost, 0.0, -2.0 * (state[2] - ambient), 0.0]) + rolling
            heat[:-1] -= flow
            heat[1:] += flow
            state = state + heat / capacities / RATE / inner
    delayed = np.interp(t - 0.1, t, surface)
    return pd.DataFrame(
        {
            "t": t, "kappa": kappa, "alpha": alpha, "Fz": load, "V": speed, "T_ambient": ambient, "T_road": road,
            "T": delayed - 273.15 + random.normal(0.0, noise, len(t)),
            "Fx": forces[0] + random.normal(0.0, 10.0, len(t)), "Fy": forces[1] + random.normal(0.0, 10.0, len(t)),
        }
    )  # fmt: skip
