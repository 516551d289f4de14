"""Columns that cannot be what they claim to be in any unit: constant, copied, missing, or without signs."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import combinations

import numpy as np

from ....symbolic.channels import CHANNELS
from ...recording import Recording
from ...thresholds import (
    FAR_SLIP,
    FEW_ROWS,
    LIGHT_LOAD,
    MIN_RESPONSE,
    MIN_SIGN_SHARE,
    MIN_SWEPT,
    SMALL_SLIP,
    SPIKE_QUANTILE,
    SWEPT_RESPONSE,
)

#: The slip that each output follows.
_SLIPS = {"Fy": "alpha", "Mz": "alpha", "Fx": "kappa"}
#: Channels that must have different numbers.
_APART = ("alpha", "gamma", "Fz", "Fx", "Fy", "Mz", "Mx", "My")


def defects(recording: Recording) -> Iterator[str]:
    """Yield a sentence for each constant output of a sweep, each copied column, and a missing side force.

    `recording`: in any signs.
    """
    yield from _constant(recording)
    yield from _copies(recording)
    yield from _missing_side_force(recording)


def _constant(recording: Recording) -> Iterator[str]:
    if len(recording) and "Fz" in recording.table and not recording.table["Fz"].any():
        yield "Fz is 0 in every row: it was not measured: name its column (--columns Fz=NAME)"
    for name, slip in _SLIPS.items():
        if name not in recording.table or not _varies(recording, slip):
            continue
        measured = recording.table[name].dropna().to_numpy(dtype=np.float64)
        if len(measured) > 1 and np.ptp(measured) == 0.0:
            yield (
                f"{name} is {measured[0]:.4g} in every row although {slip} is swept: it was not measured: name its "
                f"column (--columns {name}=NAME), or read the table without {name} (--columns {name}=none)"
            )


def unmoved_slips(recording: Recording) -> Iterator[str]:
    """Yield a sentence for each slip that is absent or constant although its force changes as in a sweep."""
    table = recording.table
    for force, slip, other in (("Fy", "alpha", "kappa"), ("Fx", "kappa", "alpha")):
        if force not in table or "Fz" not in table or (slip in table and table[slip].nunique() > 1):
            continue
        load = table["Fz"].abs().to_numpy(dtype=np.float64)
        rows = load > LIGHT_LOAD * load.max(initial=0.0)
        if slip == "alpha" and other in table:
            rows &= np.abs(table[other].to_numpy(dtype=np.float64)) <= SMALL_SLIP
        ratio = table[force].to_numpy(dtype=np.float64)[rows] / load[rows]
        ratio = ratio[np.isfinite(ratio)]
        if (
            len(ratio) > FEW_ROWS
            and np.ptp(np.quantile(ratio, [SPIKE_QUANTILE, 1.0 - SPIKE_QUANTILE])) > SWEPT_RESPONSE
        ):
            state = "is constant" if slip in table else "is missing"
            yield (
                f"{slip} {state} although {force} changes from {ratio.min():.2g} to {ratio.max():.2g} times the load: "
                f"name its column (--columns {slip}=NAME), or read the table without {force} (--columns {force}=none)"
            )


def _copies(recording: Recording) -> Iterator[str]:
    present = [name for name in _APART if name in recording.table]
    for first, second in combinations(present, 2):
        values, other = (recording.table[name].to_numpy(dtype=np.float64) for name in (first, second))
        if CHANNELS[first].quantity != CHANNELS[second].quantity or recording.table[first].nunique() < 2:
            continue
        if np.array_equal(np.abs(values), np.abs(other), equal_nan=True):
            yield (
                f"{first} and {second} have the same numbers: one of them is a copy: name its column "
                f"(--columns {second}=NAME), or read the table without {second} (--columns {second}=none)"
            )


def _missing_side_force(recording: Recording) -> Iterator[str]:
    """Yield a sentence if the slip angle is swept at free rolling and no side force was measured.

    A fit of the other outputs would be a tire with an invented side force. A recording at some held slip angles is a
    measurement of Fx.
    """
    table = recording.table
    if "Fy" in table and table["Fy"].notna().any():
        return
    from ...operating_conditions.levels import levels  # loaded here: it needs SciPy, which an evaluation does not load

    measured = any(name in table and table[name].notna().any() for name in ("Fx", "Mz", "Mx"))
    if measured and _varies(recording, "alpha") and not levels(table["alpha"]):
        yield (
            "no column Fy although alpha is swept: a fit would invent the side force: name its column "
            "(--columns Fy=NAME), or read the table without alpha (--columns alpha=none)"
        )


def lost_signs(recording: Recording) -> Iterator[str]:
    """Yield a sentence for each force with one sign at both ends of its slip, or with both signs at the only end.

    At large slip a tire pulls against it, whatever its asymmetry is.
    """
    table = recording.table
    for force, slip, other in (("Fy", "alpha", "kappa"), ("Fx", "kappa", "alpha")):
        if not {force, slip, "Fz"} <= set(table) or not _varies(recording, slip):
            continue
        along, load = (table[name].to_numpy(dtype=np.float64) for name in (slip, "Fz"))
        rows = table[force].notna().to_numpy() & (np.abs(load) > LIGHT_LOAD * np.abs(load).max())
        if other in table:
            rows &= np.abs(table[other].to_numpy(dtype=np.float64)) <= SMALL_SLIP
        along, ratio = along[rows], table[force].to_numpy(dtype=np.float64)[rows] / np.abs(load[rows])
        far = FAR_SLIP * np.abs(along).max(initial=0.0)
        ends = [end for end in (ratio[along <= -far], ratio[along >= far]) if len(end) > FEW_ROWS]
        quantiles = [np.quantile(end, [MIN_SIGN_SHARE, 0.5, 1.0 - MIN_SIGN_SHARE]) for end in ends]
        middles = [middle for _, middle, _ in quantiles]
        if len(ends) == 2 and (min(middles) > MIN_RESPONSE or max(middles) < -MIN_RESPONSE):
            name, fact = force, f"{force} has the same sign at both ends of {slip}: it seems to lack its sign"
        elif len(ends) == 1 and quantiles[0][0] < -MIN_RESPONSE and quantiles[0][2] > MIN_RESPONSE:
            name = slip
            fact = f"{force} has both signs at the same end of {slip}: {slip} lacks its sign, or is another column"
        else:
            continue
        yield (
            f"{fact}: name its column (--columns {name}=NAME), or read the table without {force} "
            f"(--columns {force}=none)"
        )


def _varies(recording: Recording, slip: str) -> bool:
    """Return whether a slip varies while the other one is small."""
    if slip not in recording.table:
        return False
    rows = np.ones(len(recording), dtype=np.bool_)
    other = "kappa" if slip == "alpha" else "alpha"
    if other in recording.table:
        rows = np.abs(recording.table[other].to_numpy(dtype=np.float64)) <= SMALL_SLIP
    values = recording.table[slip].to_numpy(dtype=np.float64)[rows]
    return len(values) > 2 and float(np.ptp(np.quantile(values, [SPIKE_QUANTILE, 1.0 - SPIKE_QUANTILE]))) > MIN_SWEPT
