"""Location of residuals: mean residual over noise by pairs of inputs with sample counts, and misfit over time."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from ...drawing.labels import range_text
from ...numerics.arrays import FloatArray
from ...numerics.ties import graded
from ...symbolic.channels import CHANNELS
from ..probing.candidates import varies
from ..probing.effect_probing import Screen

#: The pairs of inputs over which residuals are mapped.
PAIRS = (("alpha", "kappa"), ("Fz", "gamma"), ("p", "T"), ("V", "distance"))
CELLS = 8
#: Minimum number of rows of a cell whose mean is shown. Derived: its standard error is then a third of the noise.
MIN_ROWS_OF_CELL = 10
#: Least share of the squared residual that scales of the force explain for a text. Convention.
SCALED_SHARE = 0.1


def residual_maps(screen: Screen) -> list[dict[str, Any]]:
    """Return mean residuals in noise standard deviations, by channel, over pairs of inputs.

    `screen`: of the solution of a model. Returns: channel, over (two inputs), edges (two lists), mean and count (lists
    of cells; the mean is None without data), worst: the cell with the largest magnitude of the mean, of those with at
    least ten rows.
    """
    signals = screen.signals
    named = signals.named()
    recorded = [name for name in named if name not in signals.origin.derived]
    pairs = _pairs([name for name in recorded if varies(signals, screen.problem.simulator.tire, name)])
    rows = zip(signals.channels, screen.residual, screen.problem.inverse_noise > 0.0, strict=True)
    return [
        {"channel": channel, "over": [first, second]} | _mapped(named[first][used], named[second][used], residual[used])
        for channel, residual, used in rows
        for first, second in pairs
    ]


def _pairs(varying: Sequence[str]) -> list[tuple[str, str]]:
    """Return the pairs of inputs that both vary; an input whose partner is constant is paired with a slip.

    >>> _pairs(["alpha", "Fz", "gamma", "T"])
    [('Fz', 'gamma'), ('alpha', 'T')]
    """
    pairs = [pair for pair in PAIRS if set(pair) <= set(varying)]
    paired = {name for pair in pairs for name in pair}
    slips = [name for name in ("alpha", "kappa") if name in varying]
    alone = [name for name in varying if name not in paired and name not in slips]
    pairs += [(slips[0], name) for name in alone] if slips else []
    return pairs or [(slips[0], slips[0])] * bool(slips)


def scale_errors(screen: Screen) -> dict[str, str]:
    """Return by channel where the tire gives too much or too little, in words; '' if that states little.

    In parts of the range of one input the residual is compared with the force. The input is the one with which most of
    the squared residual disappears if the force of each part is scaled, at least `SCALED_SHARE`; the part is the one
    with the largest share of that.
    """
    signals, named = screen.signals, screen.signals.named()
    recorded = [name for name in named if name in CHANNELS and name != "t"]
    inputs = [name for name in recorded if varies(signals, screen.problem.simulator.tire, name)]
    texts = dict.fromkeys(signals.channels, "")
    forces = screen.problem.simulator.forces(screen.solution.parameters)
    for i, channel in enumerate(signals.channels):
        used = screen.problem.inverse_noise[i] > 0.0
        residual, force = screen.solution.residual[i][used], forces[i][used]
        best = SCALED_SHARE * float(np.sum(residual**2))
        for name in inputs:
            edges = np.quantile(named[name][used], np.linspace(0.0, 1.0, CELLS + 1))
            part = np.clip(np.searchsorted(edges, named[name][used], side="right") - 1, 0, CELLS - 1)
            power = np.maximum(np.bincount(part, force**2, CELLS), 1e-300)
            scale = np.bincount(part, residual * force, CELLS) / power
            if (explained := float(np.sum(scale**2 * power))) > best * (1.0 + 1e-9):
                best, largest = explained, int(np.argmax(graded(scale**2 * power)))
                how = "little" if scale[largest] > 0.0 else "much"
                where = range_text(name, float(edges[largest]), float(edges[largest + 1]))
                texts[channel] = f"the tire gives {100.0 * abs(scale[largest]):.2g} % too {how} {channel} at {where}"
    return texts


def time_course(before: Screen, after: Screen) -> dict[str, dict[str, list[float]]]:
    """Return each channel's misfit over time: root mean square over noise, by time block.

    `before`, `after`: of the solutions of the baseline model and the improved model. Returns: channel -> t (start of
    each block, s), before, after.
    """
    signals, edges = after.signals, after.edges
    begins = signals.t[signals.rows][edges[:-1]].tolist()
    courses = {}
    for i, channel in enumerate(signals.channels):
        courses[channel] = {"t": begins}
        for name, screen in (("before", before), ("after", after)):
            counts = np.maximum(np.add.reduceat((screen.problem.inverse_noise[i] > 0.0).astype(float), edges[:-1]), 1.0)
            power = np.add.reduceat(screen.residual[i] ** 2, edges[:-1])
            courses[channel][name] = np.sqrt(power / counts).tolist()
    return courses


def _mapped(x: FloatArray, y: FloatArray, residual: FloatArray) -> dict[str, Any]:
    edges = [np.linspace(v.min(), v.max() + 1e-9 * (1.0 + abs(v.max())), CELLS + 1) for v in (x, y)]
    count, _, _ = np.histogram2d(x, y, bins=edges)
    total, _, _ = np.histogram2d(x, y, bins=edges, weights=residual)
    mean = np.where(count > 0, total / np.maximum(count, 1.0), np.nan)
    i, j = np.unravel_index(int(np.argmax(graded(np.where(count >= MIN_ROWS_OF_CELL, np.abs(mean), -1.0)))), mean.shape)
    worst = {
        "from": [float(edges[0][i]), float(edges[1][j])],
        "to": [float(edges[0][i + 1]), float(edges[1][j + 1])],
        "mean": float(mean[i, j]),
        "count": int(count[i, j]),
    }
    return {
        "edges": [edge.tolist() for edge in edges],
        "mean": mean.tolist(),
        "count": count.astype(int).tolist(),
        "worst": worst,
    }
