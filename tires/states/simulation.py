"""The time histories of a tire's states over a recording.

States that follow only inputs, and hystereses along lagged slips, have exact updates. A state driven by forces that
depend on it is integrated in steps that grow with the time since the last change of the inputs. In each step the drive
is a parabola through start, middle and end (a Lobatto collocation of fourth order, exact for the lag itself); the
values at the middle and the end are found by iteration, for many steps at once. Temperatures change slowly: forces at
the middle of a step, with the temperatures of its start, heat the tire over the whole step, in which the nodes exchange
heat exactly.

References
----------
Hochbruck and Ostermann, Exponential integrators, Acta Numerica (2010), section 2.2: exponential collocation.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping
from dataclasses import dataclass, field
from functools import cached_property
from itertools import pairwise

import numpy as np
import numpy.typing as npt

from ...symbolic.added.state import State
from ...symbolic.model import Model
from ..code import Code
from .equilibrium import CONVERGED, equilibrium
from .oscillator import Oscillation, Part
from .path import PathCourse
from .transient import (
    Accumulation,
    Course,
    Steps,
    exchange,
    followed,
    held_system,
    integrated,
    segment_starts,
    vector_recursion,
)

FloatArray = npt.NDArray[np.float64]
IntArray = npt.NDArray[np.intp]
_Course = Course | Accumulation | PathCourse | Part

#: First step after a change of the inputs, as a share of the shortest time constant, and the ratio of a step to the
#: one before. `fmu/packaging/written_headers.py` prints these numbers and the next ones for the FMU.
FIRST_STEP, GROWTH = 0.3, 1.2
#: The largest number of iterations; the change of the values that is then accepted; how often a step with a larger
#: change is halved (more would take hours). The values of a step that still has a larger change are NaN.
MAX_ITERATIONS, ACCEPTED, MAX_HALVINGS = 50, 1e-9, 10
#: Steps that are solved together at first; rows over which temperatures and forces are iterated together.
WINDOW, WARM_WINDOW = 4096, 512


@dataclass
class StateSimulation:
    """A recording over which states are simulated.

    - `code`: of the same model.
    - `t`, shape (n,): time, s. Where it goes backward, a new recording begins.
    - `rows`, shape (n_inputs, n): given inputs.
    - `parameters`, shape (n_parameters,).
    - `hold`: inputs are held from each row to the next; otherwise they are linear.
    - `slips`: the time histories of kappa and tan(alpha), by input, if they lag.
    - `names`: the states that are simulated; the others are 0.
    - `starts`, shape (n,): the initial values of states at the rows where a segment begins
      (`transient.segment_starts`), by name.
    - `driving`: returns the lines of the states, for given forces, from the values of states by name
      (`histories_by_given_forces`).
    """

    symbolic_model: Model
    code: Code
    t: FloatArray
    rows: FloatArray
    parameters: FloatArray
    hold: bool
    slips: Mapping[str, Course]
    names: Collection[str]
    starts: Mapping[str, FloatArray] = field(default_factory=dict)
    driving: Callable[[Mapping[str, FloatArray]], dict[str, FloatArray]] | None = None
    _courses: dict[str, _Course] = field(default_factory=dict)

    def __post_init__(self) -> None:
        self.index = {quantity.name: i for i, quantity in enumerate(self.symbolic_model.inputs)}
        if self.driving is None:
            self.rows = self.rows.copy()
            self.rows[[self.index[name] for name in self.symbolic_model.states]] = 0.0
        self.states = [state for name, state in self.symbolic_model.states.items() if name in self.names]
        self.h = np.diff(self.t)
        self._begins = segment_starts(self.t) if self.starts else np.zeros(len(self.t), dtype=bool)
        for state in self.states:
            if state.oscillates:
                self._courses |= self._oscillation(state)
            elif self.symbolic_model.is_direct(state) and state.name not in self._courses:
                self._courses[state.name] = self._course(state, self._given)
        for state in self.states:
            if state.follows_a_path:
                self._courses[state.name] = self._hysteresis(state)

    def acting(self) -> FloatArray:
        """Return the inputs with lagged slips and states, shape (n_inputs, n)."""
        if not len(self.t):
            return self.rows
        rows = self._with_slips(self.rows, {name: course.value for name, course in self.slips.items()})
        for name, course in self._courses.items():
            rows[self.index[name]] = course.value
        driven = [state for state in self.states if state.name not in self._courses]
        nodes = [self.index[state.name] for state in driven if state.is_temperature]
        driven = [state for state in driven if not state.is_temperature]
        if nodes:
            self._warm(rows, np.array(nodes), driven)
        elif driven:
            self._drive(rows, driven)
        return rows

    def acting_with_linear_forces(self, guess: Mapping[str, FloatArray], tolerance: float) -> FloatArray:
        """Return the same for forces that are linear between rows, which is faster and less exact.

        `guess`, shape (n,): time histories of states from which the iteration starts; default: 0. `tolerance`: the
        iteration ends when no value changes by more than this share of the largest one. Returns shape (n_inputs, n).
        """
        rows = self._with_slips(self.rows, {name: course.value for name, course in self.slips.items()})
        for name, course in self._courses.items():
            rows[self.index[name]] = course.value
        driven = [state for state in self.states if state.name not in self._courses]
        for state in driven:
            rows[self.index[state.name]] = guess.get(state.name, 0.0)
        indices = [self.index[state.name] for state in driven]
        for _ in range(MAX_ITERATIONS if driven else 0):
            before, lines = rows[indices], self._lines(rows)
            for state in driven:
                rows[self.index[state.name]] = self._course(state, lines).value
            if self._settled(rows[indices], before, tolerance):
                break
        return rows

    def histories_by_given_forces(self, tolerance: float) -> FloatArray:
        """Return the states if `driving` has their lines, linear between rows: one pass.

        States that read each other are iterated until they change by less than `tolerance`, as a share of their largest
        value. Returns shape (n_states, n), in the order of `states`.
        """
        values = {name: course.value for name, course in self._courses.items()}
        driven = [state for state in self.states if state.name not in self._courses]
        names = [state.name for state in driven]
        circular = any(not state.reads.isdisjoint(names[i:]) for i, state in enumerate(driven))
        lines, before = self._given, np.full((len(driven), len(self.t)), np.inf)
        for _ in range(MAX_ITERATIONS if driven else 0):
            for i, state in enumerate(driven):
                if self.driving and not state.reads.isdisjoint(names[:i]):
                    lines = self.driving(values)
                values[state.name] = self._course(state, lines).value
            after = np.stack([values[name] for name in names])
            if not circular or self._settled(after, before, tolerance):
                break
            lines, before = self.driving(values) if self.driving else lines, after
        return np.stack([values[state.name] for state in self.states])

    @staticmethod
    def _settled(values: FloatArray, before: FloatArray, tolerance: float) -> bool:
        """Return whether states, shape (n_states, n), changed by no more than a share of their largest value."""
        largest = np.abs(values).max(axis=1, keepdims=True, initial=0.0)
        return bool((np.abs(values - before) <= tolerance * largest).all())

    def _with_slips(self, rows: FloatArray, slips: Mapping[str, FloatArray]) -> FloatArray:
        rows = rows.copy()
        for name, slip in slips.items():
            rows[self.index[name]] = np.arctan(slip) if name == "alpha" else slip
        return rows

    @cached_property
    def _given(self) -> dict[str, FloatArray]:
        """The lines of the states at the given inputs, with every state 0, or for given forces."""
        return self.driving({}) if self.driving else self._lines(self.rows)

    def _lines(self, rows: FloatArray) -> dict[str, FloatArray]:
        return dict(zip(self.symbolic_model.state_lines, self.code.state_lines(rows, self.parameters), strict=True))

    def _of(self, state: State) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Return target, rate and start of a state at the given inputs."""
        target, rate, start, _ = state.line_names
        return self._given[target], self._given[rate], self._given[start]

    def _course(self, state: State, lines: Mapping[str, FloatArray]) -> Course | Accumulation:
        """Return the time history of a state that changes with time, for its lines at each row."""
        target, rate, start = (lines[name] for name in state.line_names[:3])
        begins = None
        if state.name in self.starts:
            start, begins = self.starts[state.name], self._begins
        elif state.settles and not state.has_start_value:
            start = target
        if state.settles:
            return followed(self.t, target, rate, start, hold=self.hold, begins=begins)
        return Accumulation(target, self.h, start, self.hold, self.h < 0.0 if begins is None else begins[1:])

    def _oscillation(self, state: State) -> dict[str, Part]:
        """Return the time histories of position and speed of an oscillator."""
        target, frequency, start = self._of(state)
        speed = self.symbolic_model.states[state.speed_name]
        _, damping, _ = self._of(speed)
        start = start if state.has_start_value else target
        whole = Oscillation(target, frequency, damping, self.h, start, self.hold)
        return {state.name: Part(whole, 0), speed.name: Part(whole, 1)}

    def _hysteresis(self, state: State) -> _Course:
        _, rate, start = self._of(state)
        lags = [self._courses[name] for name in state.drive]
        return PathCourse(lags, rate, start, np.flatnonzero(self.h < 0.0), state.kind)

    # ------------------------------------------------------------ temperatures

    def _warm(self, rows: FloatArray, nodes: IntArray, driven: list[State]) -> None:
        """Simulate temperatures, and states that forces at these temperatures drive; write them into the acting rows.

        `nodes`: indices of the temperatures.
        """
        starts = self._recordings()
        rows[nodes] = np.repeat(self._at_start(rows, starts)[nodes], np.diff(starts), axis=1)
        others = [self.index[state.name] for state in driven]
        for _ in range(MAX_ITERATIONS):
            if driven:
                self._drive(rows, driven)
            before = rows[nodes]
            for first, end in pairwise(starts):
                for begin in range(first, end - 1, WARM_WINDOW):
                    interval = np.arange(begin, min(begin + WARM_WINDOW, end - 1))
                    self._warm_window(rows, nodes, others, interval)
            if not driven or (np.abs(rows[nodes] - before) <= CONVERGED * np.abs(rows[nodes])).all():
                break

    @np.errstate(over="ignore", invalid="ignore")  # of values that are not accepted
    def _warm_window(self, rows: FloatArray, nodes: IntArray, others: list[int], interval: IntArray) -> None:
        """Iterate temperatures and the forces that heat the tire over the intervals that begin at some rows."""
        middle = self._nodes(interval, np.full(len(interval), 0.5), rows)
        middle[others] = rows[others][:, interval]
        names = [self.symbolic_model.inputs[i].name for i in nodes]
        x, decay, gain, matrix = rows[np.ix_(nodes, interval)].T, *[np.empty(0)] * 3
        x[:] = x[0]
        for k in range(MAX_ITERATIONS):
            middle[nodes] = x.T
            lines = self._lines(middle)
            if k == 0:
                matrix = exchange(lines, names)
                decay, gain = held_system(matrix, self.h[interval])
            flow = np.stack([lines[f"{name}_rate"] * (lines[f"{name}_target"] - x[:, i])
                             for i, name in enumerate(names)], axis=1)  # fmt: skip
            held = flow - (matrix @ x[:, :, None])[:, :, 0]
            course = vector_recursion(x[0], decay, (gain @ held[:, :, None])[:, :, 0])
            change, x = np.abs(course[:-1] - x).max(), course[:-1]
            if change <= CONVERGED * np.abs(course).max():
                break
        else:
            if len(interval) > 1:  # a single step converges at once
                for part in np.array_split(interval, 2):
                    self._warm_window(rows, nodes, others, part)
                return
        rows[np.ix_(nodes, interval + 1)] = course[1:].T

    # ------------------------------------------------------------ states that forces drive

    def _recordings(self) -> list[int]:
        """Return the rows at which recordings begin, and the number of rows."""
        return [0, *(np.flatnonzero(self.h < 0.0) + 1).tolist(), len(self.t)]

    def _at_start(self, rows: FloatArray, starts: list[int]) -> FloatArray:
        """Return the acting inputs at the start of recordings, shape (n_inputs, n_recordings)."""
        given = {name: values[starts[:-1]] for name, values in self.starts.items()}
        return equilibrium(
            self.symbolic_model, self.code, rows[:, starts[:-1]], self.parameters, self.names, given, start=True
        )

    def _drive(self, rows: FloatArray, driven: list[State]) -> None:
        """Simulate states that are driven by forces, and write them into the acting rows."""
        starts = self._recordings()
        at_start = self._at_start(rows, starts)
        indices = [self.index[state.name] for state in driven]
        for k, (first, end) in enumerate(pairwise(starts)):
            x = at_start[indices, k]
            rows[indices, first] = x
            gaps = (first + 1 + np.flatnonzero(self._begins[first + 1 : end])).tolist()
            for begin, last in pairwise([first, *gaps, end - 1]):
                steps = self._steps(begin, last, driven)
                for chunk in np.array_split(np.arange(len(steps.h)), max(1, -(-len(steps.h) // WINDOW))):
                    x = self._solve(steps.take(chunk), driven, x, rows)
                if last in gaps:
                    x = np.array([self.starts.get(state.name, rows[i])[last]
                                  for state, i in zip(driven, indices, strict=True)])  # fmt: skip
                    rows[indices, last] = x

    def _steps(self, first: int, last: int, driven: list[State]) -> Steps:
        """Return the steps from row to row; they grow with the time since the last change of the inputs."""
        # Linear inputs do not jump: lags of them need no short steps.
        courses = (*self.slips.values(), *self._courses.values()) if self.hold else ()
        moving = [course.rate for course in courses if isinstance(course, Course | Part)]
        moving += [self._of(state)[1] for state in driven if state.settles]
        fastest = np.zeros(len(self.t))
        for rate in moving:
            fastest = np.maximum(fastest, np.where(np.isfinite(rate), rate, 0.0))
        interval, rows = np.arange(first, last), self.h[first:last]
        rate = fastest[first:last] if self.hold else np.maximum(fastest[first:last], fastest[first + 1 : last + 1])
        growth = GROWTH - 1.0
        number = np.maximum(1, np.ceil(np.log1p(rate * rows * growth / FIRST_STEP) / np.log(GROWTH))).astype(int)
        interval, length = np.repeat(interval, number), np.repeat(rate * rows, number)
        rows = np.repeat(rows, number)
        k = np.arange(len(interval)) - np.repeat(np.cumsum(number) - number, number)
        last_step = k == np.repeat(number, number) - 1
        length = np.where(length > 0.0, length, 1.0)
        begin = FIRST_STEP * (GROWTH**k - 1.0) / growth / length
        end = np.where(last_step, 1.0, FIRST_STEP * (GROWTH ** (k + 1) - 1.0) / growth / length)
        return Steps(interval, begin, end, (end - begin) * rows, last_step)

    @np.errstate(over="ignore", invalid="ignore")  # of values that are not accepted
    def _solve(self, steps: Steps, driven: list[State], x: FloatArray, rows: FloatArray) -> FloatArray:
        """Solve steps, write the values at rows into the acting rows, and return the values at the end."""
        if not len(steps.h):
            return x
        interval, share = np.tile(steps.interval, 3), [steps.begin, (steps.begin + steps.end) / 2, steps.end]
        nodes = self._nodes(interval, np.concatenate(share), rows)
        indices, m = [self.index[state.name] for state in driven], len(steps.h)
        values = np.repeat(x[:, None], 3 * m, axis=1)
        for _ in range(MAX_ITERATIONS):
            nodes[indices] = values
            lines = self._lines(nodes)
            integrals = np.concatenate(
                [self._integrated(*start, lines, steps.h) for start in zip(driven, x, strict=True)]
            )
            integrals = integrals.reshape(len(driven), 3 * m)
            change = np.abs(integrals - values).max(axis=1)
            values = integrals
            if (change <= CONVERGED * np.abs(values).max(axis=1)).all():
                break
        else:
            if not (change <= ACCEPTED * np.abs(values).max(axis=1)).all():
                if np.isfinite(x).all() and (m > 1 or steps.halvings < MAX_HALVINGS):
                    for part in steps.halves():
                        x = self._solve(part, driven, x, rows)
                    return x
                values = np.full_like(values, np.nan)
        ends = values.reshape(len(driven), 3, m)[:, 2]
        at = steps.interval[steps.last] + 1
        for index, end in zip(indices, ends, strict=True):
            rows[index, at] = end[steps.last]
        return np.asarray(ends[:, -1])

    def _integrated(self, state: State, x: float, lines: Mapping[str, FloatArray], h: FloatArray) -> FloatArray:
        """Return the values of a state at start, middle and end of steps, shape (3, m)."""
        target, rate, *_ = state.line_names
        return integrated(state.settles, lines[target].reshape(3, -1), lines[rate].reshape(3, -1), h, x)

    def _nodes(self, interval: IntArray, share: FloatArray, rows: FloatArray) -> FloatArray:
        """Return the acting inputs at shares of the intervals that begin at some rows, shape (n_inputs, m).

        Temperatures are held over an interval; `rows` has them.
        """
        given = self.rows[:, interval]
        if not self.hold:
            given = given + (self.rows[:, interval + 1] - given) * share
        nodes = self._with_slips(given, {name: course.between(interval, share) for name, course in self.slips.items()})
        for name, course in self._courses.items():
            nodes[self.index[name]] = course.between(interval, share)
        for state in (state for state in self.states if state.is_temperature):
            nodes[self.index[state.name]] = rows[self.index[state.name], interval]
        return nodes
