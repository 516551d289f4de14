"""Contradictions at equal operating conditions: friction of two tires, slip stiffness of two recordings."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import combinations, product
from math import degrees, sqrt

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from ..channels import CHANNELS
from ..operating_conditions.grouping import group_by_condition
from ..operating_conditions.held_levels import held_levels
from ..recording import Recording
from ..thresholds import (
    COMPARED_ANGLE,
    COMPARED_WIDTH,
    CORRELATED_ROWS,
    DIFFERENCE_ERRORS,
    EQUAL_LOAD_RATIO,
    EQUAL_TOLERANCES,
    FEW_ROWS,
    FREE_ROLLING_SLIP,
    FRICTION_QUANTILE,
    FRICTION_RATIO,
    SHIFT_DIFFERENCE,
    STIFFNESS_DIFFERENCE,
)
from .finding import Finding

#: The least relative error of a slope, for data without noise.
RELATIVE_ROUNDING = 1e-12
_FORCE = {"alpha": "Fy", "kappa": "Fx"}


@dataclass(frozen=True)
class _Sweep:
    """The largest force over load of consecutive rows at one operating condition."""

    label: str
    slip: str
    reach: float
    held: Mapping[str, float]
    friction: float


def friction_differences(recordings: Sequence[Recording]) -> Iterator[Finding]:
    """Yield a finding if sweeps at equal operating conditions differ in friction more than those of one tire.

    Parameters
    ----------
    recordings : sequence of Recording

    Yields
    ------
    Finding
        At most one, for the largest difference.
    """
    sweeps = [sweep for recording in recordings for sweep in _sweeps(recording)]
    pairs = [
        (max(one.friction, other.friction) / min(one.friction, other.friction), one, other)
        for one, other in combinations(sweeps, 2)
        if _equal(one, other)
    ]
    if not pairs:
        return
    ratio, one, other = max(pairs, key=lambda pair: pair[0])
    if ratio > FRICTION_RATIO:
        force = _FORCE[one.slip]
        yield Finding(
            "two tires",
            f"two tires? at {one.held['Fz']:.3g} N the largest |{force}|/Fz is {one.friction:.3g} in {one.label} and "
            f"{other.friction:.3g} in {other.label}",
            serious=True,
        )


def _sweeps(recording: Recording) -> Iterator[_Sweep]:
    recording = recording.with_signs("adapted-sae")
    table = recording.table
    if "Fz" not in table:
        return
    groups = group_by_condition(recording)
    segment = np.zeros(len(recording), dtype=np.intp)
    for number, piece in enumerate(recording.segments()):
        segment[piece] = number
    changes = np.flatnonzero((np.diff(groups.labels) != 0) | (np.diff(segment) != 0)) + 1
    load = table["Fz"].to_numpy(dtype=np.float64)
    for start, stop in zip([0, *changes.tolist()], [*changes.tolist(), len(recording)], strict=True):
        held, moving = dict(groups.conditions[groups.labels[start]]), groups.moving[groups.labels[start]]
        if len(moving) != 1 or moving[0] not in _FORCE or _FORCE[moving[0]] not in table or "Fz" not in held:
            continue
        force = table[_FORCE[moving[0]]].to_numpy(dtype=np.float64)[start:stop]
        known = np.isfinite(force) & (load[start:stop] > 0.0)
        if known.sum() < FEW_ROWS:
            continue
        friction = float(np.quantile(np.abs(force[known] / load[start:stop][known]), FRICTION_QUANTILE))
        reach = float(np.abs(table[moving[0]].to_numpy(dtype=np.float64)[start:stop]).max())
        if friction > 0.0:
            yield _Sweep(f"rows {start + 1} to {stop} of {recording.source}", moving[0], reach, held, friction)


def _equal(one: _Sweep, other: _Sweep) -> bool:
    """Return whether two sweeps were made at equal operating conditions and up to the same slip."""
    if one.slip != other.slip or not 1.0 / EQUAL_LOAD_RATIO < one.reach / other.reach < EQUAL_LOAD_RATIO:
        return False
    if not 1.0 / EQUAL_LOAD_RATIO < one.held["Fz"] / other.held["Fz"] < EQUAL_LOAD_RATIO:
        return False
    common = (one.held.keys() & other.held.keys()) - {"Fz"}
    return all(
        abs(one.held[name] - other.held[name]) <= EQUAL_TOLERANCES * (CHANNELS[name].tolerance or 0.0)
        for name in common
    )


def stiffness_differences(recordings: Sequence[Recording]) -> Iterator[Finding]:
    """Yield a finding for each pair of recordings whose cornering stiffness differs at equal conditions.

    The slope of Fy/Fz between two slip angles that both recordings have, at free rolling and at equal load, camber and
    pressure. It needs no tire model.

    Parameters
    ----------
    recordings : sequence of Recording

    Yields
    ------
    Finding
    """
    usable = [each for each in recordings if {"alpha", "Fz", "Fy"} <= set(each.table)]
    for one, other in combinations(usable, 2):
        first, second = (_free_rolling(each) for each in (one, other))
        angles = _common_angles(first, second)
        pairs = [
            _Pair(condition, a, b)
            for condition in _conditions(first)
            if (a := _slope(_at(first, condition), angles)) and (b := _slope(_at(second, condition), angles))
        ]
        if pairs and (text := _difference(pairs, angles)):
            yield Finding(
                "stiffness between files",
                f"{other.source} differs from {one.source} at equal conditions: {text}",
                command="fit each file alone and compare K_yalpha, or crop with --where",
            )


def _difference(pairs: Sequence[_Pair], angles: tuple[float, float]) -> str:
    """Return significant differences of stiffness and of its zero; empty without one."""
    count = len(pairs)
    mean = float(np.mean([pair.ratio for pair in pairs]))
    mean_error = sqrt(sum(pair.ratio_error**2 for pair in pairs)) / count
    worst = max(pairs, key=lambda pair: abs(pair.ratio) / pair.ratio_error)
    shift = float(np.mean([pair.shift for pair in pairs]))
    shift_error = sqrt(sum(pair.shift_error**2 for pair in pairs)) / count
    texts = []
    stiffer = (abs(mean), mean_error), (abs(worst.ratio), worst.ratio_error)
    if any(size > max(STIFFNESS_DIFFERENCE, DIFFERENCE_ERRORS * error) for size, error in stiffer):
        low, high = (degrees(angle) + 0.0 for angle in sorted(angles))
        texts.append(
            f"dFy/dalpha between {low:.2g} and {high:.2g} deg by {100 * mean:+.1f} % on average over {count} "
            f"conditions, by {100 * worst.ratio:+.1f} +- {200 * worst.ratio_error:.1f} % at {_text(worst.condition)}"
        )
    if abs(shift) > max(SHIFT_DIFFERENCE, DIFFERENCE_ERRORS * shift_error):
        texts.append(f"the zero of Fy by {degrees(shift):+.2f} deg")
    return "; ".join(texts)


def _text(condition: Mapping[str, float]) -> str:
    shown = {"Fz": (1.0, "N"), "gamma": (degrees(1.0), "deg"), "p": (1e-3, "kPa")}
    return ", ".join(f"{value * shown[name][0] + 0.0:.4g} {shown[name][1]}" for name, value in condition.items())


@dataclass(frozen=True)
class _Pair:
    """The slopes of two recordings at an equal operating condition."""

    condition: Mapping[str, float]
    one: _Slope
    other: _Slope

    @property
    def ratio(self) -> float:
        return self.other.slope / self.one.slope - 1.0

    @property
    def ratio_error(self) -> float:
        return sqrt(sum((each.error / each.slope) ** 2 for each in (self.one, self.other))) or RELATIVE_ROUNDING

    @property
    def shift(self) -> float:
        return self.other.zero - self.one.zero

    @property
    def shift_error(self) -> float:
        return sqrt(self.one.zero_error**2 + self.other.zero_error**2)


@dataclass(frozen=True)
class _Slope:
    """Slope of Fy/Fz over alpha in 1/rad, and the slip angle of zero force in rad, with standard errors."""

    slope: float
    error: float
    zero: float
    zero_error: float


def _free_rolling(recording: Recording) -> pd.DataFrame:
    table = recording.with_signs("adapted-sae").table
    rows = table["Fy"].notna() & (table["Fz"] > 0.0)
    return table[rows & (table["kappa"].abs() < FREE_ROLLING_SLIP)] if "kappa" in table else table[rows]


def _common_angles(one: pd.DataFrame, other: pd.DataFrame) -> tuple[float, float]:
    """Return two slip angles: the two smallest ones at which a recording was held, or two next to zero."""
    for table in (one, other):
        held = sorted(held_levels(table["alpha"]), key=abs)
        if len(held) > 1:
            return held[0], held[1]
    return -COMPARED_ANGLE, COMPARED_ANGLE


def _conditions(table: pd.DataFrame) -> list[dict[str, float]]:
    """Return the combinations of the levels of load, camber and pressure."""
    names = [name for name in ("Fz", "gamma", "p") if name in table and held_levels(table[name])]
    if "Fz" not in names:
        return []
    return [dict(zip(names, at, strict=True)) for at in product(*(held_levels(table[name]) for name in names))]


def _at(table: pd.DataFrame, condition: Mapping[str, float]) -> pd.DataFrame:
    rows = np.ones(len(table), dtype=np.bool_)
    for name, level in condition.items():
        width = (EQUAL_LOAD_RATIO - 1.0) * level if name == "Fz" else CHANNELS[name].tolerance or 0.0
        if name in table:
            rows &= np.abs(table[name].to_numpy(dtype=np.float64) - level) <= width
    return table[rows]


def _slope(table: pd.DataFrame, angles: tuple[float, float]) -> _Slope | None:
    """Return the slope of Fy/Fz between two slip angles, its standard error and zero; None without enough rows."""
    points = [_friction_at(table, angle) for angle in angles]
    if points[0] is None or points[1] is None:
        return None
    (y0, e0), (y1, e1) = points[0], points[1]
    slope = (y1 - y0) / (angles[1] - angles[0])
    error = sqrt(e0**2 + e1**2) / abs(angles[1] - angles[0])
    return _Slope(slope, error, angles[0] - y0 / slope, e0 / slope) if slope > DIFFERENCE_ERRORS * error else None


def _friction_at(table: pd.DataFrame, angle: float) -> tuple[float, float] | None:
    """Return Fy/Fz at a slip angle and its standard error, by a line through the rows next to it."""
    alpha = table["alpha"].to_numpy(dtype=np.float64) - angle
    near = np.abs(alpha) < COMPARED_WIDTH
    if near.sum() < 2 * CORRELATED_ROWS:
        return None
    x = alpha[near]
    y: NDArray[np.float64] = (table["Fy"] / table["Fz"]).to_numpy(dtype=np.float64)[near]
    design = np.stack([np.ones(len(x)), x]).T if np.std(x) > 0.25 * COMPARED_WIDTH else np.ones((len(x), 1))
    coefficients, *_ = np.linalg.lstsq(design, y, rcond=None)
    scatter = float(np.std(y - design @ coefficients))
    return float(coefficients[0]), scatter * sqrt(CORRELATED_ROWS / len(x))
