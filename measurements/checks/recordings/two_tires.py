"""Check whether recordings are of one tire: names, magnitude of the loads, friction at equal operating conditions."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from ....numerics.ties import graded
from ....symbolic.channels import CHANNELS
from ....tires.signs import reversed_columns
from ...operating_conditions.grouping import group_by_condition
from ...recording import Recording
from ...thresholds import (
    EQUAL_LOAD_RATIO,
    EQUAL_TOLERANCES,
    FEW_ROWS,
    FRICTION_QUANTILE,
    FRICTION_RATIO,
    LARGEST_LOAD_QUANTILE,
    LARGEST_LOAD_RATIO,
    MAX_JOINED_PARTS,
)

FORCES = {"alpha": "Fy", "kappa": "Fx"}


def two_tires(recordings: Sequence[Recording]) -> list[str]:
    """Return why recordings seem to be of several tires.

    Sentences report different names, loads of different magnitude in two recordings, and loads of different magnitude
    before and after a restart of the clock (joined files). Without these, at most one reports sweeps at equal operating
    conditions with different friction.
    """
    notes = [*_names(recordings), *_loads(recordings)]
    notes += [note for recording in recordings for note in _joined_files(recording)]
    return notes or list(_friction(recordings))


def _names(recordings: Sequence[Recording]) -> Iterator[str]:
    named = {
        recording.about["tireid"]: recording.source
        for recording in reversed(recordings)
        if recording.about.get("tireid")
    }
    if len(named) > 1:
        names = ", ".join(f"{tire!r} in {source}" for tire, source in reversed(named.items()))
        yield f"{'two' if len(named) == 2 else len(named)} tires? the tire is {names}"


def _loads(recordings: Sequence[Recording]) -> Iterator[str]:
    loads = [
        (float(recording.table["Fz"].abs().quantile(LARGEST_LOAD_QUANTILE)), recording.source)
        for recording in recordings
        if "Fz" in recording.table and len(recording)
    ]
    if loads:
        (least, light), (most, heavy) = min(loads), max(loads)
        if most > LARGEST_LOAD_RATIO * least > 0.0:
            yield f"two tires? the load reaches {least:.4g} N in {light}, {most:.4g} N in {heavy}"


def _joined_files(recording: Recording) -> Iterator[str]:
    if not {"t", "Fz"} <= {*recording.table}:
        return
    clock = recording.table["t"].to_numpy(dtype=np.float64)
    restarts = np.flatnonzero(np.diff(clock) < 0.0) + 1
    if not 1 <= len(restarts) < MAX_JOINED_PARTS:
        return
    load = recording.table["Fz"].abs().to_numpy(dtype=np.float64)
    largest = [float(np.quantile(part, LARGEST_LOAD_QUANTILE)) for part in np.split(load, restarts)]
    if max(largest) > LARGEST_LOAD_RATIO * min(largest) > 0.0:
        yield (
            f"two tires? {recording.source}: the clock restarts at row {restarts[0] + 1}, "
            f"and the loads reach {min(largest):.4g} N in one part and {max(largest):.4g} N in another"
        )


@dataclass(frozen=True)
class _Sweep:
    """The largest force over load of consecutive rows at one operating condition, in adapted SAE."""

    label: str
    slip: str
    largest_slip: float
    held: Mapping[str, float]
    friction: float


def _friction(recordings: Sequence[Recording]) -> Iterator[str]:
    """Yield a sentence on the pair of comparable sweeps whose friction differs most, if no tire has both."""
    sweeps = [sweep for recording in recordings for sweep in _sweeps(recording)]
    ordered = sorted(sweeps, key=lambda sweep: sweep.friction)
    ratio, pair = FRICTION_RATIO, None
    for low in ordered:
        for high in reversed(ordered):
            if high.friction <= ratio * low.friction:
                break
            if _comparable(low, high):
                ratio, pair = high.friction / low.friction, (low, high)
                break
    if pair is not None:
        first, second = sorted(pair, key=sweeps.index)
        yield (
            f"two tires? at {first.held['Fz']:.3g} N the largest |{FORCES[first.slip]}|/Fz is {first.friction:.3g} in "
            f"{first.label} and {second.friction:.3g} in {second.label}"
        )


def _sweeps(recording: Recording) -> Iterator[_Sweep]:
    """Yield the sweeps of a slip, each with its operating condition."""
    table = recording.table
    if "Fz" not in table:
        return
    groups, segment = group_by_condition(recording), recording.segment_numbers()
    turned = reversed_columns(recording.signs, "adapted-sae")
    load = table["Fz"].to_numpy(dtype=np.float64) * (-1.0 if "Fz" in turned else 1.0)
    changes = np.flatnonzero((np.diff(groups.labels) != 0) | (np.diff(segment) != 0)) + 1
    for rows in map(slice, [0, *changes.tolist()], [*changes.tolist(), len(recording)]):
        label = groups.labels[rows.start]
        held, moving = dict(groups.conditions[label]), groups.moving[label]
        if len(moving) != 1 or FORCES.get(moving[0]) not in table or "Fz" not in held:
            continue
        slip, force = (table[name].to_numpy(dtype=np.float64)[rows] for name in (moving[0], FORCES[moving[0]]))
        usable = np.isfinite(force) & (load[rows] > 0.0)
        if usable.sum() < FEW_ROWS:
            continue
        friction = graded(float(np.quantile(np.abs(force[usable] / load[rows][usable]), FRICTION_QUANTILE)))
        if friction > 0.0:
            held = {name: -level if name in turned else level for name, level in held.items()}
            text = f"rows {rows.start + 1} to {rows.stop} of {recording.source}"
            yield _Sweep(text, moving[0], float(np.abs(slip).max()), held, friction)


def _comparable(sweep: _Sweep, other: _Sweep) -> bool:
    """Return whether two sweeps were made at equal operating conditions and up to the same slip."""
    ratios = sweep.largest_slip / other.largest_slip, sweep.held["Fz"] / other.held["Fz"]
    if sweep.slip != other.slip or not all(1.0 / EQUAL_LOAD_RATIO < ratio < EQUAL_LOAD_RATIO for ratio in ratios):
        return False
    common = (sweep.held.keys() & other.held.keys()) - {"Fz"}
    return all(
        abs(sweep.held[name] - other.held[name]) <= EQUAL_TOLERANCES * (CHANNELS[name].tolerance or 0.0)
        for name in common
    )
