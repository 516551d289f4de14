"""Confounded diagnoses and the planned next measurement: how often the right effect alone is identified after it.

The tires, their hidden effects and the errors of the bench are those of `missing_effects/generator` (plain NumPy). The
first recording has few sweeps, and two of its inputs vary together, or none varies. A diagnosis of it that does not
separate the hidden effect from another one is followed by a program of 2 min on the same bench and a second diagnosis.
Run by `make confounded`.
"""

from __future__ import annotations

import argparse
from collections import Counter
from collections.abc import Mapping

import numpy as np
import pandas as pd
from missing_effects.generator.bench import recorded
from missing_effects.generator.cases import rounded
from missing_effects.generator.draws import Draws
from missing_effects.generator.effects import true_forces
from missing_effects.generator.formula import Tire, drawn_tire
from missing_effects.generator.programs import ANGLE, SLIP

from tirefmu.applications.planning.bench_file import NOISE_LOAD, Bench, Limits
from tirefmu.applications.planning.separation import pairs_in, plan_between
from tirefmu.boundary.errors import TirefmuError
from tirefmu.diagnosis import diagnose
from tirefmu.measurements import Noise

#: Hidden effects, and the inputs of which two vary together; without them all are constant.
TOGETHER: dict[str, tuple[str, ...]] = {
    "load_friction": ("Fz", "p", "V"), "pressure_friction": ("p", "Fz", "V"), "speed_friction": ("V", "p", "Fz"),
    "load_stiffness": ("Fz", "p"), "pressure_stiffness": ("p", "Fz"), "conicity": (), "plysteer": (), "relax_lat": (),
}  # fmt: skip
#: Sweeps of the first recording, their duration, s, and the deviations of inputs that vary together.
SWEEPS, SECONDS, RATE = 12, 3.0, 50
DEVIATIONS = {"Fz": 0.4, "p": 0.18, "V": 0.4}


def bench_of(tire: Tire) -> Bench:
    """Return a bench with the ranges of the generator."""
    limits = {
        "Fz": Limits(0.5 * tire.load, 1.5 * tire.load, 2.0), "alpha": Limits(-ANGLE, ANGLE, 1.0, 0.3),
        "kappa": Limits(-SLIP, SLIP, 1.0, 0.3), "gamma": Limits(-0.07, 0.07, 2.0), "V": Limits(0.5 * tire.speed,
        1.5 * tire.speed, 3.0), "p": Limits(0.8 * tire.pressure, 1.2 * tire.pressure, 10.0, levels=2),
    }  # fmt: skip
    return Bench(limits, Noise().scaled(1.5 * tire.load / NOISE_LOAD))


def first_inputs(draws: Draws, tire: Tire, effect: str) -> dict[str, np.ndarray]:
    """Return few sweeps; the input of the effect and another one vary together, between two levels."""
    inputs, rows = TOGETHER[effect], int(SECONDS * RATE)
    together = {*inputs[:1], draws.choice(inputs[1:])} if inputs else set()
    level = np.repeat(draws.shuffled([(-1.0) ** i for i in range(SWEEPS)]), rows)
    nominal = {"gamma": 0.0, "Fz": tire.load, "p": tire.pressure, "V": tire.speed}
    held = {
        name: value * (1.0 + (DEVIATIONS[name] * level if name in together else 0.0 * level))
        for name, value in nominal.items()
    }
    sweep = np.tile(np.sin(2.0 * np.pi * np.arange(rows) / rows), SWEEPS)
    longitudinal = np.repeat(draws.shuffled([i % 3 == 0 for i in range(SWEEPS)]), rows)
    slips = {"kappa": np.where(longitudinal, SLIP * sweep, 0.0), "alpha": np.where(longitudinal, 0.0, ANGLE * sweep)}
    return {"t": np.arange(len(sweep)) / RATE, **slips, **held}


def measured(draws: Draws, tire: Tire, inputs: Mapping[str, np.ndarray], hidden: Mapping[str, float]) -> pd.DataFrame:
    """Return a recording of a tire with a hidden effect."""
    n = len(inputs["t"])
    exact = rounded({**inputs, "T": np.full(n, 50.0), "phit": np.zeros(n)})
    table, _ = recorded(draws, exact, true_forces(tire, exact, hidden), tire.radius)
    return pd.DataFrame(rounded(table))


def kind_of(names: list[str], effect: str) -> str:
    """Return how names compare with the hidden effect."""
    return "right alone" if names == [effect] else "right among others" if effect in names else "wrong or none"


def outcome(seed: int) -> tuple[str, str, str] | None:
    """Return how the most probable explanation and the identified effects of the second diagnosis are, and a line.

    None if the first diagnosis separates the hidden effect from all others, or does not name it.
    """
    draws = Draws(seed, 38)
    effect = draws.choice(list(TOGETHER))
    tire = drawn_tire(draws, (effect, "load_friction", "load_stiffness"))
    hidden = {effect: draws.between(0.8, 1.4)}
    nominal = {"Fz0": tire.load, "R0": tire.radius, "p0": tire.pressure, "V0": tire.speed}
    table = measured(draws, tire, first_inputs(draws, tire, effect), hidden)
    first = diagnose(table, effects=tire.base, nominal=nominal)
    pairs = pairs_in(first.to_json(), first.base_tire.symbolic_model)
    if not any(effect in pair for pair in pairs):
        return None
    line = f"{seed}: {effect} of {', '.join(f'{a}/{b}' for a, b in pairs)}"
    try:
        program = plan_between(first.base_tire, bench_of(tire), pairs).program
    except TirefmuError as error:
        return "refused", "refused", f"{line}: {error}"
    planned = {name: program.rows[name].to_numpy(float) for name in program.rows}
    content = diagnose(measured(draws, tire, planned, hidden), effects=tire.base, nominal=nominal).to_json()
    best, names = content["explanations"][0], [finding["effect"] for finding in content["found"]]
    probable, identified = kind_of(best["effects"] + ["UNKNOWN"] * best["unknown"], effect), kind_of(names, effect)
    return probable, identified, f"{line}: {best['effects']} {best['probability']:.2f}, identified {names}"


def main() -> None:
    """Diagnose, plan, measure and diagnose again, until enough diagnoses were confounded."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--cases", type=int, default=40, help="Confounded diagnoses.")
    parser.add_argument("--first", type=int, default=0, help="The first seed.")
    arguments = parser.parse_args()
    probable, identified, seed = Counter[str](), Counter[str](), arguments.first
    while probable.total() < arguments.cases:
        if result := outcome(seed):
            probable[result[0]] += 1
            identified[result[1]] += 1
            print(f"{result[0]}; {result[2]}", flush=True)
        seed += 1
    print(f"{seed - arguments.first} recordings; most probable: {dict(probable)}; identified: {dict(identified)}")


if __name__ == "__main__":
    main()
