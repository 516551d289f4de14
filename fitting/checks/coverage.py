"""What the fitted rows determine of the tire: peaks, slip stiffness, trail, combined slip, load, camber, pressure."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from math import degrees

import numpy as np

from ...measurements.checks.recordings.coverage import (
    PEAK_SHARE,
    SMALL_SHARE,
    ChannelCoverage,
    flatness,
    lacking_peak,
    share_of_peak,
)
from ...numerics.arrays import BoolArray, FloatArray
from ...numerics.slip_slope import SLOPE_WINDOW
from ...tires.code import fastest_code
from .residuals import Residuals
from .slip_stiffness import FORCES

#: Rows that a slip has to be reached by: a single one may be an outlier.
REACHED_BY = 6
#: Points of a curve from zero to the end of the data.
POINTS = 41
#: Parts of a range of loads without levels.
PARTS = 3
#: Slip, rad or 1, and inclination, rad, that count as zero.
NO_SLIP, NO_INCLINATION = 0.02, 0.01
#: Share of the largest slip of a force that its rows at a load have to reach to be a sweep; ratio of the slip angles of
#: pure and combined slip from which the former is beyond the latter.
SWEPT, LARGER = 0.25, 1.2
#: What is not measured of an absent output.
ABSENT = {"Mz": "neither moment nor pneumatic trail was measured"}
#: Range of load and of pressure, as a share of the largest value, that counts as none.
ONE_LOAD, ONE_PRESSURE = 0.1, 0.03
#: Ranges below them are the scatter of one load, as a share of it, and of one inclination, rad.
SAME_LOAD, SAME_INCLINATION = 0.025, 0.002


@dataclass(frozen=True)
class Reach:
    """How far the data of a force reach at one load.

    - `flat`: the smallest slope within the data, relative to that at zero slip.
    - `share`, `smallest`: largest and smallest share of the peak.
    """

    load: float
    flat: float
    share: float
    smallest: float


def reaches(residuals: Residuals, slip: str, channel: str) -> list[Reach]:
    """Return how far the rows of a force reach at each load, in pure slip where there is any."""
    table = residuals.table
    if channel not in residuals.channels or slip not in table:
        return []
    rows = _pure(residuals, slip, channel)
    load = table["Fz"].to_numpy(dtype=float)
    levels = np.array(residuals.levels.get("Fz", ()))
    if not levels.size:
        levels = np.unique(np.quantile(load[rows], (np.arange(PARTS) + 0.5) / PARTS))
    nearest = np.abs(load[:, None] - levels).argmin(axis=1)
    size = np.abs(table[slip].to_numpy(dtype=float))
    rows = rows & np.isin(nearest, np.unique(nearest[rows & (size >= SWEPT * size[rows].max(initial=0.0))]))
    parts = [_reach(residuals, np.asarray(rows & (nearest == k)), slip, channel) for k in range(len(levels))]
    return [reach for reach in parts if reach]


def coverage(residuals: Residuals) -> tuple[ChannelCoverage, ...]:
    """Return whether the fitted rows determine each characteristic of the tire."""
    entries: list[ChannelCoverage] = []
    for slip, channel in FORCES.items():
        entries += _of_force(residuals, slip, channel)
    for channel in residuals.channels:
        entries += _influences(residuals, channel)
    absent = [output for output in residuals.tire.outputs if output not in residuals.channels]
    return (*entries, *(ChannelCoverage("", output, False, ABSENT.get(output, "not measured")) for output in absent))


def _of_force(residuals: Residuals, slip: str, channel: str) -> Iterator[ChannelCoverage]:
    """Yield peak friction, slip stiffness and combined slip of a force that was fitted."""
    by_load = reaches(residuals, slip, channel)
    if not by_load:
        return
    furthest, smallest = max(by_load, key=lambda reach: reach.share), min(reach.smallest for reach in by_load)
    share = furthest.share
    reason = lacking_peak(channel, share, furthest.flat)
    short = [reach for reach in by_load if reach.share < PEAK_SHARE]
    if not reason and short:
        loads = ", ".join(f"{reach.load:.0f} N ({reach.share:.0%})" for reach in short)
        reason = f"the data do not reach it at {loads}"
    yield ChannelCoverage("peak friction", channel, share >= PEAK_SHARE, reason, share)
    small = smallest <= SMALL_SHARE
    reason = "" if small else f"{channel} has {smallest:.0%} of its peak at the smallest slips"
    yield ChannelCoverage("slip stiffness", channel, small, reason, smallest)
    reason = _one_side(residuals, slip, channel)
    yield ChannelCoverage("other side", channel, not reason, reason)
    if {"kappa", "alpha"} <= set(residuals.tire.inputs):
        sizes = [np.abs(residuals.table[name].to_numpy(dtype=float)) for name in ("kappa", "alpha")]
        both = (sizes[0] > NO_SLIP) & (sizes[1] > NO_SLIP) & residuals.table[channel].notna().to_numpy()
        combined = int(both.sum()) >= REACHED_BY
        reason = _beyond_combined(residuals, both) if combined else "no rows have kappa and alpha"
        yield ChannelCoverage("combined slip", channel, combined, reason)


def _one_side(residuals: Residuals, slip: str, channel: str) -> str:
    """Return the range of a slip if its rows reach far on one side of zero only; otherwise empty."""
    signed = np.sort(residuals.table[slip].to_numpy(dtype=float)[_pure(residuals, slip, channel)])
    reached = -signed[REACHED_BY - 1], signed[-REACHED_BY]
    if min(reached) >= SWEPT * max(reached):
        return ""
    low, high = float(signed[0]), float(signed[-1])
    if slip == "alpha":
        return f"slip angles from {degrees(low):.2g} to {degrees(high):.2g} deg only"
    return f"{slip} from {low:.2g} to {high:.2g} only"


def _beyond_combined(residuals: Residuals, rows: BoolArray) -> str:
    """Return up to which slip angle combined slip was measured, if Fy is far from its peak there; otherwise empty."""
    angles = np.sort(np.abs(residuals.table["alpha"].to_numpy(dtype=float)[rows]))
    end = float(angles[-REACHED_BY])
    pure = np.abs(residuals.table["alpha"].to_numpy(dtype=float)).max()
    if "Fy" not in residuals.channels or pure < LARGER * end:
        return ""
    slips = np.linspace(0.0, end, POINTS)
    force = _curve(residuals, rows, "alpha", "Fy", slips, {"kappa": 0.0})
    flat = flatness(slips, np.sign(force[-1] - force[0]) * (force - force[0]))
    if share_of_peak(flat) >= PEAK_SHARE:
        return ""
    return f"measured up to {degrees(end):.1f} deg of slip angle, where Fy has {share_of_peak(flat):.0%} of its peak"


def _influences(residuals: Residuals, channel: str) -> Iterator[ChannelCoverage]:
    """Yield the influences of load, camber and pressure on a channel."""
    low, high = residuals.range_of("Fz", channel)
    varied = high - low >= ONE_LOAD * high
    single = f"one load, {0.5 * (low + high):.0f} N"
    reason = single if high - low <= SAME_LOAD * high else f"loads from {low:.0f} to {high:.0f} N only"
    yield ChannelCoverage("influence of load", channel, varied, "" if varied else reason)
    if "gamma" in residuals.tire.inputs:
        low, high = residuals.range_of("gamma", channel)
        varied = high - low >= NO_INCLINATION
        single = f"one inclination, {degrees(0.5 * (low + high)) + 0.0:.2g} deg"
        several = f"inclinations from {degrees(low) + 0.0:.2g} to {degrees(high) + 0.0:.2g} deg only"
        reason = single if high - low <= SAME_INCLINATION else several
        yield ChannelCoverage("influence of camber", channel, varied, "" if varied else reason)
    if "p" in residuals.tire.inputs:
        low, high = residuals.range_of("p", channel)
        varied = high - low >= ONE_PRESSURE * high
        reason = "" if varied else f"one pressure, {0.5e-3 * (low + high):.0f} kPa"
        yield ChannelCoverage("influence of pressure", channel, varied, reason)


def _pure(residuals: Residuals, slip: str, channel: str) -> BoolArray:
    """Return the rows of a channel with zero other slip; all of its rows if there are too few."""
    measured = residuals.table[channel].notna().to_numpy()
    other = "kappa" if slip == "alpha" else "alpha"
    if other not in residuals.table:
        return np.asarray(measured)
    pure = measured & (np.abs(residuals.table[other].to_numpy(dtype=float)) < 0.25 * SLOPE_WINDOW[other])
    return np.asarray(pure if pure.sum() >= REACHED_BY else measured)


def _reach(residuals: Residuals, rows: BoolArray, slip: str, channel: str) -> Reach | None:
    """Return how far some rows reach on the side of the slip on which they reach more; None if they are too few."""
    size = np.sort(np.abs(residuals.table[slip].to_numpy(dtype=float)[rows]))
    if len(size) < 2 * REACHED_BY:
        return None
    signed = residuals.table[slip].to_numpy(dtype=float)[rows]
    sides: list[tuple[float, float, float]] = []
    for side in (-1.0, 1.0):
        reached = np.sort(side * signed[side * signed > 0.0])
        if len(reached) >= REACHED_BY and reached[-REACHED_BY] > 0.0:
            x = np.linspace(0.0, reached[-REACHED_BY], POINTS)
            force = _curve(residuals, rows, slip, channel, side * x)
            force = np.sign(force[-1] - force[0]) * (force - force[0])
            flat = flatness(x, force)
            share = share_of_peak(flat)
            least = float(np.interp(size[REACHED_BY - 1], x, force)) / max(float(force.max()), 1e-300)
            sides.append((flat, share, share * least))
    if not sides:
        return None
    load = float(np.median(residuals.table["Fz"].to_numpy(dtype=float)[rows]))
    flat, share, _ = max(sides, key=lambda side: side[1])
    return Reach(load, flat, share, max(min(least for *_, least in sides), 0.0))


def _curve(
    residuals: Residuals, rows: BoolArray, slip: str, channel: str, slips: FloatArray,
    given: Mapping[str, float] | None = None,
) -> FloatArray:  # fmt: skip
    """Return the force of the tire over a slip, the other inputs as given or at their medians in some rows."""
    tire, table = residuals.tire, residuals.table
    held = {name: float(np.median(table[name].to_numpy(dtype=float)[rows])) for name in tire.inputs}
    held |= given or {}
    points = np.array([slips if name == slip else np.full(len(slips), held[name]) for name in tire.inputs])
    forces = fastest_code(tire.symbolic_model, len(slips)).forces(tire.effective_inputs(points), tire.parameters())
    return np.asarray(forces[tire.outputs.index(channel)])
