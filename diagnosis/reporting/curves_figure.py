"""Figure of force over slip in the blocks with most evidence: measured points, both tires, and what each tire lacks."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
import numpy.typing as npt
import pandas as pd

from ...drawing.figure import Figure, Panel, Series
from ...drawing.labels import axis_label, drawn_unit, letter, per_si
from ...drawing.style import BLUE, DASHED, GRAY, RED, SOLID
from ...measurements import level_tolerance
from ...measurements.operating_conditions.levels import held_levels
from ...numerics.ties import graded
from ...tires.evaluation import Conventions, evaluate
from ...tires.signs import convert_signs
from ...tires.tire import Tire
from ..verdict.result import Diagnosis

FloatArray = npt.NDArray[np.float64]

#: Number of blocks of time of a channel that are drawn.
BLOCKS = 4
#: Largest number of measured points of a block that are drawn.
POINTS = 400
#: Parts of the slip in which residuals are averaged.
PARTS = 20
#: Distance of two lines, as a share of the range of their panel, that is seen. A line is 0.7 % wide. Convention.
VISIBLE = 0.02
#: Inputs in the title of a block, and their decimals.
CONDITIONS = {"Fz": 0, "gamma": 1, "p": 1, "V": 1, "T": 0}


def curves_figure(diagnosis: Diagnosis, channel: str) -> Figure:
    """Return measured and computed forces over the slip that varies most, for the blocks that the effects improve most.

    These are blocks in which the forces of both tires differ. Without such a block both tires are one line.
    """
    table, measured = diagnosis.rows, _shown(diagnosis, channel)
    slips = [name for name in ("alpha", "kappa") if name in table]
    both = [_force(tire, diagnosis, channel) for tire in (diagnosis.base_tire, diagnosis.tire)]
    sweeps = [(block, *_swept(table.iloc[block], slips)) for block in _ranked_blocks(diagnosis, channel) if slips]
    different = [
        (block, slip, drawn)
        for block, slip, drawn in sweeps
        if not coincide(*(force[block][drawn] for force in (*both, measured)))
    ]
    names = ("baseline tire", "improved tire") if different else ("baseline tire and delivered tire",)
    chosen = sorted((different or sweeps)[:BLOCKS], key=lambda sweep: int(sweep[0][0]))
    panels, residuals = [], []
    for block, slip, drawn in chosen:
        computed = dict(zip(names, (force[block] for force in both), strict=False))
        panels.append(_panel(table.iloc[block], measured[block], computed, channel, slip, drawn))
        residuals.append(_residual_panel(table.iloc[block][slip], measured[block], computed, channel, slip, drawn))
    rows = (tuple(panels), tuple(residuals)) if panels else ((),)
    return Figure(f"diagnosis_curves_{channel}", f"{channel} over slip, measured and computed", rows)


def coincide(first: FloatArray, second: FloatArray, *drawn: FloatArray) -> bool:
    """Return whether two lines are one in a panel with them and other points; they may have NaN in the same rows.

    >>> x = np.linspace(0.0, 100.0, 50)
    >>> coincide(x, x + 1.0), coincide(x, x + 5.0), coincide(x, x + 5.0, 10.0 * x)
    (True, False, True)
    """
    shown = np.concatenate([first, second, *drawn])
    both = np.isfinite(first) & np.isfinite(second)
    if not both.any():
        return True
    return bool(np.abs(first - second)[both].max() <= VISIBLE * (np.nanmax(shown) - np.nanmin(shown)))


def _force(tire: Tire, diagnosis: Diagnosis, channel: str) -> FloatArray:
    inputs = [name for name in diagnosis.rows if name == "t" or name in tire.inputs]
    forces = evaluate(tire, diagnosis.rows[inputs], Conventions(diagnosis.recording_signs))
    return np.asarray(forces[channel], dtype=np.float64)


def _shown(diagnosis: Diagnosis, channel: str) -> FloatArray:
    """Return the measured force without the offset of the recording, in the signs of the recording."""
    offset = diagnosis.recording["removed"][channel]["offset"]
    signs = diagnosis.signs, diagnosis.recording_signs
    converted = float(convert_signs(pd.DataFrame({channel: [offset]}), *signs)[channel].iloc[0])
    return np.asarray(diagnosis.rows[channel], dtype=np.float64) - converted


def _ranked_blocks(diagnosis: Diagnosis, channel: str) -> list[npt.NDArray[np.int64]]:
    """Return the rows of each block, those with the largest reduction of the squared misfit first."""
    course = diagnosis.time_course[channel]
    gain = np.asarray(course["before"]) ** 2 - np.asarray(course["after"]) ** 2
    worth = gain if np.ptp(gain) > 0.0 else np.asarray(course["before"])
    starts = np.asarray(course["t"])
    t = diagnosis.rows["t"].to_numpy() if "t" in diagnosis.rows else np.arange(len(diagnosis.rows))
    ends = np.append(starts[1:], t[-1] + 1.0)
    blocks = (np.flatnonzero((t >= starts[k]) & (t < ends[k])) for k in np.argsort(-graded(worth), kind="stable"))
    return [block for block in blocks if len(block)]


def _panel(
    rows: pd.DataFrame, measured: FloatArray, computed: Mapping[str, FloatArray], channel: str, slip: str,
    drawn: npt.NDArray[np.bool_],
) -> Panel:  # fmt: skip
    x = rows[slip].to_numpy() * per_si(slip)
    shown = np.flatnonzero(drawn)
    thin = shown[:: max(1, len(shown) // POINTS)]
    series = [Series("points", x[thin], measured[thin], GRAY, "measured", marker=".", size=3.0)]
    for (name, force), color, dashes in zip(computed.items(), (RED, BLUE), (DASHED, SOLID), strict=False):
        # NaN in rows that are not drawn: no line connects two sweeps.
        series.append(Series("line", x, np.where(drawn, force, np.nan), color, name, dashes, size=1.4))
    rows = rows[drawn]
    other = {name: 1 for name in ("alpha", "kappa") if name in rows and name != slip}
    conditions = [
        f"{letter(name)} {_level_text(rows[name], name, decimals)}"
        for name, decimals in (other | CONDITIONS).items()
        if name in rows
    ]
    title = "\n".join([", ".join(conditions[:3]), ", ".join(conditions[3:])]).strip()
    return Panel(axis_label(slip), axis_label(channel), tuple(series), title, y_axis="force", width=3.4, height=3.0)


def _residual_panel(
    slips: pd.Series, measured: FloatArray, computed: Mapping[str, FloatArray], channel: str, slip: str,
    drawn: npt.NDArray[np.bool_],
) -> Panel:  # fmt: skip
    """Return the mean residual (measured minus computed) in parts of the slip, for each tire."""
    x = slips.to_numpy()[drawn] * per_si(slip)
    part = np.minimum(((x - x.min()) / max(float(np.ptp(x)), 1e-9) * PARTS).astype(np.int64), PARTS - 1)
    count = np.bincount(part, minlength=PARTS)
    filled = count > 0

    def mean(values: FloatArray) -> FloatArray:
        return np.asarray(np.bincount(part, np.nan_to_num(values), PARTS)[filled] / count[filled])

    series = [
        Series("line", mean(x), mean((measured - force)[drawn]), color, name, dashes, size=1.4)
        for (name, force), color, dashes in zip(computed.items(), (RED, BLUE), (DASHED, SOLID), strict=False)
    ]
    title = f"mean residual of {channel}"
    return Panel(axis_label(slip), axis_label(channel), tuple(series), title, y_axis="residual", width=3.4, height=1.8)


def _level_text(column: pd.Series, name: str, decimals: int) -> str:
    """Return the level of an input in its drawn unit, or its range if it is not held."""
    low, high = (float(np.quantile(column, share)) for share in (0.05, 0.95))
    if high - low > 2.0 * level_tolerance(column, name):
        text = f"{low * per_si(name):z.{decimals}f} to {high * per_si(name):z.{decimals}f}"
    else:
        text = f"{float(column.median()) * per_si(name):z.{decimals}f}"
    return f"{text} {drawn_unit(name)}".removesuffix(" -")


def _swept(rows: pd.DataFrame, slips: Sequence[str]) -> tuple[str, npt.NDArray[np.bool_]]:
    """Return the slip that varies most, and the rows at the most frequent level of every input that is held.

    A block of time may contain the end of one sweep and the start of another, at another load or slip angle.

    >>> rows = pd.DataFrame({"alpha": [*np.linspace(-0.2, 0.2, 28), 0.0, 0.0], "kappa": [0.0] * 28 + [0.3, 0.3]})
    >>> slip, drawn = _swept(rows, ["alpha", "kappa"])
    >>> slip, int(drawn.sum())
    ('alpha', 28)
    """
    spread = {name: float(np.ptp(np.quantile(rows[name], (0.1, 0.9)))) for name in slips}
    swept = max(slips, key=lambda name: graded(spread[name]))
    drawn = np.ones(len(rows), dtype=np.bool_)
    for name in [*slips, *CONDITIONS]:
        if name == swept or name not in rows:
            continue
        values = rows[name].to_numpy(dtype=np.float64)
        near = [drawn & (np.abs(values - level) <= level_tolerance(values, name)) for level in held_levels(rows[name])]
        if near:
            drawn = max(near, key=np.sum)
    return swept, drawn
