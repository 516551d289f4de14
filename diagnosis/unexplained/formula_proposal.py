"""Formulas for what no effect of the library explains: features and products of two features at locations of the model.

A formula becomes a proposed effect: its file, and the model with it.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import ClassVar

import numpy as np

from ...boundary.errors import EffectError
from ...numerics.arrays import FloatArray
from ...numerics.ties import graded
from ...symbolic.added import AddedEffect, effect_from
from ..least_squares import LeastSquares, Solution
from ..probing.effect_probing import Screen
from .features import STATES, Feature, Location, bracketed, directions, features, placed


@dataclass(frozen=True)
class Unknown:
    """Structure that no candidate effect explains.

    - `formula`: as in an effect file: "quantity, factor or term: formula".
    - `added`: whether the improved tire contains it: only if the recording proves it, and the tire
      with it is delivered.
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


def effect_of(structure: UnexplainedStructure) -> AddedEffect:
    """Return structure as an effect; rates and memories become states."""
    location, depends_on = structure.location, structure.depends_on
    numbered = {f"FOUND{number}": term for number, term in enumerate(structure.terms, start=1)}
    total = " + ".join(f"{name}*({term.formula})" for name, term in numbered.items())
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


def proposed(
    structure: UnexplainedStructure, problem: LeastSquares, solution: Solution, against: str = ""
) -> tuple[Unknown, tuple[LeastSquares, Solution] | None]:
    """Return the report of structure that no candidate effect explains, and the model with its formula if possible.

    `solution`: without the formula. `against`: the reason why it may not be added to the model, if any.
    """
    effect, added = effect_of(structure), None
    names = [declaration.name for declaration in effect.declarations]
    if not against:
        try:
            extended, parameters = problem.with_effect(effect, solution, dict(zip(names, structure.sizes, strict=True)))
        except EffectError as error:
            against = f"the model cannot contain the formula: {error}"
        else:
            fitted = extended.solve(parameters, (*solution.free, *names), iterations=8)
            sizes = fitted.parameters[[extended.simulator.index[name] for name in names]]
            structure, added = replace(structure, sizes=tuple(sizes.tolist())), (extended, fitted)
    measurement = next((_MEASUREMENTS[name] for name in structure.depends_on if name in _MEASUREMENTS), "")
    return Unknown(structure.depends_on, structure.formula, not against, effect, against, measurement), added


#: Measurement that determines the form of structure that depends on a rate. Relaxation depends on the distance rolled,
#: a delay on time, friction within the carcass on the direction only.
_MEASUREMENTS = {
    "dalpha/dt": "sweep alpha at three rates and two speeds, up and down",
    "dkappa/dt": "sweep kappa at three rates and two speeds, up and down",
    "dFz/dt": "step the load at constant slip, at two speeds",
    "memory": "hold the slip after a sweep, and repeat the sweep after a rest",
}


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
        terms = zip(self.sizes, self.terms, strict=True)
        total = " ".join(f"{value:+.3g}*{bracketed(term.text)}" for value, term in terms)
        head = "1 " if self.location.how == "factor" else ""
        return f"{' and '.join(self.location.quantities)}, {self.location.how}: {head}{total}"


#: Number of features whose evidence is computed. Convention: computing time.
SHORTLIST = 60
#: Bounds of a formula's coefficient as multiples of its estimate. Convention.
COEFFICIENT_BOUND_FACTOR = 10.0

#: Rows from which features are shortlisted. Convention: computing time.
SHORTLIST_ROWS = 1500


class Dictionary:
    """Features and products of two features at the locations of the model.

    - `terms`: each location with a feature.
    - `acting`: change of the forces per unit of a feature, shape (n_channels, n); see `directions`.
    """

    def __init__(self, screen: Screen) -> None:
        problem, signals = screen.problem, screen.signals
        self._weights = problem.inverse_noise
        even, odd = features(signals, problem.simulator.tire)
        simple = [feature for feature in even if not feature.states]
        pairs = [feature * other for i, feature in enumerate(simple) for other in simple[i:]]
        odd_pairs = [feature * other for feature in odd for other in simple]
        self.acting = directions(problem.simulator, screen.solution.parameters)
        self.terms = [
            (location, feature)
            for location, feature in placed(problem.simulator, [*even, *pairs], [*odd, *odd_pairs, *even])
            if np.any(self._weights * self.acting[location.name, feature.inclined])
        ]

    def column(self, i: int) -> FloatArray:
        """Return the change of the forces per unit of a term, N and N m, shape (n_channels, n)."""
        location, feature = self.terms[i]
        return np.asarray(self.acting[location.name, feature.inclined] * feature.values)

    def shortlisted(self, screen: Screen, chosen: Sequence[int]) -> list[int]:
        """Return those of the chosen terms that explain most of a residual, each alone and from some rows."""
        rows = slice(None, None, max(1, screen.residual.shape[1] // SHORTLIST_ROWS))
        acting = {place: (self._weights * response)[:, rows] for place, response in self.acting.items()}
        places = [(self.terms[i][0].name, self.terms[i][1]) for i in chosen]
        columns = [acting[name, feature.inclined] * feature.values[rows] for name, feature in places]
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
