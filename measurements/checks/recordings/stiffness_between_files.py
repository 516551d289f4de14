"""Whether the cornering stiffness of two recordings differs at equal operating conditions.

Sweeps and tests at a few held slip angles have at most two slip angles in common. The forces at these two are compared:
this is a slope between two points, not the slope at zero slip of `tirefmu.numerics.slip_slope`, which needs a sweep.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from itertools import combinations, product
from math import degrees, sqrt
from typing import NamedTuple

import numpy as np
import pandas as pd

from ....numerics.ties import graded
from ....symbolic.channels import CHANNELS
from ...operating_conditions.levels import held_levels
from ...recording import Recording
from ...thresholds import (
    COMPARED_ANGLE,
    COMPARED_WIDTH,
    CORRELATED_ROWS,
    DIFFERENCE_ERRORS,
    EQUAL_LOAD_RATIO,
    FREE_ROLLING_SLIP,
    SHIFT_DIFFERENCE,
    STIFFNESS_DIFFERENCE,
)
from .finding import DataFinding

#: The smallest relative error of a slope, for data without noise.
RELATIVE_ROUNDING = 1e-12


def stiffness_between_files(recordings: Sequence[Recording]) -> Iterator[DataFinding]:
    """Yield a finding for each pair of recordings whose cornering stiffness differs at equal conditions.

    It compares the slope of Fy/Fz between two slip angles that both recordings have, at free rolling and at equal load,
    camber and pressure. No tire model is needed.
    """
    usable = [recording for recording in recordings if {"alpha", "Fz", "Fy"} <= set(recording.table)]
    rows = [_free_rolling(recording) for recording in usable] if len(usable) > 1 else []
    for (first, table), (second, other) in combinations(zip(usable, rows, strict=False), 2):
        angles = _common_angles(table, other)
        differences = [
            _difference(condition, a, b)
            for condition in _conditions(table)
            if (a := _line(_at(table, condition), angles)) and (b := _line(_at(other, condition), angles))
        ]
        if differences and (text := _significant(differences, angles)):
            yield DataFinding(
                "stiffness between files",
                f"{second.source} differs from {first.source} at equal conditions: {text}",
                command="fit each file alone and compare K_yalpha, or crop with --where",
            )


class _Line(NamedTuple):
    """Slope of Fy/Fz over alpha in 1/rad, and the slip angle of zero force in rad, with standard errors."""

    slope: float
    error: float
    zero: float
    zero_error: float


class _Difference(NamedTuple):
    """Relative difference of two slopes, and difference of their zeros in rad, with standard errors."""

    condition: Mapping[str, float]
    ratio: float
    ratio_error: float
    shift: float
    shift_error: float


def _difference(condition: Mapping[str, float], line: _Line, other: _Line) -> _Difference:
    ratio_error = sqrt((line.error / line.slope) ** 2 + (other.error / other.slope) ** 2)
    return _Difference(
        condition,
        other.slope / line.slope - 1.0,
        ratio_error or RELATIVE_ROUNDING,
        other.zero - line.zero,
        sqrt(line.zero_error**2 + other.zero_error**2),
    )


def _significant(differences: Sequence[_Difference], angles: tuple[float, float]) -> str:
    """Return significant differences of stiffness and of its zero; empty without one."""
    count = len(differences)
    _, ratios, ratio_errors, shifts, shift_errors = zip(*differences, strict=True)
    mean, mean_error = sum(ratios) / count, sqrt(sum(error**2 for error in ratio_errors)) / count
    shift, shift_error = sum(shifts) / count, sqrt(sum(error**2 for error in shift_errors)) / count
    worst = max(differences, key=lambda difference: graded(abs(difference.ratio) / difference.ratio_error))
    stiffer = (abs(mean), mean_error), (abs(worst.ratio), worst.ratio_error)
    texts = []
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


def _free_rolling(recording: Recording) -> pd.DataFrame:
    table = recording.with_signs("adapted-sae").table
    rows = table["Fy"].notna() & (table["Fz"] > 0.0)
    return table[rows & (table["kappa"].abs() < FREE_ROLLING_SLIP)] if "kappa" in table else table[rows]


def _common_angles(*tables: pd.DataFrame) -> tuple[float, float]:
    """Return two slip angles: the two smallest ones at which a recording was held, or two next to zero."""
    for table in tables:
        held = sorted(held_levels(table["alpha"]), key=lambda level: graded(abs(level)))
        if len(held) > 1:
            return held[0], held[1]
    return -COMPARED_ANGLE, COMPARED_ANGLE


def _conditions(table: pd.DataFrame) -> list[dict[str, float]]:
    """Return the combinations of the levels of load, camber and pressure."""
    held = {name: held_levels(table[name]) for name in ("Fz", "gamma", "p") if name in table}
    held = {name: levels for name, levels in held.items() if levels}
    return [dict(zip(held, at, strict=True)) for at in product(*held.values())] if "Fz" in held else []


def _at(table: pd.DataFrame, condition: Mapping[str, float]) -> pd.DataFrame:
    rows = np.ones(len(table), dtype=np.bool_)
    for name, level in condition.items():
        width = (EQUAL_LOAD_RATIO - 1.0) * level if name == "Fz" else CHANNELS[name].tolerance or 0.0
        if name in table:
            rows &= np.abs(table[name].to_numpy(dtype=np.float64) - level) <= width
    return table[rows]


def _line(table: pd.DataFrame, angles: tuple[float, float]) -> _Line | None:
    """Return the line of Fy/Fz through two slip angles; None without enough rows or without a significant slope."""
    points = [_friction_at(table, angle) for angle in angles]
    if points[0] is None or points[1] is None:
        return None
    (y0, e0), (y1, e1) = points[0], points[1]
    slope = (y1 - y0) / (angles[1] - angles[0])
    error = sqrt(e0**2 + e1**2) / abs(angles[1] - angles[0])
    return _Line(slope, error, angles[0] - y0 / slope, e0 / slope) if slope > DIFFERENCE_ERRORS * error else None


def _friction_at(table: pd.DataFrame, angle: float) -> tuple[float, float] | None:
    """Return Fy/Fz at a slip angle and its standard error, by a line through the rows next to it."""
    alpha = table["alpha"].to_numpy(dtype=np.float64) - angle
    near = np.abs(alpha) < COMPARED_WIDTH
    if near.sum() < 2 * CORRELATED_ROWS:
        return None
    x, y = alpha[near], (table["Fy"] / table["Fz"]).to_numpy(dtype=np.float64)[near]
    design = np.stack([np.ones(len(x)), x]).T if np.std(x) > 0.25 * COMPARED_WIDTH else np.ones((len(x), 1))
    coefficients, *_ = np.linalg.lstsq(design, y, rcond=None)
    scatter = float(np.std(y - design @ coefficients))
    return float(coefficients[0]), scatter * sqrt(CORRELATED_ROWS / len(x))
