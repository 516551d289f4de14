"""What errors of the sensors of a bench do to the coefficients: offsets, drift, delays and cross-talk.

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

from ...measurements import ChannelNoise, Noise
from ...measurements.virtual_bench.bench_errors import (
    CROSS_TALK_PRIOR_SHARE,
    DRIFT_WAVES,
    MAX_CROSS_TALK,
    MAX_SKEW,
    SKEW_PRIOR_SHARE,
    cross_talk,
    half_waves,
)
from ...numerics.arrays import FloatArray, IntArray
from ..problem.rows import Rows
from ..problem.weighted_residuals import Problem
from .sample import Sample

#: Largest load of the bench of `Noise`, N.
BENCH_LOAD = 3000.0
#: Time over which a rate of change is read, s: longer than a delay, so that noise adds little to the effect of one.
RATE_TIME = 0.1


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
        rates = _rates(problem.rows, sample.number)
        for name, column in _columns(replace(problem, rows=sample.rows), x, sample.channel, bench, rates):
            drift = bench[name].drift / bench[name].offset if name in bench else 0.0
            for k, size in enumerate((1.0, *[drift * (2.0 / DRIFT_WAVES) ** 0.5] * DRIFT_WAVES)):
                changed = gradient * (size * column * waves[k])
                for recording in np.unique(group) if size else ():
                    key = name, k, int(recording)
                    changes[key] = changes.get(key, 0.0) + changed[:, group == recording].sum(axis=1)
    return inverse @ np.stack(list(changes.values()), axis=1) if changes else np.zeros((len(inverse), 0))


def _columns(
    problem: Problem, x: FloatArray, channel: int, bench: Mapping[str, ChannelNoise], rates: FloatArray
) -> Iterator[tuple[str, FloatArray]]:
    """Yield the changes of a channel by one standard deviation of each error.

    These are its offset and delay, those of inputs, and cross-talk. `rates`: see `_rates`.
    """
    rows, tire = problem.rows, problem.tire
    name, late = tire.outputs[channel], SKEW_PRIOR_SHARE * MAX_SKEW * rates
    yield name, np.full(len(rows), bench[name].offset)
    yield f"{name} late", late[len(tire.inputs) + channel]
    for i, name in enumerate(tire.inputs):
        offset = np.full(len(rows), bench[name].offset if name in bench else 0.0)
        for error, size in ((name, offset), (f"{name} late", late[i])):
            if size.any():
                changed = []
                for sign in (-1.0, 1.0):
                    inputs = rows.inputs.copy()
                    inputs[i] += sign * size
                    changed.append(replace(problem, rows=replace(rows, inputs=inputs)).residual(x)[channel])
                yield error, 0.5 * (changed[1] - changed[0])
    radius = tire.values["UNLOADED_RADIUS"]
    for pair, target, column in cross_talk(tire.outputs, np.nan_to_num(rows.measured.T), radius):
        if target == channel:
            yield pair, CROSS_TALK_PRIOR_SHARE * MAX_CROSS_TALK[pair] * column


def _rates(rows: Rows, at: IntArray) -> FloatArray:
    """Return the rates of change of inputs and measured forces at some rows, shape (n_inputs + n_forces, n), per s.

    0 without a recorded time.
    """
    step = float(np.median(np.diff(rows.time))) if len(rows) > 1 else np.nan
    if not step > 0.0:
        return np.zeros((len(rows.inputs) + rows.measured.shape[1], len(at)))
    half = max(1, round(0.5 * RATE_TIME / step))
    first, end = (np.searchsorted(rows.segment, rows.segment[at], side) for side in ("left", "right"))
    before, after = np.maximum(at - half, first), np.minimum(at + half, end - 1)
    change = np.concatenate(
        [rows.inputs[:, after] - rows.inputs[:, before], (rows.measured[after] - rows.measured[before]).T]
    )
    return np.asarray(np.nan_to_num(change) / np.maximum(rows.time[after] - rows.time[before], step))


def _passed(group: IntArray, place: FloatArray) -> FloatArray:
    """Return the share of its recording that has passed at each row."""
    passed = np.zeros(len(place))
    for recording in np.unique(group):
        times = place[group == recording]
        passed[group == recording] = (times - times[0]) / max(float(times[-1] - times[0]), 1e-9)
    return passed
