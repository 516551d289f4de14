"""Transient slip: tan(alpha) and kappa lag behind their inputs by a rolled distance.

d x/dt = |V| / sigma (u - x): the exact solution over each step of any length (`tirefmu.symbolic.laws`); nothing changes
while the wheel does not roll. Pacejka, Tire and Vehicle Dynamics (2012), section 7.2.1 has the single contact point
model; here the lag acts on the slip itself.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
import numpy.typing as npt

from ...symbolic.quantities import AT_ONCE
from ..code.modules import state_laws

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


@dataclass(frozen=True)
class Accumulation:
    """The time history of an accumulation whose flow follows the inputs."""

    flow: FloatArray
    h: FloatArray
    start: FloatArray
    hold: bool
    again: npt.NDArray[np.bool_]

    @cached_property
    def value(self) -> FloatArray:
        """The values at the rows, shape (n,)."""
        last = self.flow[:-1] if self.hold else self.flow[1:]
        gained = state_laws.sum_linear(0.0, self.flow[:-1], last, self.h)
        return recursion(self.start[0], np.where(self.again, 0.0, 1.0), np.where(self.again, self.start[1:], gained))

    def between(self, interval: IntArray, share: FloatArray) -> FloatArray:
        """Return the values at shares (0 to 1) of the intervals that begin at the rows `interval`."""
        first = self.flow[interval]
        last = first if self.hold else first + (self.flow[interval + 1] - first) * share
        return np.asarray(state_laws.sum_linear(self.value[interval], first, last, self.h[interval] * share))


#: Terms of the series of an exponential, whose argument is at most 1/2: a remainder below 1e-17.
SERIES = 14
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
    gained = state_laws.lag(0.0, target[:-1], target[:-1] if hold else target[1:], way)
    decay = np.exp(-way)  # the law is linear in the state
    again = h < 0 if begins is None else begins[1:]
    value = recursion(start[0], np.where(again, 0.0, decay), np.where(again, start[1:], gained))
    return Course(target, rate, way, np.where(np.isinf(rate), target, value), hold)


def recursion(start: float, decay: FloatArray, gained: FloatArray) -> FloatArray:
    """Return x(0) = start, x(i + 1) = decay(i) x(i) + gained(i), shape (n + 1,)."""
    from scipy.linalg.blas import dtbsv  # loaded here: most evaluations have no memory

    bidiagonal = np.ones((2, len(decay) + 1), order="F")
    bidiagonal[1, :-1] = -decay
    return np.asarray(dtbsv(1, bidiagonal, np.concatenate([[start], gained]), lower=1, diag=1))


def exchange(lines: Mapping[str, FloatArray], names: Sequence[str]) -> FloatArray:
    """Return the matrix A of x' = A x + b for temperatures, shape (n, m, m), 1/s, from their lines, shape (n,)."""
    columns = [[-lines[f"{a}_rate"] if a == b else lines.get(f"{a}_by_{b}", 0.0 * lines[f"{a}_rate"]) for b in names]
               for a in names]  # fmt: skip
    return np.asarray(columns).transpose(2, 0, 1)


def held_system(matrix: FloatArray, h: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return E = exp(A h) and G, the integral of exp(A s) over a step: x' = A x + b has the end E x + G b.

    `matrix`, shape (n, m, m): A of each step, 1/s. `h`, shape (n,): steps, s. Returns two arrays of shape (n, m, m).

    >>> decay, gain = held_system(-np.ones((1, 1, 1)), np.ones(1))
    >>> round(float(decay[0, 0, 0]), 12), round(float(gain[0, 0, 0]), 12)
    (0.367879441171, 0.632120558829)
    """
    size = float(np.max(np.abs(matrix).sum(axis=2).max(axis=1, initial=0.0) * h, initial=0.0))
    halvings = max(0, int(np.ceil(np.log2(size * 2.0)))) if 0.5 < size < np.inf else 0
    part, unit = matrix * (h * 0.5**halvings)[:, None, None], np.eye(matrix.shape[1])
    share = np.zeros_like(part) + unit
    for k in range(SERIES, 1, -1):  # (exp(A h) - 1)/(A h), by its series in a part of the step
        share = unit + part @ share / k
    for _ in range(halvings):
        share = share + part @ share @ share / 2.0
        part = part * 2.0
    return unit + part @ share, share * h[:, None, None]


def vector_recursion(start: FloatArray, matrix: FloatArray, gained: FloatArray) -> FloatArray:
    """Return x(0) = start, shape (m,), x(i + 1) = matrix(i) x(i) + gained(i), shape (n + 1, m).

    `matrix`, shape (n, m, m). `gained`, shape (n, m).
    """
    from scipy.linalg.blas import dtbsv

    n, m = gained.shape
    band = np.zeros((2 * m, (n + 1) * m), order="F")
    band[0] = 1.0
    for i, j in np.ndindex(m, m):
        band[m + i - j, j : n * m : m] = -matrix[:, i, j]
    right = np.concatenate([start, gained.ravel()])
    return np.asarray(dtbsv(2 * m - 1, band, right, lower=1, diag=1)).reshape(-1, m)


def lateral_slip(alpha: npt.ArrayLike) -> FloatArray:
    """Return V_y/|V_x| of slip angles, rad: tan(alpha), beyond 90 deg that of the supplement as in the lines.

    >>> lateral_slip(np.radians([-45.0, 60.0, 120.0])).round(3).tolist()
    [-1.0, 1.732, 1.732]
    """
    return np.where(np.abs(alpha) > np.pi / 2, -np.tan(alpha), np.tan(alpha))


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


@dataclass(frozen=True)
class Steps:
    """Steps from row to row: the row at which the interval begins, shares of it, length in s, whether it ends it."""

    interval: IntArray
    begin: FloatArray
    end: FloatArray
    h: FloatArray
    last: npt.NDArray[np.bool_]
    halvings: int = 0

    def take(self, chosen: IntArray) -> Steps:
        """Return some of the steps."""
        begin, end, h, last = self.begin[chosen], self.end[chosen], self.h[chosen], self.last[chosen]
        return Steps(self.interval[chosen], begin, end, h, last, self.halvings)

    def halves(self) -> tuple[Steps, Steps]:
        """Return the first and the second half of the steps; a single step is divided."""
        if len(self.h) > 1:
            first, second = np.array_split(np.arange(len(self.h)), 2)
            return self.take(first), self.take(second)
        middle, h, n = (self.begin + self.end) / 2, self.h / 2, self.halvings + 1
        return (
            Steps(self.interval, self.begin, middle, h, np.array([False]), n),
            Steps(self.interval, middle, self.end, h, self.last, n),
        )


def integrated(settles: bool, drive: FloatArray, rate: FloatArray, h: FloatArray, x: float) -> FloatArray:
    """Return the values of a state at start, middle and end of steps, shape (3, m).

    `settles`: whether it follows its drive; otherwise it is the sum of it. `drive`, `rate`, shape (3, m): at start,
    middle and end. `h`, shape (m,): lengths of the steps, s. `x`: value at the first start.

    >>> drive, h = np.ones((3, 2)), np.array([1.0, 2.0])
    >>> integrated(False, drive, drive, h, 0.0)
    array([[0. , 1. ],
           [0.5, 2. ],
           [1. , 3. ]])
    """
    first, half, last = drive
    quarter = (3.0 * first + 6.0 * half - last) / 8.0
    if settles:
        way, way_half = (
            h * (rate[0] + 4.0 * rate[1] + rate[2]) / 6.0,
            h * (5.0 * rate[0] + 8.0 * rate[1] - rate[2]) / 24.0,
        )
        decay, decay_half = (state_laws.lag(1.0, 0.0, 0.0, path) for path in (way, way_half))
        gained = state_laws.lag_curved(0.0, first, half, last, way)
        gained_half = state_laws.lag_curved(0.0, first, quarter, half, way_half)
    else:
        decay = decay_half = np.ones(len(h))
        gained = state_laws.sum_curved(0.0, first, half, last, h)
        gained_half = state_laws.sum_curved(0.0, first, quarter, half, h / 2.0)
    ends = recursion(x, decay, gained)
    return np.stack([ends[:-1], decay_half * ends[:-1] + gained_half, ends[1:]])
