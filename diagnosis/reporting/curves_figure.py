"""Figure of force over slip: measured points, baseline tire and improved tire, in the blocks with most evidence."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
import numpy.typing as npt
import pandas as pd

from tirefmu.measurements import level_tolerance
from tirefmu.measurements.operating_conditions.levels import held_levels
from tirefmu.tires.drawing.own_matplotlib import Axes, Figure, own_settings
from tirefmu.tires.drawing.style import LEGEND_SIZE, LETTER, NOTE_SIZE, drawn_unit, per_si
from tirefmu.tires.signs import convert_signs
from tirefmu.tires.tire import Tire

from ..verdict.result import Diagnosis

FloatArray = npt.NDArray[np.float64]

#: Number of blocks of time of a channel that are drawn.
BLOCKS = 4
#: Largest number of measured points of a block that are drawn.
POINTS = 400
#: Distance of two lines, as a share of the range of their panel, that is seen. A line is 0.7 % wide. Convention.
VISIBLE = 0.02
#: Inputs in the title of a block, and their decimals.
CONDITIONS = {"Fz": 0, "gamma": 1, "p": 1, "V": 1, "T": 0}


@own_settings()
def curves_figure(diagnosis: Diagnosis, channel: str) -> Figure:
    """Draw measured and computed forces over the slip that varies most, for the blocks that the effects improve most.

    These are blocks in which the forces of both tires differ. Without such a block both tires are one line.

    Parameters
    ----------
    diagnosis : Diagnosis
    channel : str

    Returns
    -------
    matplotlib.figure.Figure
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
    figure = Figure(figsize=(13.0, 3.8), layout="constrained")
    axes = figure.subplots(1, BLOCKS, squeeze=False)[0]
    chosen = sorted((different or sweeps)[:BLOCKS], key=lambda sweep: int(sweep[0][0]))
    for ax, (block, slip, drawn) in zip(axes, chosen, strict=False):
        computed = {name: force[block] for name, force in zip(names, both, strict=False)}
        _draw(ax, table.iloc[block], measured[block], computed, slip, drawn)
    for ax in axes:
        ax.set_visible(bool(ax.lines))
    axes[0].set_ylabel(f"{LETTER.get(channel, channel)} ({drawn_unit(channel)})")
    axes[0].legend(fontsize=LEGEND_SIZE)
    return figure


def coincide(first: FloatArray, second: FloatArray, *drawn: FloatArray) -> bool:
    """Return whether two lines are one in a panel with them and other points; they may have NaN in the same rows.

    Examples
    --------
    >>> x = np.linspace(0.0, 100.0, 50)
    >>> coincide(x, x + 1.0), coincide(x, x + 5.0), coincide(x, x + 5.0, 10.0 * x)
    (True, False, True)
    """
    shown = np.concatenate([first, second, *drawn])
    known = np.isfinite(first) & np.isfinite(second)
    if not known.any():
        return True
    return bool(np.abs(first - second)[known].max() <= VISIBLE * (np.nanmax(shown) - np.nanmin(shown)))


def _force(tire: Tire, diagnosis: Diagnosis, channel: str) -> FloatArray:
    inputs = [name for name in diagnosis.rows if name == "t" or name in tire.inputs]
    forces = tire.evaluate(diagnosis.rows[inputs], signs=diagnosis.recording_signs)
    return np.asarray(forces[channel], dtype=np.float64)


def _shown(diagnosis: Diagnosis, channel: str) -> FloatArray:
    """Return the measured force without the offset of the recording, in the signs of the recording."""
    offset = diagnosis.recording["removed"][channel]["offset"]
    signs = diagnosis.signs, diagnosis.recording_signs
    own = float(convert_signs(pd.DataFrame({channel: [offset]}), *signs)[channel].iloc[0])
    return np.asarray(diagnosis.rows[channel], dtype=np.float64) - own


def _ranked_blocks(diagnosis: Diagnosis, channel: str) -> list[npt.NDArray[np.int64]]:
    """Return the rows of each block, those with the largest reduction of the squared misfit first."""
    course = diagnosis.time_course[channel]
    gain = np.asarray(course["before"]) ** 2 - np.asarray(course["after"]) ** 2
    worth = gain if np.ptp(gain) > 0.0 else np.asarray(course["before"])
    starts = np.asarray(course["t"])
    t = diagnosis.rows["t"].to_numpy() if "t" in diagnosis.rows else np.arange(len(diagnosis.rows))
    ends = np.append(starts[1:], t[-1] + 1.0)
    blocks = (np.flatnonzero((t >= starts[k]) & (t < ends[k])) for k in np.argsort(-worth, kind="stable"))
    return [block for block in blocks if len(block)]


def _draw(
    ax: Axes, rows: pd.DataFrame, measured: FloatArray, computed: Mapping[str, FloatArray], slip: str,
    drawn: npt.NDArray[np.bool_],
) -> None:  # fmt: skip
    x = rows[slip].to_numpy() * per_si(slip)
    shown = np.flatnonzero(drawn)
    thin = shown[:: max(1, len(shown) // POINTS)]
    ax.plot(x[thin], measured[thin], ".", ms=4, color="0.6", label="measured")
    for (name, force), color, dashes in zip(computed.items(), ("C3", "C0"), ("--", "-"), strict=False):
        # NaN in rows that are not drawn: no line connects two sweeps.
        ax.plot(x, np.where(drawn, force, np.nan), color=color, ls=dashes, lw=1.4, label=name)
    rows = rows[drawn]
    other = {name: 1 for name in ("alpha", "kappa") if name in rows and name != slip}
    conditions = [
        f"{LETTER.get(name, name)} {_level_text(rows[name], name, decimals)}"
        for name, decimals in (other | CONDITIONS).items()
        if name in rows
    ]
    ax.set_title("\n".join([", ".join(conditions[:3]), ", ".join(conditions[3:])]).strip(), fontsize=NOTE_SIZE)
    ax.set_xlabel(f"{LETTER.get(slip, slip)} ({drawn_unit(slip)})")
    ax.ticklabel_format(useOffset=False)
    ax.tick_params(labelsize=NOTE_SIZE)


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

    Examples
    --------
    >>> rows = pd.DataFrame({"alpha": [*np.linspace(-0.2, 0.2, 28), 0.0, 0.0], "kappa": [0.0] * 28 + [0.3, 0.3]})
    >>> slip, drawn = _swept(rows, ["alpha", "kappa"])
    >>> slip, int(drawn.sum())
    ('alpha', 28)
    """
    spread = {name: float(np.ptp(np.quantile(rows[name], (0.1, 0.9)))) for name in slips}
    swept = max(slips, key=lambda name: spread[name])
    drawn = np.ones(len(rows), dtype=np.bool_)
    for name in [*slips, *CONDITIONS]:
        if name == swept or name not in rows:
            continue
        values = rows[name].to_numpy(dtype=np.float64)
        near = [drawn & (np.abs(values - level) <= level_tolerance(values, name)) for level in held_levels(rows[name])]
        if near:
            drawn = max(near, key=np.sum)
    return swept, drawn
