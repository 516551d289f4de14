"""Forces of a tire over signals and their derivatives by its coefficients, with transient slip.

In a comparison of explanations a state follows from the recording: from its inputs and the forces at parameters that
fit it (`Simulator.driven_at`). Its course then depends on the coefficients in its own equation only, by which it is
stored. A simulator without such parameters solves states and forces together.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from copy import copy
from dataclasses import dataclass, field
from functools import lru_cache
from typing import Any

import numpy as np

from ...measurements.state_starts import estimated_starts
from ...numerics.arrays import FloatArray, IndexArray
from ...tires.code import Code, chosen_derivatives, fastest_code
from ...tires.code.given_lines import GivenLines, given_lines
from ...tires.states.equilibrium import equilibrium
from ...tires.states.simulation import StateSimulation
from ...tires.states.transient import Course, lagged_course, lateral_slip, segment_starts
from ...tires.tire import Tire
from .effect_states import amplitudes_of, groups_of
from .signals import Signals

#: Results that are remembered: those of the current and the tried parameters, each with one coefficient moved.
REMEMBERED = 4
#: Share by which the iterations of a state change its largest value last.
STATE_TOLERANCE = 1e-5
#: Courses that are stored of each group of states: those of a refit with their differences.
STORED = 16


@dataclass
class Simulator:
    """A tire's generated code over one recording's signals.

    - `tire`: determines the model. All coefficients of the model are available, also those of effects that the tire
      lacks.
    """

    tire: Tire
    signals: Signals
    _code: Code = field(init=False)
    _forces: Callable[[bytes], FloatArray] = field(init=False)
    _acting: Callable[[bytes, tuple[int, ...]], FloatArray] = field(init=False)
    _slips: Callable[[bytes, tuple[int, ...]], dict[str, Course]] = field(init=False)
    _stateful: Callable[[bytes, tuple[int, ...], tuple[str, ...]], FloatArray] = field(init=False)
    #: The courses of states for the coefficients of their equations, and what drives them.
    _stored: Callable[[bytes, tuple[int, ...], tuple[str, ...]], FloatArray] = field(init=False)
    _driving: Callable[[tuple[int, ...]], dict[str, FloatArray]] = field(init=False)
    _active: Callable[[tuple[int, ...]], FloatArray] = field(init=False)
    #: Parameters at which forces drive the states, empty for those of the trial; the states at them, (n_states, n).
    _driven_at: FloatArray = field(init=False, default_factory=lambda: np.empty(0))
    _held: FloatArray = field(init=False, default_factory=lambda: np.empty((0, 0)))

    #: The latest courses of states, from which the next iteration starts, and their times.
    _courses: dict[str, FloatArray] = field(init=False, default_factory=dict)
    _courses_at: FloatArray | None = field(init=False, default=None)

    def __post_init__(self) -> None:
        self.symbolic_model, self.rescaled = self.tire.symbolic_model, self.tire.rescaled
        self._code = fastest_code(self.symbolic_model)
        self.names = list(self.symbolic_model.coefficients)
        self.index = {name: i for i, name in enumerate(self.symbolic_model.parameters)}
        self._off = self.tire.parameters()
        self._inactive = self._inactive_inputs()
        quantity_names = self._code.quantities_names
        quantities = map(self.symbolic_model.quantity, ("relaxation_x", "relaxation_y"))
        self._sigma = [quantity_names.index(name) for name in quantities if name]
        reached = self.symbolic_model.reached(quantity_names[i] for i in self._sigma)
        self._determines_lag = np.array([name in reached for name in self.symbolic_model.parameters])
        added = [effect for effect in self.symbolic_model.added if effect.name in self.symbolic_model.relaxing_effects]
        declarations = [declaration for effect in added for declaration in effect.declarations]
        absent = [declaration.name for declaration in declarations if declaration.neutral == 0.0]
        lengths = (*self.symbolic_model.motion.relaxation, *absent)
        self._relaxation = np.array([self.index[name] for name in lengths], dtype=int)
        #: Coefficients that act through time, and the steps of their differences.
        relaxing = (declaration.name for declaration in declarations)
        self._by_difference = {name: self._step(name) for name in (*lengths, *relaxing)}
        #: Coefficients of relaxation alone.
        self._relaxing = frozenset(self._by_difference)
        self._lags = np.isin(np.arange(len(self._off)), [self.index[name] for name in self._relaxing])
        self._sizes_of_states = amplitudes_of(self.tire)
        shapes = {name for effect in self.symbolic_model.added for state in effect.states for name in state.reads}
        self._by_difference |= {name: self._step(name) for name in self.symbolic_model.coefficients.keys() & shapes}
        states = self.symbolic_model.states
        reads = {group: {name for state in group for name in states[state].reads} for group in groups_of(states)}
        #: The groups of states with the indices of the coefficients in their equations.
        self._groups = {
            group: [self.index[name] for name in sorted(read & self.index.keys())] for group, read in reads.items()
        }
        self._state_rows = [list(self.tire.inputs).index(name) for name in self.symbolic_model.states]
        self._remember()
        self._store()

    def _step(self, name: str) -> float:
        declaration = self.symbolic_model.coefficients[name]
        if name in self.symbolic_model.motion.relaxation or declaration.unit == "m":
            return 0.01 if declaration.unit == "m" else 0.02
        span = declaration.upper - declaration.lower
        return 1e-4 * span if np.isfinite(span) else 1e-4

    def _remember(self) -> None:
        """Keep the most recent forces and transient slips; a step of the estimate needs them several times."""
        self._forces = lru_cache(REMEMBERED)(self._computed_forces)
        self._acting = lru_cache(REMEMBERED)(self._computed_acting)
        self._stateful = lru_cache(REMEMBERED)(self._with_states)
        self._slips = lru_cache(REMEMBERED)(self._lagged)

    def _store(self) -> None:
        """Keep courses of states at all rows: they serve for any of these."""
        self._stored = lru_cache(STORED)(self._followed)
        self._driving = lru_cache(1)(self._driving_values)
        self._active = lru_cache(1)(self._computed_active)

    def forget(self) -> None:
        """Free the memory of what was computed; it is computed again when it is needed."""
        self._remember()
        self._store()

    def with_signals(self, signals: Signals) -> Simulator:
        """Return a simulator of the same tire over other signals."""
        other = copy(self)
        other.signals = signals
        other._remember()
        if signals.inputs is not self.signals.inputs or signals.t is not self.signals.t:
            other._store()
        return other

    def driven_at(self, parameters: FloatArray) -> Simulator:
        """Return a simulator whose states are driven by the forces at given parameters.

        So are relaxation lengths: what else than their own coefficients they depend on has these values.
        """
        other = copy(self)
        other._driven_at = np.empty(0)
        other._remember()
        every = other.with_signals(self.signals.everywhere)
        other._held = every.effective_inputs(parameters)[self._state_rows]
        other._driven_at = parameters.copy()
        other._remember()
        other._store()
        return other

    def _inactive_inputs(self) -> list[tuple[int, IndexArray, FloatArray]]:
        """Return input row, coefficient indices and their values for each on-demand effect that the tire lacks."""
        values, inputs = self.tire.parameters(), list(self.tire.inputs)
        inactive = []
        for effect, name in self.symbolic_model.on_demand:
            if effect not in self.tire.has:
                indices = np.array(
                    [self.index[owned] for owned in self.symbolic_model.owned(effect) if owned in self.index]
                )
                inactive.append((inputs.index(name), indices, values[indices]))
        return inactive

    def effective_inputs(self, parameters: FloatArray) -> FloatArray:
        """Return the inputs at the compared rows, shape (n_inputs, n), with lagged slips and states.

        Inputs of on-demand effects are 0 while their coefficients are unchanged.
        """
        unused = tuple(row for row, indices, values in self._inactive if np.array_equal(parameters[indices], values))
        if acting := self._acting_states(parameters):
            return self._stateful(parameters.tobytes(), unused, acting)
        return self._with_lagged_slips(parameters, unused)

    def _with_lagged_slips(self, parameters: FloatArray, unused: tuple[int, ...]) -> FloatArray:
        """Return the inputs at the compared rows with lagged slips, shared by all callers."""
        lags = self.signals.timed and self._sigma and parameters[self._relaxation].any()
        return self._acting(self._determining_lag(parameters) if lags else b"", unused)

    def _determining_lag(self, parameters: FloatArray) -> bytes:
        """Return parameters without differences that do not change the relaxation lengths."""
        if not len(self._driven_at):
            return np.where(self._determines_lag, parameters, self._off).tobytes()
        return np.where(self._determines_lag & self._lags, parameters, self._driven_at).tobytes()

    def _computed_active(self, unused: tuple[int, ...]) -> FloatArray:
        """Return the inputs of all rows, with 0 in unused ones."""
        if not self.signals.inputs[list(unused)].any():
            return self.signals.inputs
        inputs = self.signals.inputs.copy()
        inputs[list(unused)] = 0.0
        inputs.flags.writeable = False  # shared by all callers
        return inputs

    def _computed_acting(self, relevant: bytes, unused: tuple[int, ...]) -> FloatArray:
        """Return the inputs at the compared rows with lagged slips, for the parameters that determine them."""
        acts = np.ascontiguousarray(self._active(unused)[:, self.signals.rows])
        for name, course in self._slips(relevant, unused).items() if relevant else ():
            value = course.value[self.signals.rows]
            acts[self.signals.names.index(name)] = np.arctan(value) if name == "alpha" else value
        acts.flags.writeable = False
        return acts

    def _acting_states(self, parameters: FloatArray) -> tuple[str, ...]:
        """Return the names of the states whose effects are not switched off."""
        return tuple(
            name
            for name in self.symbolic_model.states
            if name not in self._sizes_of_states
            or not np.array_equal(parameters[self._sizes_of_states[name]], self._off[self._sizes_of_states[name]])
        )

    def _with_states(self, parameters: bytes, unused: tuple[int, ...], states: tuple[str, ...]) -> FloatArray:
        """Return the inputs at the compared rows with lagged slips and states."""
        signals, model, values, inputs = (
            self.signals,
            self.symbolic_model,
            np.frombuffer(parameters),
            self._active(unused),
        )
        if not signals.timed:
            return equilibrium(model, self._code, inputs[:, signals.rows], values, states)
        fitted = [name for name in states if model.states[name].start_is_fitted]
        if len(self._driven_at) and not fitted:
            return self._with_stored_states(values, unused, states)
        slips = self._slips(self._determining_lag(values), unused)

        def simulated(starts: Mapping[str, FloatArray]) -> FloatArray:
            simulation = StateSimulation(model, self._code, signals.t, inputs, values, False, slips, states, starts)
            guess = self._courses if signals.t is self._courses_at else {}
            rows = simulation.acting_with_linear_forces(guess, STATE_TOLERANCE)
            self._courses, self._courses_at = {name: rows[signals.names.index(name)] for name in states}, signals.t
            return rows

        rows = simulated({})
        return (self._with_fitted_starts(fitted, rows, values, simulated) if fitted else rows)[:, signals.rows]

    def _with_stored_states(self, values: FloatArray, unused: tuple[int, ...], states: tuple[str, ...]) -> FloatArray:
        """Return the inputs at the compared rows with lagged slips and states that given forces drive."""
        rows = self._with_lagged_slips(values, unused).copy()
        for group, indices in self._groups.items():
            if names := tuple(name for name in group if name in states):
                trial = self._driven_at.copy()
                trial[indices] = values[indices]
                courses = self._stored(trial.tobytes(), unused, names)
                rows[[self.signals.names.index(name) for name in names]] = courses[:, self.signals.rows]
        return rows

    def _followed(self, parameters: bytes, unused: tuple[int, ...], names: tuple[str, ...]) -> FloatArray:
        """Return the courses of states at all rows, shape (n_states, n)."""
        model, signals, values = self.symbolic_model, self.signals, np.frombuffer(parameters)
        lines, inputs = self._lines_of(names), self._active(unused)
        given = self._given(lines, values, unused)

        def driving(states: Mapping[str, FloatArray]) -> dict[str, FloatArray]:
            return lines({**given, **states}, len(signals.t))

        simulation = StateSimulation(model, self._code, signals.t, inputs, values, False, {}, names, driving=driving)
        return simulation.histories_by_given_forces(STATE_TOLERANCE)

    def _lines_of(self, states: tuple[str, ...]) -> GivenLines:
        lines = tuple(line for name in states for line in self.symbolic_model.states[name].line_names[:3])
        return given_lines(self.symbolic_model, "state_lines", lines)

    @property
    def _lag_lines(self) -> GivenLines:
        lines = tuple(self._code.quantities_names[i] for i in self._sigma)
        return given_lines(self.symbolic_model, "relaxation", lines, self._relaxing)

    def _given(self, lines: GivenLines, parameters: FloatArray, unused: tuple[int, ...]) -> dict[str, Any]:
        """Return what lines read: coefficients by name, and what drives states."""
        driving = self._driving(unused)
        return {name: parameters[self.index[name]] if name in self.index else driving[name] for name in lines.reads}

    def _driving_values(self, unused: tuple[int, ...]) -> dict[str, FloatArray]:
        """Return what lines of states may read at the parameters that drive them: inputs, quantities and forces.

        The acting inputs have the lagged slips, and the states at these parameters.
        """
        rows, at, code = self._active(unused).copy(), self._driven_at, self._code
        lags = at[self._relaxation].any() if self._sigma else False
        for name, course in self._courses_of_slips(rows, self._sigma_at(rows, at)).items() if lags else ():
            rows[self.signals.names.index(name)] = np.arctan(course.value) if name == "alpha" else course.value
        rows[self._state_rows] = self._held
        lines = [self._lines_of(group) for group in self._groups] + ([self._lag_lines] if self._sigma else [])
        read = frozenset[str]().union(*(part.reads for part in lines))
        named = [(self.signals.names, rows), (code.quantities_names, code.quantities(rows, at))]
        if read & set(self.tire.outputs):
            named.append((self.tire.outputs, code.forces(rows, at)))
        return {
            name: row.copy() for names, table in named for name, row in zip(names, table, strict=True) if name in read
        }

    def _with_fitted_starts(
        self,
        names: list[str],
        rows: FloatArray,
        parameters: FloatArray,
        simulated: Callable[[Mapping[str, FloatArray]], FloatArray],
    ) -> FloatArray:
        """Return simulated inputs in which states begin each segment with the value that the training rows determine.

        Offsets and drift of the recording are part of the residual from which these values are estimated.
        """
        signals = self.signals
        begins = segment_starts(signals.t)
        segment, indices = np.cumsum(begins) - 1, [signals.names.index(name) for name in names]
        used = signals.present & ~signals.holdout

        def residual(acting: FloatArray) -> FloatArray:
            forces = self._code.forces(acting[:, signals.rows], parameters)[signals.output_index]
            return np.where(used, signals.measured - forces, 0.0)

        def spread(values: FloatArray) -> dict[str, FloatArray]:
            return dict(zip(names, values[:, segment], strict=True))

        error = residual(rows)
        deviation = np.maximum(np.sqrt(np.mean(error**2, axis=1)), 1e-9)[:, None]
        size = np.maximum(np.sqrt(np.mean(rows[indices] ** 2, axis=1)), 1e-6)
        starts = estimated_starts(
            lambda values, none: residual(simulated(spread(values))) / deviation,
            segment[signals.rows], rows[indices][:, np.flatnonzero(begins)], size,
        )  # fmt: skip
        return simulated(spread(starts))

    def _lagged(self, relevant: bytes, unused: tuple[int, ...]) -> dict[str, Course]:
        """Return the courses of the lagged slips, for the parameters that determine them; none without relaxation."""
        inputs, parameters = self._active(unused), np.frombuffer(relevant)
        if not self._sigma or not parameters[self._relaxation].any():
            return {}
        if not len(self._driven_at):
            return self._courses_of_slips(inputs, self._sigma_at(inputs, parameters))
        lines = self._lag_lines
        sigma = lines(self._given(lines, parameters, unused), inputs.shape[1])
        return self._courses_of_slips(inputs, np.maximum(np.stack(list(sigma.values())), 0.0))

    def _sigma_at(self, inputs: FloatArray, parameters: FloatArray) -> FloatArray:
        """Return the relaxation lengths at inputs, m, shape (2, n)."""
        return np.maximum(self._code.quantities(inputs, parameters)[self._sigma], 0.0)

    def _courses_of_slips(self, inputs: FloatArray, sigma: FloatArray) -> dict[str, Course]:
        """Return the courses of the lagged slips behind relaxation lengths, shape (2, n)."""
        named = dict(zip(self.signals.names, inputs, strict=True))
        targets = {"kappa": named["kappa"], "alpha": lateral_slip(named["alpha"])}
        return {
            name: lagged_course(self.signals.t, target, named["V"], length, hold=False)
            for (name, target), length in zip(targets.items(), sigma, strict=True)
            if length.max() > 0.0
        }

    def forces(self, parameters: FloatArray, shifts: Mapping[str, float] | None = None) -> FloatArray:
        """Return the forces of the measured channels, shape (n_channels, n).

        `parameters`, shape (n_parameters,). `shifts`: offsets added to inputs by name, as by a sensor with a zero
        error.
        """
        if not shifts:
            return self._forces(parameters.tobytes())
        rows = self.effective_inputs(parameters).copy()
        for name, shift in shifts.items():
            rows[self.signals.names.index(name)] += shift
        return self._code.forces(rows, parameters)[self.signals.output_index]

    def _computed_forces(self, parameters: bytes) -> FloatArray:
        values = np.frombuffer(parameters)
        forces = self._code.forces(self.effective_inputs(values), values)[self.signals.output_index]
        forces.flags.writeable = False  # shared by all callers
        return forces

    def at_nominal(self, role: str, parameters: FloatArray) -> float:
        """Return the quantity of a role at nominal inputs."""
        point = np.array([[self.tire.nominal(name)] for name in self.tire.inputs])
        quantity = self._code.quantities_names.index(self.symbolic_model.quantity(role))
        return float(self._code.quantities(point, parameters)[quantity, 0])

    def jacobian(self, parameters: FloatArray, free: Sequence[str]) -> FloatArray:
        """Return derivatives of the forces by coefficients, shape (n_channels, n, n_free)."""
        rows = np.ascontiguousarray(self.effective_inputs(parameters))
        entries, channel, column = self._entries(tuple(free))
        jacobian = np.zeros((len(self.signals.channels), rows.shape[1], len(free)))
        jacobian[channel, :, column] = chosen_derivatives(self._code, rows, parameters, entries)
        for i, name in enumerate(free):
            if name in self._by_difference and self.signals.timed:
                step = self._by_difference[name]
                moved = parameters.copy()
                moved[self.index[name]] += step
                jacobian[:, :, i] = (self.forces(moved) - self.forces(parameters)) / step
        return jacobian

    def _entries(self, free: tuple[str, ...]) -> tuple[IndexArray, IndexArray, IndexArray]:
        """Return entries of the generated Jacobian by free coefficients, and the channel and column of each."""
        forces, coefficients = self._code.entries
        channel_of = {int(force): i for i, force in enumerate(self.signals.output_index)}
        chosen = [
            (int(entry), channel_of[int(forces[entry])], i)
            for i, name in enumerate(free)
            for entry in np.flatnonzero(coefficients == self.names.index(name))
            if int(forces[entry]) in channel_of
        ]
        entries, channels, columns = np.array(chosen, dtype=np.intp).reshape(-1, 3).T
        return entries, channels, columns
