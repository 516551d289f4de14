"""The memory suite: effects with memory in other forms, programs that confound them, and recordings without memory.

The odd numbers of each kind are the confirmation half: nobody looks at them to change the diagnosis.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
import pandas as pd

from ..case import Case
from .formulas import Effect, FloatArray, forces
from .kinds import REVERSED, in_signs, library_tire
from .memory_laws import ACTING, FAST_LAWS, LAWS, VARIANTS, Law, follow
from .memory_programs import memory_program
from .programs import Program
from .recording_errors import recorded
from .tires import CLASSES, Specimen, specimen

#: Effects with memory, each hidden `REPEATED` times.
SINGLES, REPEATED = (*LAWS, "relax_slip"), 4
#: Programs that cannot separate effects: program, hidden effect, other effects that may be identified first, effects
#: that must be reported as confounded, words of the separating measurement.
CONFOUNDED = (
    ("one_rate", "slip_history", "heat_friction", "heat_friction", "second rate|rate|other side"),
    ("one_rate", "slip_history", "heat_friction", "heat_friction", "second rate|rate|other side"),
    ("one_rate", "heat_friction", "slip_history", "slip_history", "second rate|constant large slip|pause"),
    ("one_rate", "heat_friction", "slip_history", "slip_history", "second rate|constant large slip|pause"),
    ("no_rest", "break_in", "wear_drift heat_friction", "wear_drift", "repeat|goes on"),
    ("no_rest", "break_in", "wear_drift heat_friction", "wear_drift", "repeat|goes on"),
)
#: Effects that require a fast recording or a slow wheel, with their program; each third recording has no effect.
FAST = (("carcass_2nd_order", "fast"), ("turn_slip", "turning"), ("", "fast"))
NUMBER_OF_CASES = {
    "single": REPEATED * len(SINGLES), "confounded": len(CONFOUNDED), "null": 12, "fast": 3 * len(FAST),
    "variant": REPEATED * len(VARIANTS),
}  # fmt: skip
#: Errors of the recording that have to be recognized, by number of a null modulo their number.
NUISANCES = ("skew", "creep", "load_error", "meaningless_T")
#: Other errors of a recording, each present in a third of the recordings.
OTHERS = ("cross_talk", "time_wave", "distance_wave", "drift", "spikes", "coarse", "noisy_inputs", "offsets")
EFFECTS = ("load_friction", "load_stiffness", "combined_Gxa", "combined_Gyk", "camber_thrust")
#: Repetitions of the sliding power, which depends on the friction that it changes.
REPETITIONS = 4


def case_of(kind: str, number: int) -> Case:
    """Return a case.

    Parameters
    ----------
    kind : str
        Key of `NUMBER_OF_CASES`.
    number : int
        From 0, without a limit.
    """
    rng = np.random.default_rng([3, list(NUMBER_OF_CASES).index(kind), number])
    hidden, layout = "", "varied"
    if kind == "single":
        hidden = SINGLES[number % len(SINGLES)]
    elif kind == "confounded":
        layout, hidden, *_ = CONFOUNDED[number % len(CONFOUNDED)]
    elif kind == "fast":
        hidden, layout = FAST[number % len(FAST)]
    elif kind == "variant":
        hidden = list(VARIANTS)[number // 2 % len(VARIANTS)]  # both are in each half
    elif number % 3 == 2:
        layout = "one_rate"
    errors = [name for name in OTHERS if rng.uniform() < 0.33]
    nuisances = {NUISANCES[number % len(NUISANCES)]} | {name for name in NUISANCES if rng.uniform() < 0.3}
    noise, signs = float(rng.choice([0.6, 1.0, 1.5])), str(rng.choice(list(REVERSED)))
    tire = specimen(rng, str(rng.choice(list(CLASSES))), EFFECTS, {})
    size = float(rng.choice([0.8, 1.0, 1.4]))
    bench = memory_program(rng, tire, layout)
    trial = memory_program(rng, tire, layout if kind == "fast" else "varied", test=True)
    laws = LAWS | FAST_LAWS | (VARIANTS if kind == "variant" else {})
    internal, test = (pd.concat([one.inputs, _answer(tire, hidden, size, one, laws)], axis=1) for one in (bench, trial))
    internal = _with_temperature(rng, internal, tire, meaningless="meaningless_T" in nuisances)
    errors += ["skew"] * ("skew" in nuisances)
    table = recorded(rng, internal, bench.every, tire, noise, errors)
    table = _with_nuisances(rng, table, tire, nuisances)
    hide = ["distance"] if "meaningless_T" in nuisances else ["distance", "T"]
    truth, test = (one.iloc[:: bench.every].reset_index(drop=True) for one in (internal, test))
    if layout != "varied":
        hide = [*hide, "kappa", "Fx"]
    table, truth = (one.drop(columns=hide) for one in (table, truth))
    test = test.drop(columns="distance")
    if hidden == "turn_slip":
        test["phit"] = -np.gradient(test["alpha"], test["t"]) / test["V"]
    if layout != "varied":
        test = test.drop(columns="Fx").assign(kappa=0.0)
        straight = _answer(tire, hidden, size, Program(trial.inputs.assign(kappa=0.0), trial.every), laws)
        for name in ("Fy", "Mz"):
            test[name] = straight[name].to_numpy()[:: bench.every]
    name = f"{hidden or 'nothing'} {layout} {signs} noise {noise:g} x{size:g} {' '.join(sorted({*errors, *nuisances}))}"
    return Case(
        name, (hidden,) if hidden else (), EFFECTS, tire.nominal,
        *(in_signs(one, signs) for one in (table, truth, test, test)),
        lambda: library_tire(tire, EFFECTS), frozenset(), signs,
    )  # fmt: skip


def _answer(tire: Specimen, hidden: str, size: float, bench: Program, laws: Mapping[str, Law]) -> pd.DataFrame:
    """Return the true forces of a program."""
    x: dict[str, FloatArray] = {name: bench.inputs[name].to_numpy() for name in bench.inputs}
    if hidden in ACTING:
        return pd.DataFrame(forces(tire, {**x, "alpha": ACTING[hidden](size, tire, x)}))
    force = forces(tire, x)
    for _ in range(REPETITIONS if hidden else 0):
        changes = laws[hidden](size, tire, x, force)
        acting: list[Effect] = [lambda tire, x, changes=changes: changes]  # type: ignore[misc]
        force = forces(tire, x, acting)
    return pd.DataFrame(force)


def _with_temperature(
    rng: np.random.Generator, table: pd.DataFrame, tire: Specimen, *, meaningless: bool
) -> pd.DataFrame:
    """Return a table with a temperature: of a sensor that sees the laboratory, or one that is not recorded."""
    t = table["t"].to_numpy()
    wandering = np.cumsum(rng.standard_normal(len(t))) / np.sqrt(len(t))
    return table.assign(T=30.0 + 6.0 * wandering + 5.0 * np.sin(2.0 * np.pi * t / 70.0) * meaningless)


def _with_nuisances(rng: np.random.Generator, table: pd.DataFrame, tire: Specimen, nuisances: set[str]) -> pd.DataFrame:
    """Return a recording whose zeros creep and whose load follows the set point with an error of the controller."""
    t = table["t"].to_numpy()
    if "creep" in nuisances:
        for name in ("Fx", "Fy", "Mz"):
            size = float(np.quantile(np.abs(table[name]), 0.99))
            creep = rng.choice([-1.0, 1.0]) * (1.0 - np.exp(-(t - t[0]) / rng.uniform(8.0, 40.0)))
            table[name] = table[name] + 0.012 * size * creep
    if "load_error" in nuisances:
        turning = np.gradient(np.abs(table["alpha"].to_numpy()), t)
        error = follow(t, np.tanh(turning / 0.1), np.full(len(t), 2.0))
        table["Fz"] = table["Fz"] * (1.0 + 0.004 * rng.choice([-1.0, 1.0]) * error)
    return table
