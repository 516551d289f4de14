"""The recordings of a seed: 24 of tires, 6 of other systems, in random order, with their truth."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from typing import Any

import numpy as np

from .bench import NOISE, heavy, recorded
from .draws import Draws, FloatArray
from .effects import DECOYS, NAMES, UNKNOWN, true_forces
from .formula import CHANNELS, OF_TRAIL, Tire, drawn_tire
from .programs import bench_program, other_maneuvers
from .systems import SYSTEMS

Table = Mapping[str, FloatArray]

#: Recordings of tires by kind.
TIRES = {"single": 10, "double": 2, "unknown": 4, "null": 8}
#: Digits behind the point that are written: more would differ with the processor.
DECIMALS = {"t": 4, "kappa": 6, "alpha": 6, "gamma": 6, "Fz": 2, "p": 0, "V": 4, "T": 3, "phit": 6, "Fx": 2, "Fy": 2,
            "Mz": 4}  # fmt: skip
OTHER_DECIMALS = 6


@dataclass(frozen=True)
class Truth:
    """What is hidden in a recording.

    - `kind`: single, double, unknown or null. `hidden`: names of candidates. `variables`: of an unknown effect.
    - `forces`: on the other maneuvers, without noise; `reference`: the same of the baseline model, fitted to the
      recording without noise. `noise`: standard deviation by channel.
    """

    kind: str
    hidden: tuple[str, ...]
    variables: tuple[str, ...]
    forces: Table
    reference: Callable[[], Table]
    noise: Mapping[str, float]


@dataclass(frozen=True)
class Made:
    """A recording: its name, what an entry knows of it, its tables, and the truth."""

    name: str
    about: Mapping[str, Any]
    recording: Table
    other: Table
    truth: Truth


def made(seed: int) -> Iterator[Made]:
    """Yield the recordings of a seed, an integer from 0."""
    names = Draws(seed, 0).shuffled(NAMES)
    unknown = Draws(seed, 1).shuffled(list(UNKNOWN))
    hidden: list[tuple[str, ...]] = [(name,) for name in names[: TIRES["single"]]]
    hidden += [(names[-2 * i - 1], names[-2 * i - 2]) for i in range(TIRES["double"])]
    hidden += [(name,) for name in unknown[: TIRES["unknown"]]] + [()] * TIRES["null"]
    for number, effects in enumerate(Draws(seed, 2).shuffled(hidden), 1):
        yield _tire(f"tire_{number:02}", Draws(seed, 3, number), effects)
    draws = Draws(seed, 4)
    lacking = draws.shuffled(["UNKNOWN", "", ""])
    cases = [(name, draws.choice(list(system.effects))) for name, system in SYSTEMS.items()]
    cases += zip(SYSTEMS, lacking, strict=True)
    for number, (name, effect) in enumerate(draws.shuffled(cases), 1):
        yield _system(f"system_{number:02}", Draws(seed, 5, number), name, effect)


def _tire(name: str, draws: Draws, effects: tuple[str, ...]) -> Made:
    tire, turning = drawn_tire(draws, effects), "turn_slip" in effects or draws.chance(0.3)
    hidden = {effect: draws.between(0.8, 1.4) for effect in effects}
    inputs = rounded(bench_program(draws, tire, turning))
    other = rounded(other_maneuvers(draws, tire, turning))
    clean = true_forces(tire, inputs, hidden)
    recording, noise = recorded(draws, inputs, clean, tire.radius)
    variables = next((UNKNOWN[effect][0] for effect in effects if effect in UNKNOWN), ())
    named = tuple(effect for effect in effects if effect not in UNKNOWN)
    kind = "unknown" if variables else ("null", "single", "double")[len(named)]
    about = {
        "case": name, "system": "tire", "inputs": list(inputs), "channels": list(CHANNELS), "base": list(tire.base),
        "candidates": sorted((*NAMES, *DECOYS)),
        "nominal": {"Fz0": tire.load, "R0": tire.radius, "p0": tire.pressure, "V0": tire.speed},
    }  # fmt: skip

    @cache
    def reference() -> Table:
        return _fitted(tire, inputs, clean, noise).forces(other)

    truth = Truth(kind, named, variables, true_forces(tire, other, hidden), reference, noise)
    return Made(name, about, rounded(recording), other, truth)


def _fitted(tire: Tire, inputs: Table, clean: Table, noise: Mapping[str, float]) -> Tire:
    """Return the baseline model fitted to forces without noise: Fx and Fy, then Mz."""
    of_forces = [name for name in tire.values if name not in OF_TRAIL]
    for names, channels in ((of_forces, ("Fx", "Fy")), (OF_TRAIL, ("Mz",))):

        def model(values: FloatArray, tire: Tire = tire, names: Sequence[str] = names) -> Table:
            return tire.with_values(names, values).forces(inputs)

        start = np.array([tire.values[name] for name in names])
        tire = tire.with_values(names, fitted_vector(start, model, clean, {name: noise[name] for name in channels}))
    return tire


def _system(name: str, draws: Draws, which: str, effect: str) -> Made:
    system = SYSTEMS[which]
    hidden = {effect: draws.between(0.15, 0.4)} if effect else {}
    values = np.array([draws.between(*range_) for range_ in system.values])
    inputs, other = (rounded(system.program(draws, flag)) for flag in (False, True))
    clean = system.outputs(values, inputs, hidden)
    noise = {channel: NOISE * float(np.std(output)) for channel, output in clean.items()}
    outputs = {channel: output + noise[channel] * heavy(draws, len(output)) for channel, output in clean.items()}

    @cache
    def reference() -> Table:
        fitted = fitted_vector(values, lambda vector: system.outputs(vector, inputs, {}), clean, noise)
        return system.outputs(fitted, other, {})

    about = {
        "case": name, "system": which, "inputs": dict(system.inputs), "channels": dict(system.channels),
        "base": {channel: list(columns) for channel, columns in system.base.items()},
        "candidates": {candidate: text for candidate, (text, _) in system.effects.items()},
    }  # fmt: skip
    variables = system.unknown[0] if effect == "UNKNOWN" else ()
    kind = "unknown" if variables else "single" if effect else "null"
    truth = Truth(kind, (effect,) if kind == "single" else (), variables,
                  system.outputs(values, other, hidden), reference, noise)  # fmt: skip
    return Made(name, about, rounded({**inputs, **outputs}), other, truth)


def fitted_vector(
    start: FloatArray, model: Callable[[FloatArray], Table], measured: Table, noise: Mapping[str, float]
) -> FloatArray:
    """Return the coefficients with the least sum of squares over noise, by Gauss-Newton steps from a start."""

    def residual(vector: FloatArray) -> FloatArray:
        computed = model(vector)
        return np.concatenate([(measured[name] - computed[name]) / noise[name] for name in noise])

    vector, now = start, residual(start)
    for _ in range(20):
        steps = 1e-6 * np.maximum(np.abs(vector), 1e-3)
        jacobian = np.stack([(residual(vector + moved) - now) / np.sum(moved) for moved in np.diag(steps)], axis=1)
        change = -np.linalg.lstsq(jacobian * steps, now, rcond=1e-10)[0] * steps
        trials = [(residual(vector + share * change), share) for share in (1.0, 0.3, 0.1, 0.03)]
        best, share = min(trials, key=lambda trial: float(trial[0] @ trial[0]))
        if not best @ best < (1.0 - 1e-9) * (now @ now):
            break
        vector, now = vector + share * change, best
    return vector


def rounded(table: Table) -> dict[str, FloatArray]:
    """Return a table with the digits that are written."""
    return {name: np.round(values, DECIMALS.get(name, OTHER_DECIMALS)) + 0.0 for name, values in table.items()}
