"""Values of states at the start of each segment of a recording, estimated from the measured forces.

What a tire has experienced before a recording, and in its gaps, is unknown. A state whose effect file has
``start = "fitted"`` therefore begins each segment with its own value, which is a property of the recording, not of the
tire. Each force depends on the value of its own segment only, so that one simulation per state gives the derivatives of
all segments.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping
from dataclasses import replace

import numpy as np

from ..numerics.arrays import FloatArray, IndexArray, IntArray
from ..tires.evaluation import Conventions, evaluate
from ..tires.states.transient import segment_starts
from ..tires.tire import Tire
from .recording import Recording

#: Gauss-Newton steps; step of a difference, as a share of the size of a state; prior standard deviation of a start
#: value, in sizes of the state.
ITERATIONS, STEP, SPREAD = 4, 1e-3, 3.0
#: Typical size of a coefficient, as a share of the range between its bounds.
AMPLITUDE = 0.125


def estimated_starts(
    residual: Callable[[FloatArray, FloatArray], FloatArray],
    segment: IndexArray,
    first: FloatArray,
    size: FloatArray,
    coefficients: FloatArray | None = None,
) -> FloatArray:
    """Return the start values that minimize the squared residual.

    - `residual`: returns the residual in standard deviations, shape (n_channels, n), 0 where nothing was measured, for
      start values of shape (n_states, n_segments) and changes of coefficients, shape (n_coefficients,).
    - `segment`, shape (n,): the segment of each column of the residual.
    - `first`, shape (n_states, n_segments): initial values; also the mean of the prior.
    - `size`, shape (n_states,): typical size of each state.
    - `coefficients`, shape (n_coefficients,): typical sizes of coefficients that are estimated together with the
      starts, as the effect of a start is its product with a coefficient; they are not returned. Default: none.

    Returns shape (n_states, n_segments).

    >>> t, segment = np.tile(np.arange(50.0), 2), np.repeat([0, 1], 50)
    >>> true = np.array([[2.0, -1.0]])
    >>> model = lambda starts: (starts[:, segment] * np.exp(-t / 10.0) * 100.0)
    >>> found = estimated_starts(lambda x, none: model(true) - model(x), segment, np.zeros((1, 2)), np.ones(1))
    >>> found.round(3).tolist()
    [[2.0, -1.0]]
    """
    m, k = first.shape
    others = np.zeros(0) if coefficients is None else coefficients
    spread = SPREAD * np.concatenate([np.repeat(size, k), others])
    steps = STEP * np.concatenate([size, others])
    mean = np.concatenate([first.ravel(), np.zeros(len(others))])
    starts = mean.copy()
    for _ in range(ITERATIONS):
        values, shift = starts[: m * k].reshape(m, k), starts[m * k :]
        now = residual(values, shift)
        matrix = np.zeros((now.size, len(starts)))
        for i, step in enumerate(steps):
            unit = step * (np.arange(len(steps)) == i)
            slope = (residual(values + unit[:m, None], shift + unit[m:]) - now) / step
            for j in range(k) if i < m else ():
                matrix[:, i * k + j] = np.where(segment == j, slope, 0.0).ravel()
            if i >= m:
                matrix[:, m * k + i - m] = slope.ravel()
        scaled = np.concatenate([matrix * spread, np.eye(len(starts))])
        target = np.concatenate([-now.ravel(), (mean - starts) / spread])
        starts = starts + spread * np.clip(np.linalg.lstsq(scaled, target, rcond=None)[0], -1.0, 1.0)
    return starts[: m * k].reshape(m, k)


def fitted_starts(
    t: FloatArray,
    courses: Mapping[str, FloatArray],
    error: FloatArray,
    residual: Callable[[Mapping[str, FloatArray], FloatArray], FloatArray],
    *,
    rows: IntArray | slice = slice(None),
    coefficients: FloatArray | None = None,
) -> dict[str, FloatArray]:
    """Return the start values of states by name, in each row of their segment, shape (n,).

    - `t`, shape (n,): time, s.
    - `courses`, shape (n,): states that start in equilibrium, by name.
    - `error`, shape (n_channels, m): the residual with them.
    - `residual`: returns the residual, NaN where nothing was measured, for start values as they are returned and
      changes of coefficients.
    - `rows`, shape (m,): the rows of the residual.
    - `coefficients`: as in `estimated_starts`.
    """
    begins = segment_starts(t)
    segment, course = np.cumsum(begins) - 1, np.stack(list(courses.values()))

    def spread(values: FloatArray) -> dict[str, FloatArray]:
        return dict(zip(courses, values[:, segment], strict=True))

    size = np.maximum(np.sqrt(np.mean(course**2, axis=1)), 1e-6)
    deviation = np.maximum(np.sqrt(np.nanmean(error**2, axis=1)), 1e-9)[:, None]
    starts = estimated_starts(
        lambda values, shift: np.nan_to_num(residual(spread(values), shift) / deviation),
        segment[rows], course[:, begins], size, coefficients,
    )  # fmt: skip
    return spread(starts)


def with_fitted_starts(tire: Tire, recording: Recording, free: Collection[str] = ()) -> Recording:
    """Return a recording with the start values of states with a fitted start as columns, which `Tire.evaluate` reads.

    `recording`: with time and measured forces; returned unchanged without them, or if no state has a fitted start.
    `free`: coefficients that are estimated together with the starts, but not returned. The result has a column for each
    such state; its values count at the first row of each segment.
    """
    names = [name for name in tire.states if tire.symbolic_model.states[name].start_is_fitted]
    table = recording.table.drop(columns=[name for name in names if name in recording.table])
    channels = [name for name in tire.outputs if name in table]
    if not names or "t" not in table or not channels:
        return recording
    course = evaluate(tire, table, Conventions(recording.signs))

    def residual(starts: Mapping[str, FloatArray], shift: FloatArray) -> FloatArray:
        moved = {name: tire.values[name] + change for name, change in zip(free, shift, strict=True)}
        changed = tire.with_values(**moved) if moved else tire
        computed = evaluate(changed, table.assign(**starts), Conventions(recording.signs))
        return (table[channels] - computed[channels]).to_numpy(dtype=np.float64).T

    starts = fitted_starts(
        table["t"].to_numpy(dtype=np.float64),
        {name: course[name].to_numpy(dtype=np.float64) for name in names},
        (table[channels] - course[channels]).to_numpy(dtype=np.float64).T,
        residual,
        coefficients=np.array([_size(tire, name) for name in free]),
    )
    return replace(recording, table=table.assign(**starts))


def _size(tire: Tire, name: str) -> float:
    declared = tire.symbolic_model.coefficients[name]
    span = declared.upper - declared.lower
    return AMPLITUDE * span if np.isfinite(span) else max(abs(tire.values[name]), AMPLITUDE)
