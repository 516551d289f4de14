"""Test whether recordings are of one tire: stiffness and friction of their sweeps are compared at equal loads."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import combinations, pairwise

import numpy as np
import pandas as pd

from tirefmu.measurements import Recording, levels
from tirefmu.symbolic.contract import ROLES

from .initial_values import Reading, readings

#: Largest plausible ratio of a quantity at equal load for one tire. Inflation pressure, inclination and tread
#: temperature change friction by less than a fifth and stiffness by less than a third.
MOST = {"friction_y": 1.3, "friction_x": 1.3, "stiffness_y": 1.5, "stiffness_x": 1.5}
#: Largest ratio of equal loads.
EQUAL_LOAD = 1.1
#: Largest number of parts of a file, as determined by restarts of its clock.
MOST_PARTS = 10


def tire_notes(recordings: Sequence[Recording]) -> list[str]:
    """Report sweeps at equal load that differ more than is plausible for one tire.

    Parameters
    ----------
    recordings : sequence of Recording

    Returns
    -------
    list of str
        One sentence for each such pair of recordings, or of parts of a recording between restarts of its clock, with
        the quantity that differs most.

    Examples
    --------
    >>> alpha = np.tile(np.linspace(-0.2, 0.2, 101), 2)
    >>> sweep = pd.DataFrame({"alpha": alpha, "Fz": 900.0, "Fy": -1500.0 * np.tanh(20.0 * alpha)})
    >>> other = sweep.assign(Fy=0.6 * sweep["Fy"])
    >>> tire_notes([Recording(sweep, "iso", "a.csv"), Recording(other, "iso", "b.csv")])
    ['two tires? at 900 N, mu_y is 1.66 in a.csv and 0.998 in b.csv']
    """
    parts = [part for recording in recordings for part in _parts(recording)]
    read = [(label, _read(table)) for label, table in parts] if len(parts) > 1 else []
    notes = []
    for (one, first), (other, second) in combinations(read, 2):
        found = [
            (
                max(a / b, b / a) / MOST[name],
                f"at {load:.3g} N, {ROLES[name].name} is {a:.3g} in {one} and {b:.3g} in {other}",
            )
            for name in MOST
            for load, a, b in _pairs(first.get(name), second.get(name))
            if max(a / b, b / a) > MOST[name]
        ]
        if found:
            notes.append(f"two tires? {max(found)[1]}")
    return notes


def _parts(recording: Recording) -> list[tuple[str, pd.DataFrame]]:
    """Return the parts of a recording between restarts of its clock, each with a label."""
    table = recording.with_signs("adapted-sae").table
    clock = table["t"].to_numpy(dtype=float) if "t" in table else np.zeros(len(table))
    starts = [0, *(np.flatnonzero(np.diff(clock) < 0) + 1).tolist(), len(table)]
    if not 3 <= len(starts) <= MOST_PARTS + 1:
        return [(recording.source, table)]
    return [
        (f"rows {start + 1} to {stop} of {recording.source}", table.iloc[start:stop])
        for start, stop in pairwise(starts)
    ]


def _read(table: pd.DataFrame) -> dict[str, Reading]:
    """Read the channels whose slip was swept; a few held slips do not define a curve."""
    swept = {slip: slip in table and not levels(table[slip]) for slip in ("kappa", "alpha")}
    unswept = [name for name, slip in (("Fx", "kappa"), ("Fy", "alpha")) if not swept[slip] and name in table]
    return readings(table.drop(columns=unswept))


def _pairs(one: Reading | None, other: Reading | None) -> list[tuple[float, float, float]]:
    """Return load and both values for each load at which both were read."""
    if one is None or other is None:
        return []
    return [
        (float(load), float(a), float(b))
        for load, a in zip(one.loads, one.values, strict=True)
        for near, b in zip(other.loads, other.values, strict=True)
        if max(load / near, near / load) < EQUAL_LOAD and a > 0 and b > 0
    ]
