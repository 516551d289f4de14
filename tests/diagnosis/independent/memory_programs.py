"""Bench programs for effects with memory: sweeps at several rates, holds, rests, load steps and random steering.

The test manoeuvres have other sweep rates, and rests.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence

import numpy as np
import pandas as pd

from .formulas import FloatArray
from .programs import Program, smooth
from .tires import Specimen

#: Internal rate, Hz, and slip angle of sweeps, rad.
RATE, ANGLE = 100, 0.2
Part = Mapping[str, FloatArray]


def _part(n: int, **given: FloatArray) -> Part:
    return {"alpha": np.zeros(n), "kappa": np.zeros(n), "Fz": np.ones(n), **given}


def _time(seconds: float) -> FloatArray:
    return np.arange(max(8, round(seconds * RATE))) / RATE


def _sweep(degrees_per_second: float, side: float, angle: float = ANGLE) -> Part:
    """From zero to one side, to the other, and back."""
    period = 4.0 * np.degrees(angle) / degrees_per_second
    phase = _time(period) / period
    return _part(len(phase), alpha=side * angle * (1.0 - 4.0 * np.abs((phase + 0.25) % 1.0 - 0.5)))


def _rest(seconds: float) -> Part:
    return _part(len(_time(seconds)))


def _hold(seconds: float, alpha: float) -> Part:
    """A ramp to a slip angle within 0.3 s, which is held."""
    t = _time(seconds)
    return _part(len(t), alpha=alpha * np.minimum(1.0, np.minimum(t, t[-1] - t) / 0.3))


def _loads(seconds: float, alpha: float, frequency: float) -> Part:
    """Load waves and a step at a constant slip angle."""
    t = _time(seconds)
    wave = 1.0 + 0.35 * np.sin(2.0 * np.pi * frequency * t) + 0.3 * (t > 0.6 * seconds)
    return _part(len(t), Fz=wave, alpha=alpha * np.minimum(1.0, t / 0.3))


def _steering(rng: np.random.Generator, seconds: float) -> Part:
    t = _time(seconds)
    frequency, phase = rng.uniform(0.2, 2.0, 6), rng.uniform(0.0, 2.0 * np.pi, 6)
    sines = np.sin(2.0 * np.pi * np.outer(t, frequency) + phase).sum(axis=1) / np.sqrt(3.0)
    return _part(len(t), alpha=np.clip(0.07 * sines, -ANGLE, ANGLE))


def _braking(seconds: float) -> Part:
    phase = np.arange(round(seconds * RATE)) / (seconds * RATE)
    return _part(len(phase), kappa=0.13 * np.sin(2.0 * np.pi * phase))


def _varied(rng: np.random.Generator, parts: int, rates: Sequence[float]) -> list[Part]:
    """Return parts of all kinds in random order: what separates the effects with memory from one another."""
    makers: list[Callable[[], Part]] = [
        lambda: _sweep(float(rng.choice(rates)), float(rng.choice([-1.0, 1.0])), ANGLE * float(rng.choice([1.0, 0.6]))),
        lambda: _hold(float(rng.uniform(2.0, 4.0)), float(rng.choice([-0.14, -0.08, 0.08, 0.14]))),
        lambda: _rest(float(rng.uniform(2.0, 6.0))),
        lambda: _loads(3.0, float(rng.choice([-0.1, -0.05, 0.05, 0.1])), float(rng.uniform(0.6, 2.0))),
        lambda: _steering(rng, 4.0),
        lambda: _braking(3.0),
    ]
    chosen = rng.choice(len(makers), parts, p=[0.32, 0.12, 0.1, 0.2, 0.1, 0.16])
    return [_sweep(rates[0], 1.0), *(makers[i]() for i in chosen)]


def _steps(rng: np.random.Generator, seconds: float) -> Part:
    """Steps of the slip angle that the bench follows within 40 ms."""
    n = len(_time(seconds))
    levels = rng.uniform(-0.1, 0.1, int(seconds / 0.5) + 1)
    levels[0] = 0.0
    return _part(n, alpha=np.repeat(levels, round(0.5 * RATE))[:n])


def _quick_steering(rng: np.random.Generator, seconds: float) -> Part:
    t = _time(seconds)
    frequency, phase = rng.uniform(0.5, 9.0, 8), rng.uniform(0.0, 2.0 * np.pi, 8)
    return _part(len(t), alpha=0.03 * np.sin(2.0 * np.pi * np.outer(t, frequency) + phase).sum(axis=1))


def _fast(rng: np.random.Generator, parts: int) -> list[Part]:
    makers = (
        lambda: _steps(rng, 4.0),
        lambda: _quick_steering(rng, 4.0),
        lambda: _sweep(float(rng.choice((10.0, 30.0))), float(rng.choice([-1.0, 1.0]))),
    )
    return [makers[i % 3]() for i in range(parts)]


def _turning(rng: np.random.Generator, parts: int) -> list[Part]:
    makers = (
        lambda: _sweep(float(rng.choice((10.0, 40.0, 80.0))), float(rng.choice([-1.0, 1.0]))),
        lambda: _steering(rng, 4.0),
        lambda: _sweep(float(rng.choice((6.0, 80.0))), float(rng.choice([-1.0, 1.0]))),
    )
    return [makers[i % 3]() for i in range(parts)]


def memory_program(rng: np.random.Generator, tire: Specimen, kind: str, *, test: bool = False) -> Program:
    """Return a program.

    Parameters
    ----------
    rng : numpy.random.Generator
    tire : Specimen
    kind : str
        "varied"; "fast": steps and quick steering; "turning": quick sweeps of a slow wheel;
        "one_rate": sweeps that all begin on the same side, at one rate and one speed, without rests;
        "no_rest": sweeps and steering that begin at once, without rests.
    test : bool
        Whether it is a test manoeuvre: other sweep rates, and rests.
    """
    if kind in ("fast", "turning"):
        parts = _fast(rng, 12 if test else 24) if kind == "fast" else _turning(rng, 16 if test else 36)
    elif test:
        parts = _varied(rng, 14, (5.0, 16.0, 28.0))
    elif kind == "one_rate":
        parts = [_sweep(8.0, 1.0) for _ in range(14)]
    elif kind == "no_rest":
        parts = [_sweep(12.0, float(rng.choice([-1.0, 1.0]))) if k % 3 else _steering(rng, 4.0) for k in range(18)]
    else:
        parts = _varied(rng, 26, (4.0, 10.0, 24.0))
    columns: dict[str, list[FloatArray]] = {}
    order = rng.permutation(len(parts))
    loads = (0.45, 0.7, 1.0, 1.3, 1.55)
    for k, part in enumerate(parts):
        n = len(part["alpha"])
        levels = {
            "Fz": part["Fz"] * tire.load * loads[order[k] % len(loads)],
            "p": np.full(n, tire.pressure),
            "V": np.full(n, tire.speed * _speed(rng, kind)),
            "gamma": np.full(n, float(rng.choice([0.0, 0.0, 0.035, -0.035]))),
        }
        for name, values in {**part, **levels}.items():
            columns.setdefault(name, []).append(values)
    table = pd.DataFrame({name: np.concatenate(values) for name, values in columns.items()})
    for name in table:
        table[name] = smooth(table[name].to_numpy(), 4.0 if name in ("alpha", "kappa") else 12.0)
    if kind != "varied":
        table["kappa"] = 0.0
    table.insert(0, "t", np.arange(len(table)) / RATE)
    table["distance"] = np.concatenate([[0.0], np.cumsum(table["V"].to_numpy()[1:] / RATE)])
    return Program(table, 1 if kind in ("fast", "turning") else 2)


def _speed(rng: np.random.Generator, kind: str) -> float:
    """Return the speed of a part as a share of the tire's own."""
    if kind == "turning":
        return float(rng.choice([0.08, 0.12, 0.2]))
    return float(rng.choice([1.0, 1.0, 0.6, 1.5])) if kind in ("varied", "fast") else 1.0
