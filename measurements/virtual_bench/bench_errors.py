"""Errors of a test bench: offset, drift and delay of a channel, and cross-talk between forces; sizes and columns.

The diagnosis fits them together with the tire. A fit does not; its intervals contain what they do to the coefficients.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence

import numpy as np

from ...numerics.arrays import FloatArray

#: Half waves of drift over the recording: slower than sweeps, so that drift is not confounded with slip curves. Not
#: recorded.
DRIFT_WAVES = 3
#: Share of the other force: upper limit of cross-talk; more is attributed to the tire. Benches have up to 3 % of Fy in
#: Fx, in which no tire has a share of Fy that is odd in alpha. The limit of Fx in Fy is lower, as side forces generated
#: by kappa have the shape of Fx. Convention. Fy in Mz is a lever, as a share of the radius. Benchmark: the second
#: generator has up to 0.3 %.
#: Prior standard deviation, as a share of the limit. Convention.
MAX_CROSS_TALK: Mapping[str, float] = {"Fy_in_Fx": 0.035, "Fx_in_Fy": 0.012, "Fy_in_Mz": 0.004}
CROSS_TALK_PRIOR_SHARE = 1.0 / 3.0
#: Largest skew between channels, s: filters and multiplexers of a bench have up to 25 ms. More is attributed to the
#: tire. Prior standard deviation of the delay of each channel, as a share. Conventions.
MAX_SKEW, SKEW_PRIOR_SHARE = 0.03, 1.0 / 3.0


def half_waves(share: FloatArray, number: int = DRIFT_WAVES) -> list[FloatArray]:
    """Return a constant, and cosines of 1 to `number` half waves over a recording.

    `share`, shape (n,): of the recording that has passed, from 0 to 1.

    >>> [wave.round(3).tolist() for wave in half_waves(np.array([0.0, 0.5, 1.0]), 1)]
    [[1.0, 1.0, 1.0], [1.0, 0.0, -1.0]]
    """
    return [np.asarray(np.cos(k * np.pi * share)) for k in range(number + 1)]


def cross_talk(channels: Sequence[str], forces: FloatArray, radius: float) -> Iterator[tuple[str, int, FloatArray]]:
    """Yield the names of cross-talk, as Fx_in_Fy, the index of the channel that has it, and its change per unit.

    `forces`, shape (n_channels, n). `radius`: m, the length to which cross-talk of a force into a moment refers.

    >>> [(name, i, column.tolist()) for name, i, column in cross_talk(["Fy", "Mz"], np.array([[100.0], [5.0]]), 0.3)]
    [('Fy_in_Mz', 1, [30.0])]
    """
    for pair in MAX_CROSS_TALK:
        source, target = pair.split("_in_")
        if {source, target} <= set(channels):
            length = radius if target == "Mz" else 1.0
            yield pair, channels.index(target), length * forces[channels.index(source)]
