"""Jumps and the unit of the clock, mixed and assumed units, and a speed that may be in km/h."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from itertools import product

import numpy as np

from ....numerics.arrays import FloatArray, IndexArray
from ....numerics.ties import graded
from ....symbolic.channels import CHANNELS, CONTROLLED_INPUTS
from ...operating_conditions.levels import held_levels
from ...operating_conditions.phases import SLIP_INPUTS
from ...recording import Recording
from ...thresholds import (
    EQUAL_TOLERANCES,
    FAST,
    INNER_SLIP,
    LOAD_TOLERANCE,
    LOGGING_GAP,
    RATIO_TOLERANCE,
)
from ...units import PSI, to_si
from ..rows.coverage import steps_backwards
from .finding import DataFinding

#: s: a median step of a clock that no bench has, and steps that benches have.
LONGEST_CLOCK_STEP, CLOCK_STEPS = 60.0, (1e-4, 1.0)
#: Ratios of two units in which a bench writes a channel.
RATIOS: Mapping[str, Mapping[float, str]] = {
    "V": {3.6: "m/s and km/h"},
    "p": {1e3: "Pa and kPa", PSI: "Pa and psi", 1e5: "Pa and bar"},
    "Fz": {1e3: "N and kN"},
}


def clock_and_units(recording: Recording) -> Iterator[DataFinding]:
    """Yield findings on the clock, on channels in two units, assumed units, decimal commas, and a speed in km/h."""
    yield from _clock_unit(recording)
    yield from _clock_jumps(recording)
    yield from _mixed_units(recording)
    yield from _unlabelled_speed(recording)
    if (units := recording.about.get("units", "")).startswith("assumed"):
        yield DataFinding("unit", f"{recording.source}: units {units}", command="others: --units Fz=N,alpha=deg,...")
    if decimals := recording.about.get("decimals"):
        yield DataFinding("unit", f"{recording.source}: {decimals}")


def _clock_unit(recording: Recording) -> Iterator[DataFinding]:
    """Yield a finding if the steps of the clock are too long for a bench, and typical in another unit."""
    if "t" not in recording.table or "t" in recording.about.get("declared", "").split():
        return
    steps = np.diff(np.sort(recording.table["t"].to_numpy(dtype=np.float64)))  # the rows may be in another order
    step = float(np.median(steps[steps > 0.0])) if (steps > 0.0).any() else 0.0
    units = [unit for unit in ("ms", "us", "ns") if CLOCK_STEPS[0] <= step * to_si(1.0, unit) <= CLOCK_STEPS[1]]
    if step > LONGEST_CLOCK_STEP and units:
        yield DataFinding(
            "clock", f"{recording.source}: t steps by {step:.4g} s: in {' or '.join(units)}?", serious=True,
            command=f"--units t={units[0]}, or the header 't [{units[0]}]'",
        )  # fmt: skip


def _clock_jumps(recording: Recording) -> Iterator[DataFinding]:
    """Yield findings on jumps of the clock: backwards, repeated times, gaps within a sweep.

    A gap between two sweeps is not a finding: a bench may log each sweep separately.
    """
    if "t" not in recording.table or len(recording) < 2 or steps_backwards(recording):
        return  # `coverage_notes`
    steps = np.diff(recording.table["t"].to_numpy(dtype=np.float64))
    backward, repeated = np.flatnonzero(steps < 0.0), int(np.count_nonzero(steps == 0.0))
    if repeated:
        yield DataFinding("clock", f"{recording.source}: t repeats in {repeated} of {len(steps)} steps")
    if len(backward):
        yield _jump(recording, "back", steps, backward)
    forward = steps[steps > 0.0]
    gaps = np.flatnonzero(steps > LOGGING_GAP * np.median(forward)) if len(forward) else backward[:0]
    within = np.array([row for row in gaps.tolist() if _same_sweep(recording, row)], dtype=np.intp)
    if len(within):
        yield _jump(recording, "forward within a sweep", steps, within)


def _same_sweep(recording: Recording, row: int) -> bool:
    """Return whether a row and the next one have the same held inputs and the same slip, amid a sweep."""
    table = recording.table
    for name in (name for name in CONTROLLED_INPUTS if name in table and name not in SLIP_INPUTS):
        before, after = table[name].iloc[row], table[name].iloc[row + 1]
        if abs(after - before) > EQUAL_TOLERANCES * (CHANNELS[name].tolerance or LOAD_TOLERANCE * abs(before)):
            return False
    for name in (name for name in SLIP_INPUTS if name in table):
        before, after = table[name].iloc[row], table[name].iloc[row + 1]
        tolerance = CHANNELS[name].tolerance or 0.0
        # A bench starts, turns and ends a sweep at zero or at an end of its range.
        end = float(np.nanmax(table[name] * np.sign(before)))
        inner = EQUAL_TOLERANCES * tolerance < abs(before) < INNER_SLIP * end
        if inner and abs(after - before) <= tolerance:
            return True
    return False


def _jump(recording: Recording, direction: str, steps: FloatArray, at: IndexArray) -> DataFinding:
    largest = at[np.argmax(graded(np.abs(steps[at])))]
    times = "1 time" if len(at) == 1 else f"{len(at)} times"
    size = abs(float(steps[largest]))
    most = f"most by {size:.3g} s at row {largest + 2}"
    return DataFinding("clock", f"{recording.source}: t jumps {direction} {times}, {most}: each part is a segment")


def _mixed_units(recording: Recording) -> Iterator[DataFinding]:
    """Yield a finding if a held input has values in two units: levels whose ratio is that of two units."""
    for name, ratios in RATIOS.items():
        levels = np.abs(held_levels(recording.table[name])) if name in recording.table else np.empty(0)
        for (ratio, units), low, high in product(ratios.items(), levels, levels):
            if low > 0.0 and abs(high / low / ratio - 1.0) < RATIO_TOLERANCE:
                unit = CHANNELS[name].after
                yield DataFinding(
                    "unit",
                    f"{recording.source}: mixed units? {name} is {low:.4g}{unit} in some rows and {high:.4g}{unit} "
                    f"in others, the ratio of {units}",
                    serious=True,
                )


def _unlabelled_speed(recording: Recording) -> Iterator[DataFinding]:
    """Yield a finding if a speed without a declared unit is high for m/s."""
    if "V" not in recording.table or "V" in recording.about.get("declared", "").split():
        return
    speed = float(recording.table["V"].abs().median())
    if speed > FAST:
        yield DataFinding(
            "unit",
            f"{recording.source}: V is about {speed:.3g} m/s ({3.6 * speed:.3g} km/h) and declares no unit: in km/h?",
            command="declare it: 'V [km/h]' or 'V [m/s]'",
        )
