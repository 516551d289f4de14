"""The linear problem at the refit of an explanation: what the explanation contains, and what could be added to it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
import numpy.typing as npt

from tirefmu.symbolic.detection import Form

from ..least_squares import LeastSquares, Solution
from ..probing.candidates import Candidate, is_testable, refinements_for
from ..probing.effect_probing import probed, unfitted
from ..recording.simulation import Simulator
from ..thresholds import EFFECT_ODDS, FORM_ERROR, UNKNOWN_SHARE
from ..unexplained.features import determined, directions, features, locations_of
from ..unexplained.structure import CORE_INPUTS
from .discrepancy import bench_errors, effect_discrepancy
from .evidence import NormalEquations
from .explanation import UNKNOWN, Explanation, Term

FloatArray = npt.NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Addition:
    """A form of an effect at a point of its grid, or a term of the unknown component, that could be added.

    - `columns`, shape (n_channels, n, k): change of the forces, N and N m.
    - `deviation`, shape (k,): of the priors of their coefficients.
    - `log_prior`: logarithm of the prior odds of the explanation with it.
    """

    name: str
    part: Form | Term
    columns: FloatArray
    deviation: FloatArray
    log_prior: float


@dataclass(frozen=True, eq=False)
class Linearization:
    """Columns of an explanation at a solution.

    - `problem`: with the common noise, the disturbances, and the terms of the unknown component.
    """

    explanation: Explanation
    problem: LeastSquares
    solution: Solution
    candidates: Mapping[str, Candidate]

    @property
    def simulator(self) -> Simulator:
        """Of the recording with the inputs delayed by the skew."""
        return self.problem.simulator

    @cached_property
    def forces(self) -> FloatArray:
        """Of the solution, shape (n_channels, n)."""
        return self.simulator.forces(self.solution.parameters)

    @cached_property
    def skew_index(self) -> int:
        """The index of the skew among the columns of `equations`."""
        return len(self.problem.disturbances.names) + len(self._inside)

    @cached_property
    def _inside(self) -> tuple[str, ...]:
        """The coefficients that are not at a bound; others are constants of the linear problem."""
        bounded = self.problem.at_bounds(self.solution.parameters, self.solution.free, neutral=True)
        return tuple(name for name in self.solution.free if name not in bounded)

    def equations(self, additions: Sequence[Addition] = ()) -> NormalEquations:
        """Return the normal equations of everything that the explanation contains, and of additions."""
        problem = self.problem
        columns, deviation, distance = self._contained
        added = [each.columns for each in additions]
        misfit = problem.misfit(self.solution.parameters)[:, :, None]
        weighted = problem.weighted(np.concatenate([columns, *added, misfit], axis=-1))
        flat = weighted.reshape(-1, weighted.shape[-1])
        first, products = problem.disturbance_products
        cross = first.T @ flat
        matrix = np.block([[products, cross], [cross.T, flat.T @ flat]])
        deviations = np.concatenate(
            [problem.disturbances.deviation, deviation, *(each.deviation for each in additions)]
        )
        distances = np.zeros(len(deviations))
        distances[len(first.T) : len(first.T) + len(distance)] = distance
        power = float(matrix[-1, -1]) + float(np.sum(distances**2))
        return NormalEquations(matrix[:-1, :-1], matrix[:-1, -1], power, deviations**-2.0, -distances / deviations)

    @property
    def contained(self) -> FloatArray:
        """What the explanation contains beside the disturbances, N and N m, shape (n_channels, n, k)."""
        return self._contained[0]

    @cached_property
    def _contained(self) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Columns beside the disturbances, their prior deviations, and distances from the means in deviations.

        Coefficients, errors of the bench (the skew is the first), refinements of all forms, and discrepancies of the
        effects.
        """
        simulator, solution, free = self.simulator, self.solution, self._inside
        center, deviation = (one[[name in free for name in solution.free]] for one in self.problem.prior(solution.free))
        values = solution.parameters[[simulator.index[name] for name in free]]
        bench, of_bench = bench_errors(simulator, solution.parameters)
        refined = [self._probes(form) for form in self._refinements()]
        forms = [
            effect_discrepancy(simulator.signals, self._response(name), self.candidates[name].requires)
            for name in self.explanation.effects
        ]
        parts = [simulator.jacobian(solution.parameters, free), bench, *(columns for columns, _ in refined)]
        deviations = [deviation, of_bench, *(one for _, one in refined)]
        deviations += [np.full(one.shape[-1], FORM_ERROR) for one in forms]
        whole = np.concatenate(deviations)
        distance = np.zeros(len(whole))
        distance[: len(values)] = (values - center) / deviation
        if len(of_bench):
            distance[len(values)] = simulator.signals.skew / of_bench[0]
        return np.concatenate([*parts, *forms], axis=-1), whole, distance

    def _response(self, effect: str) -> FloatArray:
        """Return the change of the forces by an effect of the explanation, shape (n_channels, n)."""
        simulator, absent = self.simulator, self.solution.parameters.copy()
        free = [name for effect_name, form in self.explanation.forms if effect_name == effect for name in form.free]
        owned = [
            simulator.index[name] for name in {*free, *simulator.symbolic_model.owned(effect)} & simulator.index.keys()
        ]
        absent[owned] = simulator.tire.parameters()[owned]
        return np.asarray(np.nan_to_num(self.forces - simulator.forces(absent)))

    def _refinements(self) -> list[Form]:
        found = refinements_for(self.simulator.tire, frozenset(self.explanation.effects))
        forms = [unfitted(form, self.simulator, self.solution.free) for _, form in found]
        return [form for form in forms if form is not None]

    def _probes(self, form: Form) -> tuple[FloatArray, FloatArray]:
        """Return the responses of the forces to the probes of a form, and the prior deviations of their multiples."""
        columns, deviations = [], []
        for probe in form.probes:
            moved = self.simulator.forces(probed(self.simulator, self.solution, form, probe))
            columns.append(np.nan_to_num(moved - self.forces))
            fitted = [name for name in probe if name in form.free]
            spread = self.problem.prior(fitted)[1] / np.abs([probe[name] for name in fitted])
            deviations.append(float(np.min(spread)) if form.scalable else 1.0)
        return np.stack(columns, axis=-1), np.array(deviations)

    def additions(self) -> list[Addition]:
        """Return what could be added to the explanation: effects that it lacks, and terms of the unknown component."""
        added = []
        signals, tire = self.simulator.signals, self.simulator.tire
        for name, candidate in self.candidates.items():
            if name not in self.explanation.effects and is_testable(signals, tire, candidate):
                added += self._of_effect(name, candidate)
        if not self.explanation.terms:
            for one in unknown_terms(self.problem, self.solution):
                prior = Explanation((), (one,)).log_prior
                added.append(Addition(UNKNOWN, one, one.column[:, :, None], np.array([one.deviation]), prior))
        return added

    def _of_effect(self, name: str, candidate: Candidate) -> list[Addition]:
        """Return an addition for each form and point of a grid, which share the prior odds of the effect."""
        forms = [unfitted(declared, self.simulator, self.solution.free) for declared in candidate.forms]
        points = [point for form in forms if form is not None for point in form.points()]
        added = []
        for form in points:
            columns, deviation = self._probes(form)
            alone = [slice(0, None)] if form.scalable else [slice(i, i + 1) for i in range(len(deviation))]
            prior = float(np.log(EFFECT_ODDS / (len(points) * len(alone))))
            added += [Addition(name, form, columns[:, :, one], deviation[one], prior) for one in alone]
        return added


def unknown_terms(problem: LeastSquares, solution: Solution) -> list[Term]:
    """Return the terms that the unknown component may have: features at locations of the model.

    A function of the core inputs alone is none: it is an error of the functional form.
    """
    simulator = problem.simulator
    signals, tire = simulator.signals, simulator.tire
    even, odd = features(signals, tire)
    acting = directions(simulator, solution.parameters)
    named = {
        f"{location.name}, {location.how}: {feature.text}": acting[location.name] * feature.values
        for location in locations_of(simulator.symbolic_model)
        for feature in (even if location.how == "factor" else [*odd, *even])
        if not feature.depends_on.union(location.proportional_to) <= CORE_INPUTS
        and determined(location, feature, signals, tire)
    }
    return [term for name, column in named.items() for term in term_of(problem, name, column, len(named))]


def term_of(problem: LeastSquares, name: str, column: FloatArray, tests: int) -> list[Term]:
    """Return a column as a term, of a number of terms that were tested; none if it changes no force."""
    size, norm = (
        float(np.linalg.norm(problem.inverse_noise * one)) for one in (problem.simulator.signals.measured, column)
    )
    return [Term(name, column, UNKNOWN_SHARE * size / norm, tests)] if norm > 0.0 else []
