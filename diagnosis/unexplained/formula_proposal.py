"""Formulas for what no effect of the library explains: features and products of two features at locations of the model.

A formula becomes a proposed effect: its file, and the model with it.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from typing import ClassVar

import numpy as np

from ...boundary.errors import EffectError
from ...numerics.arrays import FloatArray
from ...numerics.ties import graded
from ...symbolic.added import AddedEffect, effect_from
from ...tires.tire import Tire
from ..least_squares import LeastSquares, Solution
from ..probing.effect_probing import Screen
from ..signals.simulation import Simulator
from .features import Feature, Location, bracketed, determined, directions, features, locations_of
from .past import STATES


@dataclass(frozen=True)
class Unknown:
    """Structure that no candidate effect explains.

    - `formula`: as in an effect file: "quantity, factor or term: formula".
    - `added`: whether the improved tire contains it: only if it predicts the hold-out set better.
    - `effect`: the proposed effect file.
    - `not_added_because`: reason; "" if it was added.
    - `next_measurement`: the measurement that determines its form.
    """

    JSON_KEYS: ClassVar = ("depends_on", "formula", "added", "file", "not_added_because")

    depends_on: tuple[str, ...]
    formula: str
    added: bool
    effect: AddedEffect | None = None
    not_added_because: str = ""
    next_measurement: str = ""

    @property
    def file(self) -> str | None:
        """The name of the file of the proposed effect, if there is one."""
        return f"{self.effect.name}.toml" if self.effect else None


@dataclass(frozen=True, eq=False)
class AddedFormula:
    """A proposed formula that was added to the model.

    - `tire`: the baseline model with the effect of the formula.
    """

    effect: AddedEffect
    tire: Tire
    problem: LeastSquares
    solution: Solution


def effect_of(structure: UnexplainedStructure) -> AddedEffect:
    """Return structure as an effect; rates and memories become states."""
    location, depends_on = structure.location, structure.depends_on
    numbered = {f"FOUND{number}": term for number, term in enumerate(structure.terms, start=1)}
    total = " + ".join(f"{name}*({term.in_effect_file})" for name, term in numbered.items())
    value = f"1 + {total}" if location.how == "factor" else f"{location.per}{'*' * bool(location.per)}({total})"
    bounds = [max(abs(float(size)), 1e-4) * COEFFICIENT_BOUND_FACTOR for size in structure.sizes]
    flips = {"flips": True} if location.flips else {}
    name = "found_" + "_".join(re.sub(r"\W", "", variable) for variable in depends_on).lower()
    table = {
        "name": name,
        "physics": f"{location.name} changes with {', '.join(depends_on)}",
        "source": "proposed by the diagnosis of a recording",
        "coefficients": {
            coefficient: {"description": f"found: {term.text}", "unit": "1", "lower": -bound, "upper": bound, **flips}
            for (coefficient, term), bound in zip(numbered.items(), bounds, strict=True)
        },
        "states": {state: dict(STATES[state]) for term in structure.terms for state in term.states},
        "acts": [{"on": quantity, location.how: value} for quantity in location.quantities],
    }
    return effect_from(table, f"{name}.toml")


def unknown_of(structure: UnexplainedStructure, effect: AddedEffect, added: AddedFormula | str) -> Unknown:
    """Return the report of structure that no candidate effect explains.

    `effect`: result of `effect_of`. `added`: result of `with_formula`.
    """
    formula = structure.formula
    if isinstance(added, AddedFormula):
        index = added.problem.simulator.index
        formula = structure.formula_with(
            [added.solution.parameters[index[declaration.name]] for declaration in added.effect.declarations]
        )
    measurements = [_MEASUREMENTS[name] for name in structure.depends_on if name in _MEASUREMENTS]
    reason = "" if isinstance(added, AddedFormula) else added
    return Unknown(
        structure.depends_on, formula, isinstance(added, AddedFormula), effect, reason,
        measurements[0] if measurements else "",
    )  # fmt: skip


#: Measurement that determines the form of structure that depends on a rate. Relaxation depends on the distance rolled,
#: a delay on time, friction within the carcass on the direction only.
_MEASUREMENTS = {
    "dalpha/dt": "sweep alpha at three rates and two speeds, up and down",
    "dkappa/dt": "sweep kappa at three rates and two speeds, up and down",
    "dFz/dt": "step the load at constant slip, at two speeds",
    "memory": "hold the slip after a sweep, and repeat the sweep after a rest",
}


def with_formula(
    structure: UnexplainedStructure, effect: AddedEffect, start: Tire, problem: LeastSquares, solution: Solution
) -> AddedFormula | str:
    """Add a formula to the model.

    `effect`: result of `effect_of`. `solution`: solution without the formula. Returns: otherwise the reason why the
    model cannot contain the formula.
    """
    try:
        tire = replace(start, added=(*start.added, effect))
        simulator = Simulator(tire, problem.simulator.signals.with_inputs_of(tire))  # the states are inputs
    except EffectError as error:
        return f"the model cannot contain the formula: {error}"
    parameters = tire.parameters()
    for name in problem.simulator.names:
        parameters[simulator.index[name]] = solution.parameters[problem.simulator.index[name]]
    for declaration, size in zip(effect.declarations, structure.sizes, strict=True):
        parameters[simulator.index[declaration.name]] = size
    extended = replace(problem, simulator=simulator.driven_at(parameters))
    free = (*solution.free, *(declaration.name for declaration in effect.declarations))
    return AddedFormula(effect, tire, extended, extended.solve(parameters, free, iterations=8))


@dataclass(frozen=True, eq=False)
class UnexplainedStructure:
    """A sum of features that acts on quantities of the model.

    - `sizes`: the estimated coefficient of each term.
    """

    location: Location
    terms: tuple[Feature, ...]
    sizes: tuple[float, ...]

    @property
    def depends_on(self) -> tuple[str, ...]:
        """The variables, sorted."""
        return tuple(sorted(frozenset(self.location.proportional_to).union(*(term.depends_on for term in self.terms))))

    @property
    def formula(self) -> str:
        """The formula as text."""
        return self.formula_with(self.sizes)

    def formula_with(self, sizes: Iterable[float]) -> str:
        """Return the formula with given coefficients.

        `sizes`: one per term.
        """
        terms = " ".join(f"{value:+.3g}*{bracketed(term.text)}" for value, term in zip(sizes, self.terms, strict=True))
        head = "1 " if self.location.how == "factor" else ""
        return f"{' and '.join(self.location.quantities)}, {self.location.how}: {head}{terms}"


#: Number of features whose evidence is computed. Convention: computing time.
SHORTLIST = 60
#: Bounds of a formula's coefficient as multiples of its estimate. Convention.
COEFFICIENT_BOUND_FACTOR = 10.0

#: Rows from which features are shortlisted. Convention: computing time.
SHORTLIST_ROWS = 1500


class Dictionary:
    """Features and products of two features at the locations of the model.

    - `terms`: each location with a feature.
    - `acting`: change of the forces per unit of a feature, by location, shape (n_channels, n).
    """

    def __init__(self, screen: Screen) -> None:
        problem, signals = screen.problem, screen.signals
        self._weights = problem.inverse_noise
        tire = problem.simulator.tire
        even, odd = features(signals, tire)
        simple = [feature for feature in even if feature.expressible]
        pairs = [feature * other for i, feature in enumerate(simple) for other in simple[i:]]
        odd_pairs = [feature * other for feature in odd for other in simple]
        self.acting = directions(problem.simulator, screen.solution.parameters)
        self.terms: list[tuple[Location, Feature]] = [
            (location, feature)
            for location in locations_of(problem.simulator.symbolic_model)
            if np.any(self._weights * self.acting[location.name])
            for feature in ([*even, *pairs] if location.how == "factor" else [*odd, *odd_pairs, *even])
            if determined(location, feature, signals, tire)
        ]

    def column(self, i: int) -> FloatArray:
        """Return the change of the forces per unit of a term, N and N m, shape (n_channels, n)."""
        location, feature = self.terms[i]
        return np.asarray(self.acting[location.name] * feature.values)

    def shortlisted(self, screen: Screen, chosen: Sequence[int]) -> list[int]:
        """Return those of the chosen terms that explain most of a residual, each alone and from some rows."""
        rows = slice(None, None, max(1, screen.residual.shape[1] // SHORTLIST_ROWS))
        acting = {name: (self._weights * response)[:, rows] for name, response in self.acting.items()}
        columns = [acting[self.terms[i][0].name] * self.terms[i][1].values[rows] for i in chosen]
        rest = screen.residual[:, rows].ravel()
        flat = np.stack(columns, axis=-1).reshape(len(rest), -1)
        tangent = screen.tangent[:, rows].reshape(len(rest), -1)
        matrix = tangent.T @ tangent + np.diag(screen.prior_precision)
        inner = np.linalg.solve(matrix, tangent.T @ flat)
        total = np.einsum("nk,nk->k", flat, flat)
        power = total - np.einsum("qk,qk->k", tangent.T @ flat, inner)
        target = flat.T @ rest - inner.T @ (tangent.T @ rest)
        independent = power > 1e-3 * total
        scores = np.where(independent, target**2 / np.where(independent, power, 1.0), 0.0)
        return [chosen[k] for k in np.argsort(-graded(scores), kind="stable")[:SHORTLIST]]
