"""Inputs over time: the bench program of a recording, and other maneuvers within its ranges."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from .draws import Draws, FloatArray
from .formula import Tire

#: Steps of the inputs of a bench program: relative to the nominal values, and inclination (rad).
LOADS, PRESSURES, SPEEDS = (0.4, 0.7, 1.0, 1.3, 1.6), (0.8, 1.0, 1.2), (0.4, 1.0, 1.5)
INCLINATIONS, HELD_ANGLES = (0.0, 0.0, 0.035, -0.035, 0.07, -0.07), (0.0, 0.06, -0.1, 0.14, -0.18)
#: Largest slip angle (rad), longitudinal slip, and turn slip over the inverse radius.
ANGLE, SLIP, TURN = 0.2, 0.18, 0.25
#: Sweeps of a program, their duration (s), rows per second; rows of the other maneuvers.
SWEEPS, SWEEP_TIME, RATES, OTHER_ROWS = 36, 3.0, (40, 50), 1500


def bench_program(draws: Draws, tire: Tire, turning: bool) -> dict[str, FloatArray]:
    """Return sweeps of the slip angle or the longitudinal slip at steps of the other inputs."""
    rate = draws.choice(RATES)
    rows = int(SWEEP_TIME * rate)
    n = SWEEPS * rows
    t = np.arange(n) / rate
    sweep = np.sin(2.0 * np.pi * np.arange(rows) / rows)
    third = [_repeated(draws, LOADS), _repeated(draws, PRESSURES), _repeated(draws, SPEEDS),
             _repeated(draws, INCLINATIONS), _repeated(draws, HELD_ANGLES)]  # fmt: skip
    load, pressure, speed, gamma, held = (_stepped(steps, rows, rate) for steps in third)
    longitudinal = np.repeat(draws.shuffled([i % 2 > 0 for i in range(SWEEPS)]), rows)
    signs, sweeps = np.repeat(draws.uniform(-1.0, 1.0, SWEEPS), rows), np.tile(sweep, SWEEPS)
    sweeps = np.where(signs < 0.0, -sweeps, sweeps)
    alpha = np.where(longitudinal, held, ANGLE * sweeps)
    turn = TURN / tire.radius * np.tile(np.sin(np.pi * np.arange(rows) / rows) ** 2, SWEEPS)
    phit = np.where(signs * ~longitudinal > 0.2, turn, 0.0) if turning else np.zeros(n)
    return {
        "t": t, "kappa": np.where(longitudinal, SLIP * sweeps, 0.0), "alpha": alpha, "gamma": gamma,
        "Fz": tire.load * load, "p": tire.pressure * pressure, "V": tire.speed * speed, "T": _temperature(draws, t),
        "phit": phit,
    }  # fmt: skip


def other_maneuvers(draws: Draws, tire: Tire, turning: bool) -> dict[str, FloatArray]:
    """Return driving by sums of sines: all inputs change at the same time."""
    t = np.arange(OTHER_ROWS) / 50.0
    spin = TURN / tire.radius * np.maximum(_wave(draws, t, 0.1, 0.4), 0.0)
    return {
        "t": t, "kappa": SLIP * _wave(draws, t, 0.2, 1.0) ** 3, "alpha": ANGLE * _wave(draws, t, 0.1, 0.8),
        "gamma": 0.07 * _wave(draws, t, 0.05, 0.3), "Fz": tire.load * (1.0 + 0.55 * _wave(draws, t, 0.1, 0.6)),
        "p": tire.pressure * (1.0 + 0.18 * _wave(draws, t, 0.01, 0.05)),
        "V": tire.speed * (0.95 + 0.5 * _wave(draws, t, 0.02, 0.1)), "T": _temperature(draws, t),
        "phit": spin if turning else 0.0 * t,
    }  # fmt: skip


def _repeated(draws: Draws, steps: Sequence[float]) -> list[float]:
    """Return a step for each sweep: each equally often, in random order."""
    return draws.shuffled([steps[i % len(steps)] for i in range(SWEEPS)])


def _stepped(steps: Sequence[float], rows: int, rate: int) -> FloatArray:
    """Return steps over the sweeps, with ramps of 0.4 s between them."""
    times = np.arange(len(steps) * rows) / rate
    starts = np.arange(1, len(steps)) * rows / rate
    corners = np.concatenate([[0.0], np.column_stack([starts, starts + 0.4]).ravel()])
    return np.asarray(np.interp(times, corners, np.repeat(steps, 2)[:-1]))


def _temperature(draws: Draws, t: FloatArray) -> FloatArray:
    """Return the temperature of the tread: warming with pauses, so that it does not only rise."""
    return 50.0 + 14.0 * _wave(draws, t, 0.015, 0.05)


def _wave(draws: Draws, t: FloatArray, lowest: float, highest: float) -> FloatArray:
    """Return a sum of five sines between two frequencies (Hz), scaled to -1 to 1, shape (n,)."""
    frequencies, phases = draws.uniform(lowest, highest, 5), draws.uniform(0.0, 2.0 * np.pi, 5)
    wave = np.sin(2.0 * np.pi * frequencies * t[:, None] + phases).sum(axis=1)
    return np.asarray(wave / np.abs(wave).max())
