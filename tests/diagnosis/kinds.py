"""The benchmark cases by kind; a number always gives the same recording."""

from __future__ import annotations

import numpy as np

from .suite import ARTEFACTS, BENT, DEFAULT_EFFECTS, SIZES, UNKNOWN, Case, make_case

#: Number of cases of each kind: every effect twice, thirty recordings without a missing effect.
NUMBER_OF_CASES = {
    "single": 2 * len(SIZES),
    "bent": 10,
    "double": 6,
    "triple": 2,
    "unknown": 8,
    "confounded": 6,
    "null": 30,
}
#: Confounding programs: hidden effect, other effects that may be identified first, effects that must be reported as
#: confounded, and words of the separating measurement.
CONFOUNDED = (
    ("warming", "temp_friction", "wear_drift", "wear_drift", "at the same temp|cooled"),
    ("one_sided", "conicity", "plysteer", "plysteer", "both signs"),
    ("small_slip", "pressure_stiffness", "pressure_friction", "pressure_friction", "small and large slip"),
    (
        "warming",
        "wear_drift",
        "temp_friction temp_stiffness",
        "temp_friction temp_stiffness",
        "at the same temp|cooled",
    ),
    ("one_sided", "plysteer", "conicity", "conicity", "both signs"),
    ("small_slip", "pressure_friction", "pressure_stiffness", "pressure_stiffness", "small and large slip"),
)
#: Columns that some benches do not record, and the effects that are then not identifiable.
MISSING_COLUMNS = (("T",), ("p",), ("Fx",), ("Mz",), ("T", "V"))
EFFECTS_OF_COLUMN = {
    "T": ("temp_friction", "temp_stiffness"), "p": ("pressure_stiffness", "pressure_friction"),
    "V": ("speed_friction", "relax_lat", "relax_lon", "relax_load", "wear_drift"),
    "Fx": ("relax_lon", "combined_Gxa", "Mz_from_Fx"), "Mz": ("residual_torque_Mzr", "trail_load", "Mz_from_Fx"),
}  # fmt: skip
#: Effects that baseline models often have.
COMMON = tuple(
    name for name in SIZES
    if name not in (
        *DEFAULT_EFFECTS, "wear_drift", "relax_load", "overturning_Mx", "rolling_resistance_My", "turn_slip"
    )
)  # fmt: skip


def case_of(kind: str, i: int) -> Case:
    """Return a case.

    Parameters
    ----------
    kind : str
        Key of `NUMBER_OF_CASES`.
    i : int
        Number of the case, from 0.
    """
    rng = np.random.default_rng([list(NUMBER_OF_CASES).index(kind), i])
    seed = 1000 * (1 + list(NUMBER_OF_CASES).index(kind)) + i
    artefacts = tuple(str(name) for name in rng.choice(ARTEFACTS, rng.integers(0, 3), replace=False))
    noise, signs = float(rng.choice([0.6, 1.0, 1.5])), str(rng.choice(["adapted-sae", "iso"]))
    rate = float(rng.choice([50.0, 30.0, 100.0], p=[0.6, 0.25, 0.15]))
    known = _chosen(rng, COMMON, int(rng.integers(0, 4)))
    if kind == "null":
        gone = MISSING_COLUMNS[i // 2 % len(MISSING_COLUMNS)] if i % 2 else ()
        known = tuple(name for name in known if not any(name in EFFECTS_OF_COLUMN[column] for column in gone))
        return make_case(seed, noise=noise, extra=known, artefacts=artefacts, rate=rate, without=gone, signs=signs)
    if kind == "unknown":
        what = tuple(UNKNOWN)[i % len(UNKNOWN)]
        return make_case(seed, noise=noise, extra=known[:1], artefacts=artefacts, unknown=what, rate=rate, signs=signs)
    if kind == "confounded":
        program, hidden, *_ = CONFOUNDED[i]
        return make_case(seed, (hidden,), noise=noise, strength=1.5, kind=program, signs=signs)
    if kind in ("double", "triple"):
        hidden = _chosen(rng, (*COMMON, "combined_Gxa", "load_friction"), 2 if kind == "double" else 3)
        return make_case(seed, hidden, noise=noise, artefacts=artefacts, rate=rate, signs=signs)
    if kind == "bent":
        hidden = _chosen(rng, (*COMMON, *DEFAULT_EFFECTS), 1)
        return make_case(seed, hidden, noise=noise, artefacts=artefacts, signs=signs, bent=BENT[i % len(BENT)])
    one = list(SIZES)[i % len(SIZES)]
    known = _chosen(rng, tuple(name for name in known if name != one), 3, present=(one,))
    strength = float(rng.choice([0.7, 1.0, 1.5]))
    program = "turning" if one == "turn_slip" else "full"
    return make_case(seed, (one,), noise=noise, extra=known, artefacts=artefacts, strength=strength, rate=rate,
                     signs=signs, kind=program)  # fmt: skip


def _chosen(rng: np.random.Generator, names: tuple[str, ...], n: int, present: tuple[str, ...] = ()) -> tuple[str, ...]:
    """Return up to n names; at most one of them and of `present` is a lateral relaxation."""
    drawn = [str(name) for name in rng.permutation(names)]
    chosen: list[str] = []
    for name in drawn:
        lateral = name in ("relax_lat", "relax_load")
        if not lateral or not {"relax_lat", "relax_load"} & {*chosen, *present}:
            chosen.append(name)
    return tuple(chosen[:n])
