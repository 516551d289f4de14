"""Forces of a tire over signals and their derivatives by its coefficients, with transient slip.

In a comparison of explanations a state follows from the recording: from its inputs and the forces at parameters that
fit it (`Simulator.driven_at`). Its course then depends on the coefficients in its own equation only, by which it is
stored. A simulator without such parameters solves states and forces together.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from copy import copy
from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import numpy as np

from ...measurements.state_starts import fitted_starts
from ...numerics.arrays import FloatArray, IndexArray, IntArray
from ...tires.code import chosen_derivatives, fastest_code
from ...tires.code.given_lines import GivenLines, given_lines
from ...tires.states.equilibrium import equilibrium
from ...tires.states.simulation import StateSimulation
from ...tires.states.transient import Course, lagged_course, lateral_slip
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

    def __post_init__(self) -> None:
        self.symbolic_model = model = self.tire.symbolic_model
        self._code = fastest_code(model)
        self.names = list(model.coefficients)
        self.index = {name: i for i, name in enumerate(model.parameters)}
        self._outputs = [self.tire.outputs.index(name) for name in self.signals.channels]
        self._off, inputs = self.tire.parameters(), list(self.tire.inputs)
        owned = {effect: [self.index[name] for name in model.owned(effect) & self.index.keys()]
                 for effect, _ in model.on_demand if effect not in self.tire.has}  # fmt: skip
        #: Input row and coefficients of each on-demand effect that the tire lacks.
        self._inactive = [(inputs.index(name), owned[effect]) for effect, name in model.on_demand if effect in owned]
        names = self._code.quantities_names
        self._sigma = [names.index(name) for role in ("relaxation_x", "relaxation_y") if (name := model.quantity(role))]
        reached = model.reached(names[i] for i in self._sigma)
        self._determines_lag = np.array([name in reached for name in model.parameters])
        lagging = [effect for effect in model.added if effect.name in model.relaxing_effects]
        relaxing = [declaration for effect in lagging for declaration in effect.declarations]
        lengths = (*model.motion.relaxation, *(declared.name for declared in relaxing if declared.neutral == 0.0))
        self._relaxation = [self.index[name] for name in lengths]
        #: Coefficients of relaxation alone.
        self._relaxing = frozenset((*lengths, *(declared.name for declared in relaxing)))
        self._lags = np.isin(np.arange(len(self._off)), [self.index[name] for name in self._relaxing])
        self._sizes_of_states = amplitudes_of(self.tire)
        shapes = {name for effect in model.added for state in effect.states for name in state.reads}
        #: Coefficients that act through time, and the steps of their differences.
        self._by_difference = {name: self._step(name) for name in self._relaxing | (model.coefficients.keys() & shapes)}
        #: The groups of states with the indices of the coefficients in their equations.
        self._groups = {
            group: sorted(
                {self.index[name] for state in group for name in model.states[state].reads & self.index.keys()}
            )
            for group in groups_of(model.states)
        }
        self._state_rows = [inputs.index(name) for name in model.states]
        #: Parameters at which forces drive the states, empty for those of the trial; the states at them, (n_states, n).
        self._driven_at, self._held = np.empty(0), np.empty((0, 0))
        #: The latest courses of states, from which the next iteration starts, and their times.
        self._courses, self._courses_at = dict[str, FloatArray](), np.empty(0)
        self.forget()

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

    def forget(self) -> None:
        """Free the memory of what was computed; it is computed again when it is needed."""
        self._remember()
        # Courses of slips and states at all rows for their coefficients, and what drives them: for any compared rows.
        self._slips = lru_cache(REMEMBERED)(self._lagged)
        self._stored = lru_cache(STORED)(self._followed)
        self._driving = lru_cache(1)(self._driving_values)
        self._active = lru_cache(1)(self._computed_active)

    def with_signals(self, signals: Signals) -> Simulator:
        """Return a simulator of the same tire over other signals."""
        other = copy(self)
        other.signals = signals
        if signals.inputs is self.signals.inputs and signals.t is self.signals.t:
            other._remember()
        else:
            other.forget()
        return other

    def driven_at(self, parameters: FloatArray) -> Simulator:
        """Return a simulator whose states are driven by the forces at given parameters.

        So are relaxation lengths: what else than their own coefficients they depend on has these values.
        """
        coupled, other = copy(self), copy(self)
        coupled._driven_at = np.empty(0)
        other._held = coupled.with_signals(self.signals.everywhere).effective_inputs(parameters)[self._state_rows]
        other._driven_at = parameters.copy()
        other.forget()
        return other

    def without(self, parameters: FloatArray, coefficients: Collection[str]) -> FloatArray:
        """Return parameters in which some coefficients are those of the tire, which lacks their effects."""
        absent = parameters.copy()
        indices = [self.index[name] for name in coefficients]
        absent[indices] = self._off[indices]
        return absent

    def effective_inputs(self, parameters: FloatArray) -> FloatArray:
        """Return the inputs at the compared rows, shape (n_inputs, n), with lagged slips and states.

        Inputs of on-demand effects are 0 while their coefficients are unchanged.
        """
        unused = tuple(row for row, at in self._inactive if np.array_equal(parameters[at], self._off[at]))
        if acting := self._acting_states(parameters):
            return self._stateful(parameters.tobytes(), unused, acting)
        return self._acting(self._determining_lag(parameters), unused)

    def _determining_lag(self, parameters: FloatArray) -> bytes:
        """Return parameters without differences that do not change the relaxation lengths; none if slips do not lag."""
        if not (self.signals.timed and self._sigma and parameters[self._relaxation].any()):
            return b""
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
        self._lag(acts, self._slips(relevant, unused), self.signals.rows)
        acts.flags.writeable = False
        return acts

    def _lag(self, inputs: FloatArray, slips: Mapping[str, Course], rows: IntArray | slice) -> None:
        """Replace slips in inputs by their courses at some rows."""
        for name, course in slips.items():
            value = course.value[rows]
            inputs[self.signals.names.index(name)] = np.arctan(value) if name == "alpha" else value

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
        signals, model = self.signals, self.symbolic_model
        values, inputs = np.frombuffer(parameters), self._active(unused)
        if not signals.timed:
            return equilibrium(model, self._code, inputs[:, signals.rows], values, states)
        fitted = [name for name in states if model.states[name].start_is_fitted]
        if len(self._driven_at) and not fitted:
            return self._with_stored_states(values, unused, states)
        slips = self._slips(self._determining_lag(values), unused)
        used = signals.present & ~signals.holdout

        def simulated(starts: Mapping[str, FloatArray]) -> FloatArray:
            simulation = StateSimulation(model, self._code, signals.t, inputs, values, False, slips, states, starts)
            guess = self._courses if signals.t is self._courses_at else {}
            rows = simulation.acting_with_linear_forces(guess, STATE_TOLERANCE)
            self._courses, self._courses_at = {name: rows[signals.names.index(name)] for name in states}, signals.t
            return rows

        def residual(acting: FloatArray) -> FloatArray:
            forces = self._code.forces(acting[:, signals.rows], values)[self._outputs]
            return np.where(used, signals.measured - forces, 0.0)

        rows = simulated({})
        if fitted:  # by the training rows; offsets and drift of the recording are part of the residual
            courses = {name: rows[signals.names.index(name)] for name in fitted}
            starts = fitted_starts(
                signals.t, courses, residual(rows), lambda trial, _: residual(simulated(trial)), rows=signals.rows
            )
            rows = simulated(starts)
        return rows[:, signals.rows]

    def _with_stored_states(self, values: FloatArray, unused: tuple[int, ...], states: tuple[str, ...]) -> FloatArray:
        """Return the inputs at the compared rows with lagged slips and states that given forces drive."""
        rows = self._acting(self._determining_lag(values), unused).copy()
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
        if self._sigma and at[self._relaxation].any():
            self._lag(rows, self._courses_of_slips(rows, self._sigma_at(rows, at)), slice(None))
        rows[self._state_rows] = self._held
        lines = [self._lines_of(group) for group in self._groups] + ([self._lag_lines] if self._sigma else [])
        read = frozenset[str]().union(*(part.reads for part in lines))
        named = [(self.signals.names, rows), (code.quantities_names, code.quantities(rows, at))]
        if read & set(self.tire.outputs):
            named.append((self.tire.outputs, code.forces(rows, at)))
        return {
            name: row.copy() for names, table in named for name, row in zip(names, table, strict=True) if name in read
        }

    def _lagged(self, relevant: bytes, unused: tuple[int, ...]) -> dict[str, Course]:
        """Return the courses of the lagged slips, for the parameters that determine them (`_determining_lag`)."""
        if not relevant:
            return {}
        inputs, parameters = self._active(unused), np.frombuffer(relevant)
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

    def forces(self, parameters: FloatArray) -> FloatArray:
        """Return the forces of the measured channels, shape (n_channels, n); `parameters`, shape (n_parameters,)."""
        return self._forces(parameters.tobytes())

    def _computed_forces(self, parameters: bytes) -> FloatArray:
        values = np.frombuffer(parameters)
        forces = self._code.forces(self.effective_inputs(values), values)[self._outputs]
        forces.flags.writeable = False  # shared by all callers
        return forces

    def growth(self, name: str, parameters: FloatArray) -> FloatArray:
        """Return the change of the forces per relative change of an input beside equal slips and states, as forces."""
        rows, step = self.effective_inputs(parameters).copy(), 0.01
        rows[self.signals.names.index(name)] *= 1.0 + step
        return (self._code.forces(rows, parameters)[self._outputs] - self.forces(parameters)) / step

    def at_nominal(self, role: str, parameters: FloatArray) -> float:
        """Return the quantity of a role at nominal inputs."""
        point = np.array([[self.tire.nominal(name)] for name in self.tire.inputs])
        quantity = self._code.quantities_names.index(self.symbolic_model.quantity(role))
        return float(self._code.quantities(point, parameters)[quantity, 0])

    def jacobian(self, parameters: FloatArray, free: Sequence[str]) -> FloatArray:
        """Return derivatives of the forces by coefficients, shape (n_channels, n, n_free)."""
        rows = np.ascontiguousarray(self.effective_inputs(parameters))
        entries, channel, column = self._entries(tuple(free))
        jacobian = np.zeros(
            (len(self.signals.channels), len(free), rows.shape[1])
        )  # coefficients have rows in one place
        jacobian[channel, column] = chosen_derivatives(self._code, rows, parameters, entries)
        for i, name in enumerate(free):
            if name in self._by_difference and self.signals.timed:
                step = self._by_difference[name]
                moved = parameters.copy()
                moved[self.index[name]] += step
                jacobian[:, i] = (self.forces(moved) - self.forces(parameters)) / step
        return jacobian.swapaxes(1, 2)

    def _entries(self, free: tuple[str, ...]) -> tuple[IndexArray, IndexArray, IndexArray]:
        """Return entries of the generated Jacobian by free coefficients, and the channel and column of each."""
        forces, coefficients = self._code.entries
        channel_of = {force: i for i, force in enumerate(self._outputs)}
        chosen = [
            (int(entry), channel_of[int(forces[entry])], i)
            for i, name in enumerate(free)
            for entry in np.flatnonzero(coefficients == self.names.index(name))
            if int(forces[entry]) in channel_of
        ]
        entries, channels, columns = np.array(chosen, dtype=np.intp).reshape(-1, 3).T
        return entries, channels, columns
