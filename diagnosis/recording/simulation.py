"""Forces of a tire over signals and their derivatives by its coefficients, with transient slip."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from copy import copy
from dataclasses import dataclass, field

import numpy as np
import numpy.typing as npt

from tirefmu.tires.code import Code, code_for
from tirefmu.tires.states import Simulation, equilibrium
from tirefmu.tires.tire import Tire
from tirefmu.tires.transient import Course, lagged_course

from .signals import Signals

FloatArray = npt.NDArray[np.float64]
IntArray = npt.NDArray[np.intp]

#: Rows evaluated at a time: their Jacobian stays in the processor's cache.
CHUNK = 512


@dataclass
class Simulator:
    """A tire's generated code over one recording's signals.

    Parameters
    ----------
    tire : Tire
        Determines the model. All coefficients of the model are available, also those of effects that the tire lacks.
    signals : Signals
    """

    tire: Tire
    signals: Signals
    _code: Code = field(init=False)

    def __post_init__(self) -> None:
        self.book, self.rescaled = self.tire.book, self.tire.rescaled
        self._code = code_for(self.book, "c")
        self.names = list(self.book.coefficients)
        self.index = {name: i for i, name in enumerate(self.book.parameters)}
        self._inactive = self._inactive_inputs()
        known = self._code.quantities_names
        lengths = map(self.book.quantity, ("relaxation_x", "relaxation_y"))
        self._sigma = [known.index(name) for name in lengths if name]
        #: Coefficients that act through time, and the steps of their differences.
        self._by_difference = {name: self._step(name) for name in self.book.relaxation}
        own = {each.name for effect in self.book.added if effect.states for each in effect.declarations}
        self._by_difference |= {name: self._step(name) for name in own - self._by_difference.keys()}

    def _step(self, name: str) -> float:
        declaration = self.book.coefficients[name]
        if name in self.book.relaxation:
            return 0.01 if declaration.unit == "m" else 0.02
        span = declaration.upper - declaration.lower
        return 1e-4 * span if np.isfinite(span) else 1e-4

    def with_signals(self, signals: Signals) -> Simulator:
        """Return a simulator of the same tire over other signals."""
        other = copy(self)
        other.signals = signals
        return other

    def _inactive_inputs(self) -> list[tuple[int, IntArray, FloatArray]]:
        """Return input row, coefficient indices and their values for each on-demand effect that the tire lacks."""
        values, inputs = self.tire.parameters(), list(self.tire.inputs)
        inactive = []
        for effect, name in self.book.on_demand:
            if effect not in self.tire.has:
                indices = np.array([self.index[owned] for owned in self.book.owned(effect) if owned in self.index])
                inactive.append((inputs.index(name), indices, values[indices]))
        return inactive

    def active_inputs(self, parameters: FloatArray) -> FloatArray:
        """Return the inputs of all rows; inputs of on-demand effects are 0 while their coefficients are unchanged."""
        unused = [row for row, indices, values in self._inactive if np.array_equal(parameters[indices], values)]
        if not self.signals.inputs[unused].any():
            return self.signals.inputs
        inputs = self.signals.inputs.copy()
        inputs[unused] = 0.0
        return inputs

    def effective_inputs(self, parameters: FloatArray) -> FloatArray:
        """Return the inputs at the compared rows, shape (n_inputs, n), with lagged slips and states."""
        signals, inputs = self.signals, self.active_inputs(parameters)
        if not signals.timed:
            return equilibrium(self.book, self._code, inputs[:, signals.rows], parameters, self.book.states)
        slips = self._lagged(inputs, parameters)
        if not slips and not self.book.states:
            return inputs[:, signals.rows]
        book, code, t = self.book, self._code, signals.t
        simulation = Simulation(book, code, t, inputs, parameters, False, slips, book.states)
        return simulation.acting()[:, signals.rows]

    def _lagged(self, inputs: FloatArray, parameters: FloatArray) -> dict[str, Course]:
        """Return the courses of the lagged slips; none without relaxation."""
        lags = any(parameters[self.index[name]] for name in self.book.relaxation)
        if not self._sigma or not lags:
            return {}
        named = dict(zip(self.signals.names, inputs, strict=True))
        sigma = np.maximum(self._code.quantities(inputs, parameters)[self._sigma], 0.0)
        targets = {"kappa": named["kappa"], "alpha": np.tan(named["alpha"])}
        return {
            name: lagged_course(self.signals.t, target, named["V"], length, hold=False)
            for (name, target), length in zip(targets.items(), sigma, strict=True)
            if length.max() > 0.0
        }

    def forces(self, parameters: FloatArray, shifts: Mapping[str, float] | None = None) -> FloatArray:
        """Return the forces of the measured channels, shape (n_channels, n).

        Parameters
        ----------
        parameters : ndarray, shape (n_parameters,)
        shifts : mapping of str to float, optional
            Offsets added to inputs by name, as by a sensor with a zero error.
        """
        rows = self.effective_inputs(parameters)
        for name, shift in (shifts or {}).items():
            rows = rows.copy()
            rows[self.signals.names.index(name)] += shift
        return self._code.forces(rows, parameters)[self.signals.output_index]

    def at_nominal(self, role: str, parameters: FloatArray) -> float:
        """Return the quantity of a role at nominal inputs."""
        point = np.array([[self.tire.nominal(name)] for name in self.tire.inputs])
        quantity = self._code.quantities_names.index(self.book.quantity(role))
        return float(self._code.quantities(point, parameters)[quantity, 0])

    def jacobian(self, parameters: FloatArray, free: Sequence[str], at: FloatArray | None = None) -> FloatArray:
        """Return derivatives of the forces by coefficients, shape (n_channels, n, n_free)."""
        rows = self.effective_inputs(parameters)
        columns = [self.index[name] for name in free]
        parts = []
        for start in range(0, rows.shape[1], CHUNK):
            chunk = np.ascontiguousarray(rows[:, start : start + CHUNK])
            parts.append(self._code.jacobian_parameters(chunk, parameters)[:, self.signals.output_index][:, :, columns])
        jacobian = np.concatenate(parts).transpose(1, 0, 2)
        for i, name in enumerate(free):
            if name in self._by_difference and self.signals.timed:
                step = self._by_difference[name]
                moved = parameters.copy()
                moved[self.index[name]] += step
                jacobian[:, :, i] = (self.forces(moved) - self.forces(parameters)) / step
        return np.asarray(jacobian)
