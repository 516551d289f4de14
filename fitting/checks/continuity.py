"""Jumps and kinks of a fitted tire over the slips, within the range of the data.

A real tire has neither. A formula may have a jump because a coefficient makes a smooth function so steep that it acts
like a step. The change of an output over a short part of the range of a slip is compared with the changes over the
parts before and after it: those of a smooth curve hardly differ, however steep it is.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import product

import numpy as np

from ...numerics.arrays import FloatArray
from ...numerics.ties import graded
from ...tires.code import fastest_code
from .residuals import Residuals

#: Steps of a line over the range of a slip, and lengths of a part of it, in steps.
STEPS, PARTS = 1000, (1, 4, 16)
#: Change over a part beyond those of its neighbors, as a share of the range of the measured values, that is a jump;
#: change of slope within a step, as a share of the largest slope, that is a kink. Judgement: the force with the largest
#: curvature has 2 % of both.
JUMP, KINK = 0.05, 0.25


@dataclass(frozen=True)
class Discontinuity:
    """The largest jump or kink of a channel.

    - `kind`: "jump" or "kink".
    - `size`: change of the channel, in its unit; of a kink, the change of its slope by the slip.
    - `slip`, `position`: the slip along which it occurs, and where.
    - `at`: levels of the other inputs.
    """

    channel: str
    unit: str
    kind: str
    size: float
    slip: str
    position: float
    at: dict[str, float]


def discontinuities(residuals: Residuals) -> tuple[Discontinuity, ...]:
    """Return the largest jump of each fitted channel over the tested slips at the tested conditions, or its kink."""
    by_channel: dict[str, list[Discontinuity]] = {}
    for discontinuity in _all(residuals):
        by_channel.setdefault(discontinuity.channel, []).append(discontinuity)
    return tuple(max(places, key=lambda d: (d.kind == "jump", graded(abs(d.size)))) for places in by_channel.values())


def _all(residuals: Residuals) -> Iterator[Discontinuity]:
    tire, table = residuals.tire, residuals.table
    units = {output.name: output.unit for output in tire.symbolic_model.outputs}
    spread = {
        channel: float(np.ptp(np.nanquantile(table[channel].to_numpy(dtype=float), (0.02, 0.98))))
        for channel in residuals.channels
    }
    levels = residuals.levels
    held = {name: float(np.median(table[name])) for name in tire.inputs if name not in ("kappa", "alpha")}
    code, parameters = fastest_code(tire.symbolic_model), tire.parameters()
    for slip in ("kappa", "alpha"):
        values = table[slip].to_numpy(dtype=float)
        low, high = float(values.min()), float(values.max())
        if high - low < 1e-6:
            continue
        grid = np.linspace(low, high, STEPS + 1)
        for point in product(*levels.values()):
            at = dict(zip(levels, point, strict=True))
            columns = {**held, **at, "kappa": 0.0, "alpha": 0.0}
            inputs = np.stack([grid if name == slip else np.full(len(grid), columns[name]) for name in tire.inputs])
            forces = code.forces(tire.effective_inputs(inputs), parameters)
            for channel, size in spread.items():
                curve = residuals.sign(channel) * forces[tire.outputs.index(channel)]
                place = _place(curve, size)
                if place:
                    kind, index, change = place
                    amount = change if kind == "jump" else change / (grid[1] - grid[0])
                    yield Discontinuity(channel, units[channel], kind, amount, slip, float(grid[index]), at)


def _place(curve: FloatArray, spread: float) -> tuple[str, int, float] | None:
    """Return kind, index and change of the worst place of a curve; None if it is smooth."""
    worst = ("jump", 0, 0.0, 0.0)
    for part in PARTS:
        change = curve[part:] - curve[:-part]
        before, here, after = change[: -2 * part], change[part:-part], change[2 * part :]
        beyond = np.abs(here) - np.maximum(np.abs(before), np.abs(after))
        index = int(graded(beyond).argmax())
        if beyond[index] > worst[3]:
            worst = ("jump", index + part + part // 2, float(here[index]), float(beyond[index]))
    if worst[3] > JUMP * spread:
        return worst[:3]
    slope = np.diff(curve)
    bend = np.diff(slope)
    index = int(graded(np.abs(bend)).argmax())
    if abs(bend[index]) > KINK * float(np.abs(slope).max()) and abs(bend[index]) > JUMP * spread / STEPS:
        return "kink", index + 1, float(bend[index])
    return None
