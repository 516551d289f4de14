"""What an engineer reads from the curves of each load: largest friction, its slip, and pneumatic trail.

Each is read from the measured rows without a tire, and in the same way from the tire at the same rows.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field
from math import hypot, nan

import numpy as np

from ...measurements.checks.recordings.coverage import PEAK_SHARE
from ...numerics.arrays import IntArray
from ...numerics.correlation import correlation_length
from ...numerics.slip_slope import SLOPE_WINDOW
from ...numerics.ties import graded
from .coverage import reaches
from .residuals import Residuals
from .slip_stiffness import FORCES, Compared, ReadStiffness, read_stiffnesses

#: Most parts of the range of a slip in which forces are averaged, the fewest rows of a part, and of these parts.
PARTS, MIN_ROWS, MIN_PARTS = 25, 3, 8
#: Parts over which a curve is averaged before its peak is read.
AVERAGED = 3


@dataclass(frozen=True)
class Characteristic(Compared):
    """A quantity of the curves at one load, read from the data and from the tire.

    - `quantity`: "peak friction", "peak slip" or "trail".
    - `load`: N; `at`: levels of the operating condition.
    - `read`, `fitted`: of the measured rows, and of the tire at the same rows.
    - `error`: standard error of `read`.
    - `reached`: share of the peak that the data reach at this load. A peak friction below `PEAK_SHARE` is no reading:
      it is the largest measured one over this share, and its error is the part that was not reached.
    """

    recording: str
    channel: str
    quantity: str
    unit: str
    load: float
    read: float
    fitted: float
    error: float = nan
    at: dict[str, float] = field(default_factory=dict)
    reached: float = 1.0

    @property
    def shown(self) -> bool:
        """Whether the data show it; otherwise it is an estimate of what is beyond them."""
        return self.reached >= PEAK_SHARE


@dataclass(frozen=True)
class _Peak:
    """Largest friction and its slip on one side of a curve; the slip is NaN if the data end before a peak."""

    friction: float
    slip: float
    fitted_friction: float
    fitted_slip: float
    friction_error: float
    slip_error: float


def characteristics(residuals: Residuals) -> tuple[Characteristic, ...]:
    """Return largest friction, its slip, and trail of each recording at each load; empty without such rows."""
    results: list[Characteristic] = []
    for number, source in enumerate(residuals.sources):
        for slip, channel in FORCES.items():
            if channel in residuals.channels and slip in residuals.table:
                results += _peaks(residuals, number, source, slip, channel)
    return (*results, *_trails(residuals))


def _peaks(residuals: Residuals, number: int, source: str, slip: str, channel: str) -> Iterator[Characteristic]:
    """Yield friction and slip at the peak of a force in each operating condition, averaged over signs of the slip."""
    table, other = residuals.table, "kappa" if slip == "alpha" else "alpha"
    pure = (residuals.recording == number) & np.isfinite(residuals.measured_minus_computed[channel])
    if other in table:
        pure &= np.abs(table[other].to_numpy(dtype=float)) < 0.25 * SLOPE_WINDOW[other]
    slips = table[slip].to_numpy(dtype=float)
    ends = reaches(residuals, slip, channel)
    for condition in np.unique(residuals.condition[pure]):
        here = pure & (residuals.condition == condition)
        sides = [np.flatnonzero(here & (side * slips > 0.0)) for side in (-1.0, 1.0)]
        peaks = [peak for peak in (_peak(residuals, rows, slip, channel) for rows in sides) if peak]
        if not peaks:
            continue
        load, at = float(table["Fz"].to_numpy()[here].mean()), residuals.at(int(condition))
        reached = min(ends, key=lambda reach: abs(reach.load - load)).share if ends else 1.0
        read, fitted, error = (
            float(np.mean([getattr(peak, name) for peak in peaks]))
            for name in ("friction", "fitted_friction", "friction_error")
        )
        if reached < PEAK_SHARE:
            read, fitted = read / reached, fitted / reached
            error = hypot(error / reached, (1.0 - reached) * read)
        yield Characteristic(source, channel, "peak friction", "1", load, read, fitted, error, at, reached)
        inside = [peak for peak in peaks if np.isfinite(peak.slip) and reached >= PEAK_SHARE]
        if inside:
            read, fitted, error = (
                float(np.mean([getattr(peak, name) for peak in inside]))
                for name in ("slip", "fitted_slip", "slip_error")
            )
            unit = "rad" if slip == "alpha" else "1"
            yield Characteristic(source, channel, "peak slip", unit, load, read, fitted, error, at)


def _peak(residuals: Residuals, rows: IntArray, slip: str, channel: str) -> _Peak | None:
    """Return the peak of the friction in rows of one condition and one sign of the slip; None if there are too few."""
    if len(rows) < 2 * MIN_ROWS * MIN_PARTS:
        return None
    table = residuals.table
    slips, load = (np.abs(table[name].to_numpy(dtype=float)[rows]) for name in (slip, "Fz"))
    measured, computed = table[channel].to_numpy(dtype=float)[rows], residuals.computed[channel][rows]
    if not (load > 0.0).all():
        return None
    parts = min(PARTS, len(rows) // (2 * MIN_ROWS))
    part = np.minimum((slips / slips.max() * parts).astype(np.int64), parts - 1)
    count = np.bincount(part, minlength=parts)
    filled = count >= MIN_ROWS
    if filled.sum() < MIN_PARTS:
        return None
    means = [np.bincount(part, values / load, parts)[filled] / count[filled] for values in (measured, computed)]
    at = (np.bincount(part, slips, parts)[filled] / count[filled])[1:-1]
    sign = np.sign(means[0][-MIN_PARTS:].mean())
    curve, fitted = (sign * np.convolve(mean, np.ones(AVERAGED) / AVERAGED, "valid") for mean in means)
    peak, fitted_peak = int(graded(curve).argmax()), int(graded(fitted).argmax())
    scatter = (measured - computed) / load
    mean = np.bincount(part, scatter, parts) / np.maximum(count, 1)
    scatter = scatter - mean[part]
    length = correlation_length(scatter, residuals.segment[rows])
    rows_at_peak = float(count[filled][peak : peak + AVERAGED].sum())
    error = float(np.std(scatter)) * float(np.sqrt(length / rows_at_peak))
    flat = at[curve >= curve[peak] - 2.0 * error]
    width = float(slips.max()) / parts
    slip_error = 0.5 * float(max(at[peak] - flat[0], flat[-1] - at[peak]) + width)
    read_slip = nan if peak == len(curve) - 1 else float(at[peak])
    numbers = (curve[peak], read_slip, fitted[fitted_peak], at[fitted_peak], error, slip_error)
    return _Peak(*(float(number) for number in numbers))


def _trails(residuals: Residuals) -> Iterator[Characteristic]:
    """Yield the pneumatic trail at zero slip at each load: the slope of Mz over the slope of Fy."""
    slopes = read_stiffnesses(residuals, (("alpha", "Fy"), ("alpha", "Mz")))
    by_load = {channel: [stiffness for stiffness in slopes if stiffness.channel == channel] for channel in ("Fy", "Mz")}

    def fitted(slope: ReadStiffness) -> float:
        return float(slope.influence @ residuals.computed[slope.channel][slope.rows])

    for moment in by_load["Mz"]:
        for force in by_load["Fy"]:
            if force.recording == moment.recording and abs(force.load / moment.load - 1.0) < 0.02:
                read, computed = abs(moment.value / force.value), abs(fitted(moment) / fitted(force))
                error = read * hypot(moment.error / moment.value, force.error / force.value)
                source = residuals.sources[moment.recording]
                at = {"Fz": moment.load}
                yield Characteristic(source, "Mz", "trail", "m", moment.load, read, computed, error, at)
