"""Values of states at the start of each segment of a recording, estimated from the measured forces.

What a tire has experienced before a recording, and in its gaps, is unknown. A state whose effect file has
``start = "fitted"`` therefore begins each segment with its own value, which is a property of the recording, not of the
tire. Each force depends on the value of its own segment only, so that one simulation per state gives the derivatives of
all segments.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import numpy.typing as npt

from tirefmu.measurements.recording import Recording
from tirefmu.tires.tire import Tire
from tirefmu.tires.transient import segment_starts

FloatArray = npt.NDArray[np.float64]
IntArray = npt.NDArray[np.intp]

#: Gauss-Newton steps; step of a difference, as a share of the size of a state; prior standard deviation of a start
#: value, in sizes of the state.
ITERATIONS, STEP, SPREAD = 4, 1e-3, 3.0


def estimated_starts(
    residual: Callable[[FloatArray], FloatArray], segment: IntArray, first: FloatArray, size: FloatArray
) -> FloatArray:
    """Return the start values that minimize the squared residual of each segment.

    Parameters
    ----------
    residual : callable
        Returns the residual in standard deviations, shape (n_channels, n), 0 where nothing was measured, for start
        values of shape (n_states, n_segments).
    segment : ndarray of int, shape (n,)
        The segment of each column of the residual.
    first : ndarray, shape (n_states, n_segments)
        Initial values; also the mean of the prior.
    size : ndarray, shape (n_states,)
        Typical size of each state.

    Returns
    -------
    ndarray, shape (n_states, n_segments)

    Examples
    --------
    >>> t, segment = np.tile(np.arange(50.0), 2), np.repeat([0, 1], 50)
    >>> true = np.array([[2.0, -1.0]])
    >>> model = lambda starts: (starts[:, segment] * np.exp(-t / 10.0) * 100.0)
    >>> found = estimated_starts(lambda x: model(true) - model(x), segment, np.zeros((1, 2)), np.ones(1))
    >>> found.round(3).tolist()
    [[2.0, -1.0]]
    """
    values = first.copy()
    steps = STEP * size
    for _ in range(ITERATIONS):
        now = residual(values)
        moved = [residual(values + step * unit[:, None]) for step, unit in zip(steps, np.eye(len(steps)), strict=True)]
        slopes = np.stack([(one - now) / step for one, step in zip(moved, steps, strict=True)], axis=-1)
        change = np.empty_like(values)
        for k in range(values.shape[1]):
            rows = segment == k
            a = slopes[:, rows].reshape(-1, len(steps)) * (SPREAD * size)
            b = np.concatenate([-now[:, rows].ravel(), (first - values)[:, k] / (SPREAD * size)])
            change[:, k] = SPREAD * size * np.linalg.lstsq(np.concatenate([a, np.eye(len(steps))]), b, rcond=None)[0]
        values = values + np.clip(change, -(SPREAD * size)[:, None], (SPREAD * size)[:, None])
    return values


def with_fitted_starts(tire: Tire, recording: Recording) -> Recording:
    """Return a recording with the start values of states with a fitted start as columns, which `Tire.evaluate` reads.

    Parameters
    ----------
    tire : Tire
    recording : Recording
        With time and measured forces; returned unchanged without them, or if no state has a fitted start.

    Returns
    -------
    Recording
        With a column for each such state; its values count at the first row of each segment.
    """
    names = [name for name in tire.states if tire.book.states[name].start_is_fitted]
    table = recording.table.drop(columns=[name for name in names if name in recording.table])
    channels = [name for name in tire.outputs if name in table]
    if not names or "t" not in table or not channels:
        return recording
    begins = segment_starts(table["t"].to_numpy(dtype=np.float64))
    segment = np.cumsum(begins) - 1
    course = tire.evaluate(table, signs=recording.signs)
    measured = table[channels].to_numpy(dtype=np.float64).T

    def columns(values: FloatArray) -> dict[str, FloatArray]:
        return dict(zip(names, values[:, segment], strict=True))

    def difference(values: FloatArray) -> FloatArray:
        computed = tire.evaluate(table.assign(**columns(values)), signs=recording.signs)[channels]
        return np.asarray(measured - computed.to_numpy(dtype=np.float64).T)

    states = course[names].to_numpy(dtype=np.float64).T
    size = np.maximum(np.sqrt(np.mean(states**2, axis=1)), 1e-6)
    error = measured - course[channels].to_numpy(dtype=np.float64).T
    deviation = np.maximum(np.sqrt(np.nanmean(error**2, axis=1)), 1e-9)[:, None]
    found = estimated_starts(
        lambda values: np.nan_to_num(difference(values) / deviation), segment, states[:, begins], size
    )
    return replace(recording, table=table.assign(**columns(found)))
