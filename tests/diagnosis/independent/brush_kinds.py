"""The cases of the brush and the TMeasy suite: no formula of the library is true, and one effect is hidden or none.

Programs, errors and effects are those of the second suite. The tire is `brush.forces` or `tmeasy.forces`, and the
baseline model has all effects of slips and load alone: it errs in form, and what it then lacks is the hidden effect.
"""

from __future__ import annotations

import numpy as np
import pandas as pd

from ..case import Case
from . import brush
from .formulas import Core
from .kinds import NOT_RECORDED, ORDINARY, REVERSED, TEST_ROWS, Acting, in_signs, library_tire
from .programs import operating_range, program
from .recording_errors import ERRORS, recorded
from .tires import CLASSES, specimen

#: Effects of the baseline models: those of slips and load, which a formula of brushes has in other forms.
EFFECTS = ("load_friction", "load_stiffness", "load_curvature", "trail_load", "curvature_asym")
IN_COMBINED_SLIP = ("combined_Gxa", "combined_Gyk", "kappa_sideforce_SVyk", "Mz_from_Fx")
#: Hidden effects.
SINGLES = (
    "temp_friction", "wear_drift", "camber_thrust", "pressure_friction", "speed_friction", "relax_lat", "plysteer",
    "temp_stiffness", "pressure_stiffness", "camber_stiffness", "relax_lon", "turn_slip", "relax_load",
    "overturning_Mx", "camber_friction", "conicity", "residual_torque_Mzr", "rolling_resistance_My",
)  # fmt: skip
NUMBER_OF_CASES = {"single": len(SINGLES), "null": 20}
#: Programs of the nulls in turn.
LAYOUTS = ("full", "pure", "full", "cornering")


def case_of(kind: str, number: int, forces: Core = brush.forces) -> Case:
    """Return a case by a key of `NUMBER_OF_CASES` and a number from 0; numbers beyond are further tires."""
    rng = np.random.default_rng([5, list(NUMBER_OF_CASES).index(kind), number])
    hidden = SINGLES[number % len(SINGLES)] if kind == "single" else ""
    layout = "turning" if hidden == "turn_slip" else "full" if hidden else LAYOUTS[number % len(LAYOUTS)]
    errors = [name for name in ERRORS if rng.uniform() < 0.35 and name != "columns"]
    noise, signs = float(rng.choice([0.6, 1.0, 1.5])), str(rng.choice(list(REVERSED)))
    rate, least, most = ORDINARY[rng.choice(len(ORDINARY), p=[0.2, 0.3, 0.3, 0.12, 0.08])]
    tire, size = specimen(rng, str(rng.choice(list(CLASSES))), (), {}), float(rng.choice([0.7, 1.0, 1.5]))
    acting = Acting(tire, (hidden,), size, rng, forces)
    bench = program(rng, tire, rate, int(rng.integers(least, most)), layout)
    trial = program(rng, tire, rate, TEST_ROWS, layout)
    internal, test = (pd.concat([one.inputs, acting.forces(one)], axis=1) for one in (bench, trial))
    grid = operating_range(rng, tire, bench.inputs)
    if layout in ("cornering", "pure"):  # without combined slip, as the recording
        grid.loc[grid.index % 2 < 2 - (layout == "pure"), "kappa"] = 0.0
        grid.loc[grid["kappa"] != 0.0, "alpha"] = 0.0
    operating = pd.concat([grid, acting.steady(grid)], axis=1)
    table = recorded(rng, internal, bench.every, tire, noise, errors)
    truth, test = (one.iloc[each.rows].reset_index(drop=True) for one, each in ((internal, bench), (test, trial)))
    absent = [*NOT_RECORDED, *(("kappa", "Fx") if layout == "cornering" else ())]
    name = f"{hidden or 'nothing'} {rate:g} Hz {layout} {signs} noise {noise:g} x{size:g} {' '.join(errors)}"
    base = EFFECTS if layout in ("cornering", "pure") else (*EFFECTS, *IN_COMBINED_SLIP)
    return Case(
        name, (hidden,) if hidden else (), base, tire.nominal,
        *(in_signs(one.drop(columns=absent, errors="ignore"), signs) for one in (table, truth, test, operating)),
        lambda: library_tire(tire, base), frozenset(), signs,
    )  # fmt: skip
