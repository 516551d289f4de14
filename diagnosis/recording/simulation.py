"""Forces of a tire over signals, and their derivatives by its coefficients, relaxation included."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from copy import copy
from dataclasses import dataclass, field

import numpy as np
import numpy.typing as npt

from tirefmu.tires.code import Code, code_for
from tirefmu.tires.tire import Tire
from tirefmu.tires.transient import lagged

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
        Names the model; every coefficient of its book is at hand, whatever its effects.
    signals : Signals
    """

    tire: Tire
    signals: Signals
    _code: Code = field(init=False)

    def __post_init__(self) -> None:
        self.book, self.rescaled = self.tire.book, self.tire.rescaled
        self._code = code_for(self.book, "c")
        self.names = list(self.book.coefficients)
        self.place = {name: i for i, name in enumerate(self.book.parameters)}
        self._unasked = self._inputs_unasked()
        known = self._code.quantities_names
        lengths = map(self.book.quantity, ("relaxation_x", "relaxation_y"))
        self._sigma = [known.index(name) for name in lengths if name]

    def over(self, signals: Signals) -> Simulator:
        """Return a simulator of the same tire over other signals."""
        other = copy(self)
        other.signals = signals
        return other

    def _inputs_unasked(self) -> list[tuple[int, IntArray, FloatArray]]:
        """Return, of effects on demand that the tire lacks: the input's row, its coefficients' places, their values."""
        values, inputs = self.tire.parameters(), list(self.tire.inputs)
        told = []
        for effect, name in self.book.on_demand:
            if effect not in self.tire.has:
                places = np.array([self.place[owned] for owned in self.book.owned(effect) if owned in self.place])
                told.append((inputs.index(name), places, values[places]))
        return told

    def asked(self, parameters: FloatArray) -> FloatArray:
        """Return the inputs of all rows, 0 where they ask for an effect whose coefficients are at rest."""
        silent = [row for row, places, values in self._unasked if np.array_equal(parameters[places], values)]
        if not self.signals.inputs[silent].any():
            return self.signals.inputs
        inputs = self.signals.inputs.copy()
        inputs[silent] = 0.0
        return inputs

    def acting(self, parameters: FloatArray) -> FloatArray:
        """Return the inputs that act at the compared rows, shape (n_inputs, n): slips lag where lengths are set."""
        signals, inputs = self.signals, self.asked(parameters)
        lags = any(parameters[self.place[name]] for name in self.book.relaxation)
        if not signals.timed or not self._sigma or not lags:
            return inputs[:, signals.rows]
        named = dict(zip(signals.names, inputs, strict=True))
        sigma = np.maximum(self._code.quantities(inputs, parameters)[self._sigma], 0.0)
        acts = inputs.copy()
        for name, length in zip(("kappa", "alpha"), sigma, strict=True):
            if length.max() > 0.0:
                slip = np.tan(named[name]) if name == "alpha" else named[name]
                lag = lagged(signals.t, slip, named["V"], length, hold=False)
                acts[signals.names.index(name)] = np.arctan(lag) if name == "alpha" else lag
        return acts[:, signals.rows]

    def forces(self, parameters: FloatArray, shifts: Mapping[str, float] | None = None) -> FloatArray:
        """Return the forces of the measured channels, shape (n_channels, n).

        Parameters
        ----------
        parameters : ndarray, shape (n_parameters,)
        shifts : mapping of str to float, optional
            Added to inputs by name: what a sensor's zero offset does.
        """
        rows = self.acting(parameters)
        for name, shift in (shifts or {}).items():
            rows = rows.copy()
            rows[self.signals.names.index(name)] += shift
        return self._code.forces(rows, parameters)[self.signals.places]

    def at_nominal(self, role: str, parameters: FloatArray) -> float:
        """Return the quantity of a role at nominal inputs."""
        point = np.array([[self.tire.nominal(name)] for name in self.tire.inputs])
        quantity = self._code.quantities_names.index(self.book.quantity(role))
        return float(self._code.quantities(point, parameters)[quantity, 0])

    def jacobian(self, parameters: FloatArray, free: Sequence[str], at: FloatArray | None = None) -> FloatArray:
        """Return derivatives of the forces by coefficients, shape (n_channels, n, n_free)."""
        rows = self.acting(parameters)
        columns = [self.place[name] for name in free]
        parts = []
        for start in range(0, rows.shape[1], CHUNK):
            whole = self._code.jacobian_parameters(np.ascontiguousarray(rows[:, start : start + CHUNK]), parameters)
            parts.append(whole[:, self.signals.places][:, :, columns])
        jacobian = np.concatenate(parts).transpose(1, 0, 2)
        for i, name in enumerate(free):
            if name in self.book.relaxation and self.signals.timed:
                step = 0.01 if self.book.coefficients[name].unit == "m" else 0.02
                moved = parameters.copy()
                moved[self.place[name]] += step
                jacobian[:, :, i] = (self.forces(moved) - self.forces(parameters)) / step
        return np.asarray(jacobian)
