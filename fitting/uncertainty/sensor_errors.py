"""What slow errors of the sensors of a bench do to the coefficients: offsets, drift and cross-talk.

The tire follows an error that is constant over a recording, so that it is not in the residual. The errors are unknown,
with the sizes of a tire test bench (`tirefmu.measurements.Noise`, scaled by the largest load, and
`tirefmu.measurements.virtual_bench.bench_errors`), independent of each other and between recordings. To first order an
error that changes the residuals by c changes the solution by -H^-1 J^T W c, as in the consider covariance of Schmidt
(1966).
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import replace

import numpy as np
import numpy.typing as npt

from tirefmu.measurements import ChannelNoise, Noise
from tirefmu.measurements.virtual_bench.bench_errors import (
    CROSS_TALK_PRIOR_SHARE,
    DRIFT_WAVES,
    MAX_CROSS_TALK,
    cross_talk,
    half_waves,
)

from ..problem.weighted_residuals import Problem
from .sample import Sample

FloatArray = npt.NDArray[np.float64]

#: Largest load of the bench of `Noise`, N.
BENCH_LOAD = 3000.0


def sensor_errors(problem: Problem, x: FloatArray, samples: Iterable[Sample], inverse: FloatArray) -> FloatArray:
    """Return the changes of the scaled free values by each error of the sensors of one standard deviation.

    `x`, shape (n_free,): the solution. `samples`: of the channels. `inverse`, shape (n_free, n_free): of J^T W J.
    Returns shape (n_free, n_errors).
    """
    largest = float(problem.rows.inputs[problem.tire.inputs.index("Fz")].max())
    bench = Noise().scaled(largest / BENCH_LOAD).channels
    changes: dict[tuple[str, int, int], FloatArray] = {}
    for sample in samples:
        gradient, group = sample.gradient, sample.rows.group
        waves = half_waves(_passed(group, sample.place))
        for name, column in _columns(replace(problem, rows=sample.rows), x, sample.channel, bench):
            drift = bench[name].drift / bench[name].offset if name in bench else 0.0
            for k, size in enumerate((1.0, *[drift * (2.0 / DRIFT_WAVES) ** 0.5] * DRIFT_WAVES)):
                changed = gradient * (size * column * waves[k])
                for recording in np.unique(group) if size else ():
                    key = name, k, int(recording)
                    changes[key] = changes.get(key, 0.0) + changed[:, group == recording].sum(axis=1)
    return inverse @ np.stack(list(changes.values()), axis=1) if changes else np.zeros((len(inverse), 0))


def _columns(
    problem: Problem, x: FloatArray, channel: int, bench: Mapping[str, ChannelNoise]
) -> Iterator[tuple[str, FloatArray]]:
    """Yield the changes of a channel by one standard deviation of its offset, of those of inputs, and of cross-talk."""
    rows, tire = problem.rows, problem.tire
    name = tire.outputs[channel]
    yield name, np.full(len(rows), bench[name].offset)
    for i, name in enumerate(tire.inputs):
        if name in bench and bench[name].offset:
            changed = []
            for sign in (-1.0, 1.0):
                inputs = rows.inputs.copy()
                inputs[i] += sign * bench[name].offset
                changed.append(replace(problem, rows=replace(rows, inputs=inputs)).residual(x)[channel])
            yield name, 0.5 * (changed[1] - changed[0])
    radius = tire.values["UNLOADED_RADIUS"]
    for pair, target, column in cross_talk(tire.outputs, np.nan_to_num(rows.measured.T), radius):
        if target == channel:
            yield pair, CROSS_TALK_PRIOR_SHARE * MAX_CROSS_TALK[pair] * column


def _passed(group: npt.NDArray[np.int64], place: FloatArray) -> FloatArray:
    """Return the share of its recording that has passed at each row."""
    passed = np.zeros(len(place))
    for recording in np.unique(group):
        own = place[group == recording]
        passed[group == recording] = (own - own[0]) / max(float(own[-1] - own[0]), 1e-9)
    return passed
