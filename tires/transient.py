"""Transient slip: tan(alpha) and kappa lag behind their inputs by a rolled distance.

d x/dt = |V| / sigma (u - x): the exact solution over each step of any length (`tirefmu.symbolic.laws`); nothing changes
while the wheel does not roll. Pacejka, Tire and Vehicle Dynamics (2012), section 7.2.1 has the single contact point
model; here the lag acts on the slip itself.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from tirefmu.symbolic.quantities import AT_ONCE

from .code.modules import state_laws

FloatArray = npt.NDArray[np.float64]
IntArray = npt.NDArray[np.intp]


@dataclass(frozen=True)
class Course:
    """The time history of a lag over a recording.

    - `target`, `rate`, shape (n,): the target, and the rate, 1/s; infinite without lag.
    - `way`, shape (n - 1,): integral of the rate from row to row.
    - `value`, shape (n,).
    - `hold`: targets are held from each row to the next; otherwise they are linear.
    """

    target: FloatArray
    rate: FloatArray
    way: FloatArray
    value: FloatArray
    hold: bool

    def between(self, interval: npt.NDArray[np.intp], share: FloatArray) -> FloatArray:
        """Return the values at shares (0 to 1) of the intervals that begin at the rows `interval`."""
        first = self.target[interval]
        last = first if self.hold else first + (self.target[interval + 1] - first) * share
        with np.errstate(invalid="ignore"):
            way = np.where(share > 0.0, self.way[interval] * share, 0.0)
        return np.asarray(state_laws.lag(self.value[interval], first, last, way))


#: A longer step in time is a gap, in median steps.
GAP = 5.0


def segment_starts(t: FloatArray) -> npt.NDArray[np.bool_]:
    """Return whether a segment of a recording begins at a row: the first row, where time goes backward, after a gap.

    >>> segment_starts(np.array([0.0, 0.1, 0.2, 20.0, 20.1, 0.0])).tolist()
    [True, False, False, True, False, True]
    """
    step = np.diff(t)
    forward = step[step > 0.0]
    longest = GAP * float(np.median(forward)) if len(forward) else np.inf
    return np.concatenate([[True], (step < 0.0) | (step > longest)])[: len(t)]


#: A gap shorter than this has the inputs between its rows, s.
SHORTEST_PAUSE = 1.0


def pauses(t: FloatArray) -> npt.NDArray[np.bool_]:
    """Return whether the time after a row is a pause, in which a tire rolls without slip: a gap of a second or more.

    `t`, shape (n,): time, s. Returns shape (n - 1,).

    >>> pauses(np.array([0.0, 0.1, 0.2, 20.0, 20.1, 0.0])).tolist()
    [False, False, True, False, False]
    """
    return segment_starts(t)[1:] & (np.diff(t) > SHORTEST_PAUSE)


def with_pauses(t: FloatArray, rows: FloatArray, slips: list[int]) -> tuple[FloatArray, FloatArray, IntArray]:
    """Return time and rows with a row without slip at each end of a pause, and the places of the given rows.

    `t`, shape (n,): time, s. `rows`, shape (n_inputs, n). `slips`: indices of the slips in the rows.
    """
    before = np.flatnonzero(pauses(t))
    edge = SHORTEST_PAUSE / 100.0
    time = np.insert(t, np.repeat(before + 1, 2), np.stack([t[before] + edge, t[before + 1] - edge], axis=1).ravel())
    given = np.arange(len(t)) + 2 * np.searchsorted(before, np.arange(len(t)), side="left")
    source = np.insert(np.arange(len(t)), np.repeat(before + 1, 2), np.stack([before, before + 1], axis=1).ravel())
    filled = rows[:, source]
    added = np.isin(np.arange(len(time)), given, invert=True)
    filled[slips] = np.where(added, 0.0, filled[slips])
    return time, filled, given


def followed(
    t: FloatArray,
    target: FloatArray,
    rate: FloatArray,
    start: FloatArray,
    *,
    hold: bool,
    begins: npt.NDArray[np.bool_] | None = None,
) -> Course:
    """Return the time history of a lag.

    `t`, shape (n,): time, s. Where it goes backward, a new recording begins at the start value of that row. `target`,
    `rate`, shape (n,): as in `Course`. `start`, shape (n,): the value with which a recording that begins at a row
    starts. `begins`, shape (n,): the rows at which a recording begins. Default: the first one, and where time goes
    backward.
    """
    if not len(t):
        return Course(target, rate, t, target, hold)
    h = np.diff(t)
    with np.errstate(invalid="ignore"):
        way = np.where(h > 0, h * (rate[:-1] if hold else (rate[:-1] + rate[1:]) / 2), 0.0)
    # A law is linear in the state.
    gained = state_laws.lag(0.0, target[:-1], target[:-1] if hold else target[1:], way)
    decay = state_laws.lag(1.0, 0.0, 0.0, way)
    again = h < 0 if begins is None else begins[1:]
    value = recursion(start[0], np.where(again, 0.0, decay), np.where(again, start[1:], gained))
    return Course(target, rate, way, np.where(np.isinf(rate), target, value), hold)


def recursion(start: float, decay: FloatArray, gained: FloatArray) -> FloatArray:
    """Return x(0) = start, x(i + 1) = decay(i) x(i) + gained(i), shape (n + 1,)."""
    from scipy.linalg.blas import dtbsv  # loaded here: most evaluations have no memory

    bidiagonal = np.ones((2, len(decay) + 1), order="F")
    bidiagonal[1, :-1] = -decay
    return np.asarray(dtbsv(1, bidiagonal, np.concatenate([[start], gained]), lower=1, diag=1))


def lagged_course(t: FloatArray, slip: FloatArray, speed: FloatArray, sigma: FloatArray, *, hold: bool) -> Course:
    """Return the time history of the slip that acts in each row of a recording.

    `t`, shape (n,): time, s. Where it goes backward, a new recording begins in steady state, as at the first row.
    `slip`, shape (n,): tan(alpha) or kappa as an input. `speed`, shape (n,): V, m/s; its sign does not matter. `sigma`,
    shape (n,): relaxation length, m; where it is 0 the slip acts without lag. `hold`: inputs are held from each row to
    the next, as in a co-simulation; otherwise the slip is linear and |V| / sigma the mean between rows.

    >>> t = np.array([0.0, 0.1, 0.2])
    >>> step, ones = np.array([0.0, 1.0, 1.0]), np.ones(3)
    >>> lagged_course(t, step, 10 * ones, ones, hold=True).value.round(4).tolist()
    [0.0, 0.0, 0.6321]
    """
    with np.errstate(divide="ignore"):
        rate = np.where(sigma > AT_ONCE, np.abs(speed) / np.maximum(sigma, AT_ONCE), np.inf)
    return followed(t, slip, rate, slip, hold=hold)


def rolled_distance(t: FloatArray, speed: FloatArray, *, hold: bool = False) -> FloatArray:
    """Return the distance rolled since the recording began, m; a step back in time counts nothing.

    `t`, shape (n,): time, s. `speed`, shape (n,): V, m/s; its sign does not matter. `hold`: V is held from each row to
    the next, as in a co-simulation; otherwise it is linear between rows. Returns shape (n,).

    >>> rolled_distance(np.array([0.0, 1.0, 3.0]), np.array([10.0, 10.0, 20.0])).tolist()
    [0.0, 10.0, 40.0]
    """
    held, following = np.abs(speed[:-1]), np.abs(speed[1:])
    rolled = state_laws.sum_linear(0.0, held, held if hold else following, np.maximum(np.diff(t), 0.0))
    return np.concatenate([[0.0], np.cumsum(rolled)])[: len(t)]
