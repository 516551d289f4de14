"""Verification of the constraints of a fit: grids on which they are imposed and verified, violations, margins."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from math import inf

import numpy as np

from ...numerics.arrays import FloatArray
from ...numerics.ties import graded
from ...tires.code import fastest_code
from ...tires.tire import Tire
from .constraint_functions import measured_values
from .local_extrema import local_extrema
from .physical import TOLERANCE, Constraint, grid

#: Densities of the grid for verification in final and intermediate stages; largest number of points that are added at
#: a time for a violated constraint.
VERIFIED, APPROACHED, MAX_ADDED = 4, 2, 12
#: Decimal digits of the margin to which the points of one extremum agree.
EQUAL_DIGITS = 9
#: Margin on the grid, in sizes of the constraint, below which a violation is sought between the grid points after each
#: solution. Between two grid points the quantities change by less; the final margins are sought for all constraints.
NEAR = 0.1
#: A constraint and the points at which it is imposed, shape (n_inputs, n_points).
ConstraintPoints = tuple[Constraint, FloatArray]


@dataclass(frozen=True)
class Margin:
    """The smallest margin of a constraint, verified on a denser grid than it was imposed on, and between its points.

    - `constraint`: as a formula: ``E_x <= 1``.
    - `worst`: value of the quantity, or of its change with load, at the smallest margin.
    - `margin`: distance to the bound; negative if the constraint is violated.
    - `at`: the inputs at the smallest margin.
    - `name`: name by which it is selected: ``curvature:E_x``.
    """

    constraint: str
    worst: float
    margin: float
    at: dict[str, float]
    name: str = ""


class VerifiedConstraints:
    """Constraints of a tire over its operating range.

    `tire`: a tire with the model, effects and nominal values of the fit. `by_output`: constraints of each output; those
    of effects that the tire does not have are omitted. `ranges`: smallest and largest value of each input.
    """

    def __init__(
        self, tire: Tire, by_output: Mapping[str, Sequence[Constraint]], ranges: Mapping[str, tuple[float, float]]
    ) -> None:
        self._model, self._inputs, self._ranges = tire.symbolic_model, tire.inputs, dict(ranges)
        self._nominal = {name: tire.nominal(name) for name in tire.inputs}
        self._by_output = {
            output: [constraint for constraint in constraints if not constraint.effect or constraint.effect in tire.has]
            for output, constraints in by_output.items()
        }
        self._grids: dict[tuple[tuple[str, ...], bool, int], FloatArray] = {}
        #: Parameters, and all quantities for them by grid.
        self._evaluated: tuple[FloatArray, dict[int, tuple[FloatArray, FloatArray]]] = (np.zeros(0), {})

    def of(self, outputs: Sequence[str], *, density: int = 0) -> list[ConstraintPoints]:
        """Return the constraints of some outputs with a grid: its corners to impose them, denser to verify them."""
        pairs = []
        for constraint in (item for output in outputs for item in self._by_output.get(output, ())):
            key = constraint.varied, constraint.kind == "extrapolation", density
            if key not in self._grids:
                self._grids[key] = grid(constraint, self._ranges, self._nominal, density=density)
            pairs.append((constraint, self._grids[key]))
        return pairs

    def violations(self, pairs: Sequence[ConstraintPoints], parameters: FloatArray) -> list[ConstraintPoints]:
        """Return the worst points of each violated constraint, also between the grid points."""
        violated = []
        for constraint, on_grid in pairs:
            points, values = self._with_extrema(constraint, on_grid, parameters, NEAR)
            distance = constraint.distance(values)
            outside = np.flatnonzero(distance < -TOLERANCE)
            # Equal values are one extremum at different values of an input without influence.
            outside = outside[np.unique(np.round(distance[outside], EQUAL_DIGITS), return_index=True)[1]]
            if outside.size:
                order = outside[np.argsort(distance[outside], kind="stable")]
                some = np.unique(np.linspace(0, len(order) - 1, MAX_ADDED).astype(int))
                violated.append((constraint, points[:, order[some]]))
        return violated

    def margins(self, outputs: Sequence[str], parameters: FloatArray) -> tuple[Margin, ...]:
        """Verify all constraints on a grid denser than the one on which they were imposed, and between its points."""
        margins = []
        for constraint, on_grid in self.of(outputs, density=VERIFIED):
            points, values = self._with_extrema(constraint, on_grid, parameters)
            distance = constraint.distance(values)
            worst = int(np.argmin(graded(distance)))
            at = {name: float(points[i, worst]) for i, name in enumerate(self._inputs) if name in constraint.varied}
            margins.append(Margin(constraint.text, float(values[worst]), float(distance[worst]), at, constraint.name))
        return tuple(margins)

    def _with_extrema(
        self, constraint: Constraint, points: FloatArray, parameters: FloatArray, near: float = inf
    ) -> tuple[FloatArray, FloatArray]:
        """Return the points of a grid and the values at them, with the local extrema if a margin is small."""
        values = self._values(constraint, points, parameters)
        distance = constraint.distance(values)
        if np.min(distance) > near * constraint.size:
            return points, values
        between, extrema = local_extrema(self._model, constraint, points, distance, self._ranges, parameters)
        # Extrema first: they are chosen before the grid points from which they differ by less than ties do.
        return np.concatenate([between, points], axis=1), np.concatenate([extrema, values])

    def _values(self, constraint: Constraint, points: FloatArray, parameters: FloatArray) -> FloatArray:
        """Return the values that a constraint bounds; quantities on one grid are evaluated together."""
        if constraint.measure != "value":
            return measured_values(self._model, constraint, points, parameters)
        code = fastest_code(self._model)
        if not np.array_equal(self._evaluated[0], parameters):
            self._evaluated = parameters.copy(), {}
        grids = self._evaluated[1]
        if id(points) not in grids:
            grids[id(points)] = points, code.quantities(points, parameters)
        values: FloatArray = grids[id(points)][1][code.quantities_names.index(constraint.quantity)]
        return values
