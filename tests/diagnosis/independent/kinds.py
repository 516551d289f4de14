"""The cases of the second suite by kind; a number always gives the same recording.

Numbers beyond those of the suite give the same effects with other tires, programs and errors.
"""

from __future__ import annotations

import numpy as np
import pandas as pd

from tirefmu.tires import Tire

from ..case import Case
from .effects import EFFECTS, LAGS, MOMENTS
from .formulas import Core, FloatArray, forces
from .programs import Program, operating_range, program
from .recording_errors import ERRORS, recorded, with_columns
from .tires import CLASSES, EITHER_SIGN, Specimen, specimen
from .unknown_kinds import UNKNOWN_EFFECTS

#: Structure that is not in the library, and its variables; no variables: those that the recording lacks.
UNKNOWN = {
    "softening": frozenset({"alpha", "memory"}),
    "contact_heat": frozenset({"alpha", "V", "Fz", "memory"}),
    "lean_speed": frozenset({"gamma", "V", "Fz"}),
    "unrecorded_temperature": frozenset[str](),
}
#: Effects of the library, each the single effect of a case in another form.
SINGLES = tuple(name for name in (*EFFECTS, *MOMENTS, *LAGS) if name not in UNKNOWN)
#: Single effects in the form of the book, whose coefficients have true values.
IN_BOOK_FORM = ("camber_thrust", "load_friction", "pressure_friction", "camber_stiffness", "speed_friction", "plysteer",
                "residual_torque_Mzr", "combined_Gyk", "trail_load")  # fmt: skip
#: Effects that are hidden together.
TOGETHER = {
    "double": (("camber_thrust", "temp_friction"), ("relax_lat", "pressure_stiffness"),
               ("load_friction", "residual_torque_Mzr"), ("conicity", "combined_Gxa")),
    "triple": (("camber_thrust", "wear_drift", "trail_load"), ("relax_lat", "load_friction", "Mz_from_Fx")),
}  # fmt: skip
NUMBER_OF_CASES = {
    "single": len(SINGLES) + len(IN_BOOK_FORM), "double": 4, "triple": 2, "unknown": len(UNKNOWN), "confounded": 4,
    "null": 36, "law": len(UNKNOWN_EFFECTS),
}  # fmt: skip
#: Programs that cannot separate effects: program, hidden effect, other effects that may be identified first, effects
#: that must be reported as confounded, words of the separating measurement.
CONFOUNDED = (
    ("warming", "wear_drift", "temp_friction temp_stiffness", "temp_friction", "at the same temp|cooled"),
    ("warming", "temp_friction", "wear_drift", "wear_drift", "at the same temp|cooled"),
    ("one_sided", "plysteer", "conicity", "conicity", "both signs"),
    ("small_slip", "pressure_stiffness", "pressure_friction", "pressure_friction", "small and large slip"),
)
#: Effects of the baseline models.
USUAL = ("load_friction", "load_stiffness", "combined_Gxa", "combined_Gyk")
COMMON = ("camber_thrust", "camber_stiffness", "camber_friction", "pressure_stiffness", "pressure_friction", "plysteer",
          "conicity", "speed_friction", "residual_torque_Mzr", "trail_load", "Mz_from_Fx",
          "load_curvature")  # fmt: skip
#: Columns that some nulls lack, and the effects that the tire then has not.
MISSING = {
    "T": (), "p": ("pressure_stiffness", "pressure_friction"), "V": ("speed_friction",),
    "gamma": ("camber_thrust", "camber_stiffness", "camber_friction"), "Fx": ("Mz_from_Fx",),
    "Mz": ("residual_torque_Mzr", "trail_load", "Mz_from_Fx"),
}  # fmt: skip
#: Rates in Hz with the numbers of rows of ordinary recordings; and the extremes, by kind and number.
ORDINARY = ((20.0, 2000, 4000), (50.0, 2500, 6000), (100.0, 4000, 8000), (200.0, 6000, 9000), (10.0, 1200, 2400))
EXTREME = {
    ("null", 0): (4.0, 400), ("null", 1): (4.0, 200), ("null", 2): (200.0, 60000), ("null", 3): (10.0, 300),
    ("null", 9): (200.0, 24000), ("single", 0): (4.0, 500), ("single", 5): (200.0, 60000), ("single", 11): (4.0, 400),
    ("single", 20): (100.0, 20000), ("single", 31): (4.0, 300),
}  # fmt: skip
#: Columns of the formulas that no bench records.
NOT_RECORDED = ["distance", "sliding", "heat", "largest_slip"]
#: Columns that change sign from adapted SAE.
REVERSED = {"adapted-sae": (), "iso": ("Fy", "Mz", "My"), "sae": ("alpha", "Fz")}
#: Parts of a step in which a lag is integrated, and rows of the test manoeuvre.
PARTS, TEST_ROWS = 4, 2400


def case_of(kind: str, number: int) -> Case:
    """Return a case.

    Parameters
    ----------
    kind : str
        Key of `NUMBER_OF_CASES`.
    number : int
        From 0, without a limit.
    """
    rng = np.random.default_rng([2, list(NUMBER_OF_CASES).index(kind), number])
    errors = [name for name in ERRORS if rng.uniform() < 0.35]
    noise, signs = float(rng.choice([0.6, 1.0, 1.5])), str(rng.choice(list(REVERSED)))
    rate, least, most = ORDINARY[rng.choice(len(ORDINARY), p=[0.2, 0.3, 0.3, 0.12, 0.08])]
    rate, rows = EXTREME.get((kind, number), (rate, int(rng.integers(least, most))))
    hidden, model, unknown, layout = _chosen(kind, number % NUMBER_OF_CASES[kind])
    gone = list(MISSING)[number // 2 % len(MISSING)] if kind == "null" and number % 2 and number > 4 else ""
    base = _baseline(rng, kind, layout, hidden, gone)
    strength = 1.5 if kind == "confounded" else float(rng.choice([0.7, 1.0, 1.5])) if kind == "single" else 1.0
    tire = specimen(rng, str(rng.choice(list(CLASSES))), (*base, *model), dict.fromkeys(model, strength))
    acting = Acting(tire, (*(name for name in hidden if name not in model), unknown), strength, rng)
    bench = program(rng, tire, rate, rows, layout)
    other = "full" if layout in ("pure", "one_sided", "small_slip", "warming") else layout
    trial = program(rng, tire, rate, max(200, min(TEST_ROWS, rows)), other)
    internal, test = (pd.concat([one.inputs, acting.forces(one)], axis=1) for one in (bench, trial))
    grid = operating_range(rng, tire, bench.inputs)
    if layout == "cornering":
        grid["kappa"] = 0.0
    operating = pd.concat([grid, acting.steady(grid)], axis=1).drop(columns=NOT_RECORDED[1:], errors="ignore")
    table = recorded(rng, internal, bench.every, tire, noise, errors).drop(columns=NOT_RECORDED)
    truth, test = (one.iloc[each.rows].drop(columns=NOT_RECORDED).reset_index(drop=True)
                   for one, each in ((internal, bench), (test, trial)))  # fmt: skip
    if layout == "cornering":
        table, truth, test, operating = (one.drop(columns=["kappa", "Fx"]) for one in (table, truth, test, operating))
    table = table.drop(columns=gone, errors="ignore")
    foreign = unknown == "unrecorded_temperature" or (kind == "null" and number % 7 == 3)
    if foreign:
        table = table.rename(columns={"T": "TreadTempC"})
    if "columns" in errors:
        table = with_columns(rng, table)
    name = f"{rate:g} Hz {rows} rows {layout} {signs} noise {noise:g} x{strength:g} {' '.join(errors)}"
    name += " TreadTempC" * foreign + (f" without {gone}" if gone else "")
    return Case(
        name, hidden, base, tire.nominal,
        *(in_signs(one, signs) for one in (table, truth, test, operating)),
        lambda: library_tire(tire, (*base, *model)), frozenset(model), signs, unknown,
    )  # fmt: skip


def library_tire(tire: Specimen, effects: tuple[str, ...]) -> Tire:
    """Return the tire of the library with the same coefficients."""
    nominal = {"FNOMIN": tire.load, "UNLOADED_RADIUS": tire.radius, "NOMPRES": tire.pressure,
               "INFLPRES": tire.pressure, "LONGVL": tire.speed}  # fmt: skip
    return Tire("mf61", {**nominal, **tire.values}, effects=effects, signs="adapted-sae")


class Acting:
    """A tire with effects of another form; `core`: its forces without them."""

    def __init__(
        self, tire: Specimen, names: tuple[str, ...], strength: float, rng: np.random.Generator, core: Core = forces
    ) -> None:
        self.tire, self.core = tire, core
        acts = ["temp_friction" if name == "unrecorded_temperature" else name for name in names if name]
        sizes = {
            name: strength * rng.uniform(0.85, 1.15) * (rng.choice([-1.0, 1.0]) if name in EITHER_SIGN else 1.0)
            for name in acts
        }
        at_once = {**EFFECTS, **UNKNOWN_EFFECTS}
        self.effects = [at_once[name](size) for name, size in sizes.items() if name in at_once]
        self.moments = [(*MOMENTS[name], size) for name, size in sizes.items() if name in MOMENTS]
        self.lags = [(*LAGS[name], size) for name, size in sizes.items() if name in LAGS]

    def forces(self, bench: Program) -> pd.DataFrame:
        """Return the true forces of a program, with lagging slips."""
        table = bench.inputs
        lagging = {}
        for slip, length, size in self.lags:
            sigma = self.tire.radius * length(size, table["Fz"].to_numpy() / self.tire.load)
            demand = np.tan(table["alpha"]) if slip == "alpha" else table["kappa"]
            acting = _relaxed(table["t"].to_numpy(), demand.to_numpy(), table["V"].to_numpy() / sigma)
            lagging[slip] = np.arctan(acting) if slip == "alpha" else acting
        return self.steady(table.assign(**lagging))

    def steady(self, table: pd.DataFrame) -> pd.DataFrame:
        """Return the true forces of conditions."""
        x = {name: table[name].to_numpy() for name in table}
        force = self.core(self.tire, x, self.effects)
        for channel, law, size in self.moments:
            force[channel] = force.get(channel, 0.0) + law(size, self.tire, x, force)
        return pd.DataFrame(force)


def _relaxed(t: FloatArray, demand: FloatArray, rate: FloatArray) -> FloatArray:
    """Return a slip that follows its demand: implicit midpoint steps, with demand and rate linear between rows."""
    if len(t) < 2:
        return demand
    fine = np.linspace(t[0], t[-1], PARTS * (len(t) - 1) + 1)
    step = float(fine[1] - fine[0])
    wanted, speed = np.interp(fine, t, demand), np.interp(fine, t, rate)
    wanted, half = 0.5 * (wanted[1:] + wanted[:-1]), 0.25 * step * (speed[1:] + speed[:-1])
    state, found = float(demand[0]), [float(demand[0])]
    for target, h in zip(wanted.tolist(), half.tolist(), strict=True):
        state += 2.0 * h / (1.0 + h) * (target - state)
        found.append(state)
    return np.asarray(found[::PARTS])


def _chosen(kind: str, number: int) -> tuple[tuple[str, ...], tuple[str, ...], str, str]:
    """Return hidden effects, those of them in the form of the book, the unknown structure, and the program."""
    if kind == "single":
        one = (*SINGLES, *IN_BOOK_FORM)[number]
        model = (one,) if number >= len(SINGLES) else ()
        return (one,), model, "", "turning" if one == "turn_slip" else "full"
    if kind in ("double", "triple"):
        return TOGETHER[kind][number], (), "", "full"
    if kind == "confounded":
        layout, one, *_ = CONFOUNDED[number]
        return (one,), (), "", layout
    if kind in ("unknown", "law"):
        return (), (), tuple(UNKNOWN if kind == "unknown" else UNKNOWN_EFFECTS)[number], "full"
    return (), (), "", ("full", "full", "pure", "full", "cornering")[number % 5]


def _baseline(rng: np.random.Generator, kind: str, layout: str, hidden: tuple[str, ...], gone: str) -> tuple[str, ...]:
    """Return the effects of the baseline model.

    None is hidden or needs what was not recorded. None is confounded with a hidden effect: what the baseline model has
    is estimated together with the hidden effect, and cannot be missing.
    """
    typical = USUAL[:2] if layout in ("cornering", "pure") else USUAL
    more = [str(name) for name in rng.permutation(COMMON)][: int(rng.integers(0, 4))]
    barred = {*hidden, *MISSING.get(gone, ())}
    if kind == "confounded":
        barred |= {name for _, one, _, others, _ in CONFOUNDED if one in hidden for name in others.split()}
    if layout == "cornering":
        barred.add("Mz_from_Fx")
    return tuple(name for name in (*typical, *more) if name not in barred)


def in_signs(table: pd.DataFrame, signs: str) -> pd.DataFrame:
    """Return a table, adapted SAE, in other signs."""
    return table.assign(**{name: -table[name] for name in REVERSED[signs] if name in table})
