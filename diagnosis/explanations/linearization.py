"""The linear problem at the refit of an explanation: what the explanation contains, and what could be added to it."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from ...measurements.virtual_bench.bench_errors import MAX_SKEW
from ...numerics.arrays import FloatArray, IndexArray
from ...symbolic.detection import Form
from ..least_squares import LeastSquares, Solution
from ..probing.candidates import CORE, Candidate, is_testable, refinements_for
from ..probing.effect_probing import probed, unfitted
from ..signals.simulation import Simulator
from ..thresholds import EFFECT_ODDS
from ..weighted_columns import WeightedColumns, joined
from .discrepancy import bench_errors
from .evidence import NormalEquations
from .explanation import UNKNOWN, Explanation, FormErrors, form_errors, unknown_terms
from .responses import Responses

#: How the names of the terms in the disturbances begin; their numbers follow.
TERM = "term_"
#: The form of what is no effect.
NO_FORM = Form((), ())


@dataclass(frozen=True, eq=False)
class Addition:
    """A form of an effect at a point of its grid, or terms of the unknown component, that could be added.

    - `form`: of an effect.
    - `columns`, shape (n_channels, n, k): change of the forces, N and N m; none if they are weighted.
    - `deviation`, shape (k,): of the priors of their coefficients.
    - `log_prior`: logarithm of the prior odds of the explanation with it.
    - `unfitted`: number of the last columns that a refit does not fit.
    - `weighted_columns`: the columns in noise standard deviations, if they are known.
    """

    name: str
    columns: FloatArray
    deviation: FloatArray
    form: Form = NO_FORM
    log_prior: float = 0.0
    unfitted: int = 0
    weighted_columns: WeightedColumns | None = None

    def fitted(self) -> Addition:
        """Return the addition without what a refit does not fit."""
        number = len(self.deviation) - self.unfitted
        return replace(self, columns=self.columns[:, :, :number], deviation=self.deviation[:number], unfitted=0)

    def weighted(self, problem: LeastSquares) -> Addition:
        """Return the addition with its columns in the noise standard deviations of a problem."""
        return replace(
            self,
            columns=np.zeros((*self.columns.shape[:2], 0)),
            weighted_columns=problem.weighted_columns([self.columns]),
        )


@dataclass(frozen=True, eq=False)
class Columns:
    """A group of columns that an explanation contains.

    - `owners`: the effect of each column; empty if explanations without it have the column, too.
    - `columns`, shape (n_channels, n, k), N and N m; `deviation`, shape (k,): of the priors of their coefficients.
    - `distance`, shape (k,): of the values from the means of their priors, in deviations.
    - `limits`, shape (2, k): their least and largest change.
    """

    owners: list[str]
    columns: FloatArray
    deviation: FloatArray
    distance: FloatArray
    limits: FloatArray

    @classmethod
    def of(cls, owner: str, columns: FloatArray, deviation: FloatArray | None = None) -> Columns:
        """Return columns of one owner with coefficients of 0; their deviation is 1 if none is given."""
        number = columns.shape[-1]
        given = np.ones(number) if deviation is None else deviation
        return cls([owner] * number, columns, given, np.zeros(number), unlimited(number))


def weighted_additions(problem: LeastSquares, additions: Sequence[Addition]) -> WeightedColumns:
    """Return the columns of additions in the noise standard deviations of a problem, one after another."""
    if all(addition.weighted_columns is None for addition in additions):
        return problem.weighted_columns([addition.columns for addition in additions])
    return joined([addition.weighted_columns or problem.weighted_columns([addition.columns]) for addition in additions])


def unlimited(number: int) -> FloatArray:
    """Return the limits of columns whose coefficients may change by any amount, shape (2, number)."""
    return np.array([[-np.inf], [np.inf]]) * np.ones(number)


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
    def responses(self) -> Responses:
        """Of the forces to the effects of the explanation."""
        return Responses(self.explanation, self.simulator, self.solution, self.candidates)

    @cached_property
    def skew_index(self) -> int:
        """The index of the skew among the columns of `equations`."""
        return len(self.problem.disturbances.names) + len(self._inside)

    @cached_property
    def skew(self) -> float:
        """The time by which the inputs are recorded before the forces, s: of the simulator, and the remaining one.

        A rest of less than two standard deviations is none.
        """
        skew = self.simulator.signals.skew
        if _contents(self).bench:
            rest, deviation = self._own_equations.estimate_of(self.skew_index)
            skew += rest if abs(rest) > 2.0 * deviation else 0.0
        return float(np.clip(skew, -MAX_SKEW, MAX_SKEW))

    def error_of_skew(self, step: float) -> float:
        """Return the error of the logarithm of the evidence if the forces are linear in a change of the skew, s.

        The second derivative of the forces by time, which is neglected then, is the column after the skew.
        """
        bend = float(self._own_equations.matrix[self.skew_index + 1, self.skew_index + 1])
        return 0.5 * bend * (0.5 * step**2) ** 2

    @cached_property
    def _inside(self) -> tuple[str, ...]:
        """The coefficients that are not at a bound; others are constants of the linear problem."""
        bounded = self.problem.at_bounds(self.solution.parameters, self.solution.free, neutral=True)
        return tuple(name for name in self.solution.free if name not in bounded)

    def equations(self, additions: Sequence[Addition] = (), *, exactly: bool = False) -> NormalEquations:
        """Return the normal equations of everything that the explanation contains, and of additions.

        `exactly`: without errors of the form of its effects. They are in proportion to effects that become smaller if
        another one is added, which therefore gains more in a refit than beside errors of this size.
        """
        base, contents = self._own_equations, _contents(self)
        if exactly:
            base = base.without(range(len(base.target) - contents.errors, len(base.target)))
        if not additions:
            return base
        added, cross = self.beside(additions)
        return base.extended(added, cross[: len(base.target)])

    def beside(self, additions: Sequence[Addition]) -> tuple[NormalEquations, FloatArray]:
        """Return the normal equations of additions, and their products with all columns and the misfit, (m + 1, k)."""
        added = weighted_additions(self.problem, additions)
        cross, base = _contents(self).columns.times(added), self._own_equations
        precision = np.concatenate([addition.deviation**-2.0 for addition in additions])
        zeros = np.zeros(added.number)
        limits = unlimited(added.number)
        return NormalEquations(added.times(added), cross[-1], base.power, precision, zeros, limits), cross

    def products(self, rows: IndexArray) -> FloatArray:
        """Return the cross products of all columns, and of the misfit as the last one, over some of the rows."""
        some = _contents(self).columns.at(rows)
        return some.times(some)

    def evidence_without(self, effect: str) -> float:
        """Return the logarithm of the evidence if an effect of the explanation is absent, in the linear problem."""
        base, lost = self._own_equations, [i for i, name in enumerate(_contents(self).owners) if name == effect]
        # The response is a part of the misfit then, and the lost columns have no value that could be limited.
        response, cross = self.beside([Addition(effect, self.responses.of(effect)[:, :, None], np.ones(1))])
        distances = base.gradient[lost] ** 2 / base.precision[lost]
        power = base.power + 2.0 * cross[-1, 0] + response.matrix[0, 0] - float(np.sum(distances))
        rest = base.with_target(base.target + cross[:-1, 0], float(power), unlimited=lost)
        return rest.solved()[1] - rest.gain_of(lost)

    @property
    def _own_equations(self) -> NormalEquations:
        return _contents(self).equations

    def contained(self) -> Iterator[Columns]:
        """Yield what the explanation contains beside the disturbances.

        Coefficients, errors of the bench (the skew is the first), refinements of all forms, errors of the forms of the
        baseline model and of the unknown component, and of each effect.
        """
        simulator, solution, free = self.simulator, self.solution, self._inside
        inside = [name in free for name in solution.free]
        center, deviation = (moment[inside] for moment in self.problem.prior(solution.free))
        values = solution.parameters[[simulator.index[name] for name in free]]
        owners = [self.explanation.owner(name) for name in free]
        of_effects = np.isin(free, [name for _, form in self.explanation.forms for name in form.free])
        limits = np.where(of_effects, self.problem.bounds(free) - values, unlimited(len(free)))
        jacobian = simulator.jacobian(solution.parameters, free)
        yield Columns(owners, jacobian, deviation, (values - center) / deviation, limits)
        bench, of_bench = bench_errors(simulator, solution.parameters)
        skew = np.where(np.arange(len(of_bench)) == 0, simulator.signals.skew, 0.0)
        yield Columns([""] * len(of_bench), bench, of_bench, skew / of_bench, unlimited(len(of_bench)))
        for name, form in self._refinements:
            yield Columns.of(name, *self._probes(form))
        yield Columns.of("", self.responses.errors_of_baseline())
        if (of_terms := self._response_of_terms()).any():
            depends_on = frozenset().union(*(term.depends_on for term in self.explanation.terms))
            yield Columns.of("", self.responses.errors_at_once(of_terms, depends_on))
        for name, _ in self.explanation.forms:
            yield Columns.of(name, self.responses.errors_of(name))

    def _response_of_terms(self) -> FloatArray:
        """Return the change of the forces by the terms of the explanation, shape (n_channels, n)."""
        response, named = np.zeros_like(self.responses.forces), self.problem.disturbances.names
        for i, term in enumerate(self.explanation.terms):
            response += term.column * self.solution.disturbance[named.index(f"{TERM}{i}")]
        return response

    @cached_property
    def _refinements(self) -> list[tuple[str, Form]]:
        """What is not fitted of the core and of each effect: its refinements and its other forms."""
        return self._unfitted(self.explanation.effects, self.solution.free)

    def _unfitted(self, effects: Sequence[str], free: Collection[str]) -> list[tuple[str, Form]]:
        """Return refinements and other forms of effects, and refinements of the baseline model, that are not free."""
        declared = refinements_for(self.simulator.tire, frozenset(effects))
        declared += [(name, form) for name in effects for form in self.candidates[name].forms]
        forms = [(name, unfitted(form, self.simulator, free)) for name, form in declared]
        return [(name, form) for name, form in forms if form is not None and form.scalable]

    def needed_refinements(self) -> tuple[tuple[str, Form], ...]:
        """Return the refinements of the effects without which there would be less evidence, with odds as of an effect.

        They are among the columns of every explanation. Errors of the core are no effects: its refinements would
        extrapolate the remaining ones. The ratio of the evidences with and without a column is that of
        Savage and Dickey.
        """
        first = self.skew_index + _contents(self).bench
        needed = []
        for name, form in self._refinements:
            end = first + len(form.probes)
            if name != CORE and self._own_equations.gain_of(range(first, end)) + np.log(EFFECT_ODDS) > 0.0:
                needed.append((name, form))
            first = end
        return tuple(needed)

    def errors_of_bench(self, disturbances: str) -> dict[str, float]:
        """Return the offsets or the cross-talk by name, beside the discrepancy.

        They are 0 if the evidence is not smaller without them, and if no bench has them.

        `disturbances`: how the names begin.
        """
        named, equations = self.problem.disturbances, self._own_equations
        estimate = equations.solved()[0][: len(named.names)]
        beyond = named.implausible(estimate)
        return {
            name: 0.0 if name in beyond or equations.gain_of([i]) <= 0.0 else float(estimate[i])
            for i, name in enumerate(named.names)
            if name.startswith(disturbances)
        }

    def _probes(self, form: Form) -> tuple[FloatArray, FloatArray]:
        """Return the responses of the forces to the probes of a form, and the prior deviations of their multiples."""
        columns, deviations = [], []
        for probe in form.probes:
            moved = self.simulator.forces(probed(self.simulator, self.solution, form, probe))
            columns.append(np.nan_to_num(moved - self.responses.forces))
            fitted = [name for name in probe if name in form.free]
            spread = self.problem.prior(fitted)[1] / np.abs([probe[name] for name in fitted])
            deviations.append(float(np.min(spread)) if form.scalable else 1.0)
        return np.stack(columns, axis=-1), np.array(deviations)

    @property
    def lacking(self) -> list[str]:
        """The names of the effects that the explanation lacks, also as special cases of others."""
        present = self.explanation.effects
        contained = {self.candidates[name].contains for name in present}
        return [name for name in self.candidates if name not in contained.union(present)]

    def unknown(self) -> Addition:
        """Return all terms that an unknown component could have, features alone, as one addition."""
        terms = unknown_terms(self.problem, self.solution)
        return Addition(
            UNKNOWN, np.stack([term.column for term in terms], axis=-1), np.array([term.deviation for term in terms])
        )

    @cached_property
    def form_errors(self) -> FormErrors:
        """Which terms are errors of the form of the explanation."""
        return form_errors(self.explanation, self.candidates, self.simulator.symbolic_model)

    def of_effect(self, name: str) -> list[Addition]:
        """Return an addition for each form and point of a grid, which share the prior odds of the effect.

        As in an explanation with the effect, what is not fitted of it is there, too, behind the probes of the form.
        There are none if the recording cannot show the effect. A coefficient that an effect of the explanation shares
        with it belongs to both.
        """
        candidate = self.candidates[name]
        if not is_testable(self.simulator.signals, self.simulator.tire, candidate):
            return []
        shared = set(self.solution.free).difference(*(form.free for _, form in self.explanation.forms))
        forms = [unfitted(declared, self.simulator, shared) for declared in candidate.forms]
        points = [point for form in forms if form is not None for point in form.points()]
        added = []
        for form in points:
            columns, deviation = self._probes(form)
            number = len(deviation)
            alone = [range(number)] if form.scalable else [range(i, i + 1) for i in range(number)]
            prior = float(np.log(EFFECT_ODDS / (len(points) * len(alone))))
            others = self._unfitted([name], {*self.solution.free, *form.free})
            finer = [self._probes(other) for owner, other in others if owner == name]
            columns = np.concatenate([columns, *(of for of, _ in finer)], axis=-1)
            deviation = np.concatenate([deviation, *(of for _, of in finer)])
            for probes in alone:
                at = [*probes, *range(number, len(deviation))]
                added.append(Addition(name, columns[:, :, at], deviation[at], form, prior, len(deviation) - number))
        return added


@dataclass(frozen=True, eq=False)
class _Contents:
    """The columns of an explanation.

    - `columns`: weighted, the disturbances first; the last one is the misfit.
    - `equations`: their normal equations.
    - `owners`: the effect of each column of the equations; empty of what explanations without the effect contain, too.
    - `bench`: the number of errors of the bench, the first of which is the skew.
    - `errors`: the number of the last columns of the equations, which are errors of the form of effects.
    """

    columns: WeightedColumns
    equations: NormalEquations
    owners: list[str]
    bench: int
    errors: int


#: What the latest linearization contains: a hundred megabytes for twenty effects in three channels.
_STORED = dict[Linearization, _Contents]()


def _contents(linear: Linearization) -> _Contents:
    """Return what an explanation contains; that of another one is freed before it is computed."""
    if linear not in _STORED:
        _STORED.clear()
        _STORED[linear] = _computed_contents(linear)
    return _STORED[linear]


def _computed_contents(linear: Linearization) -> _Contents:
    problem, groups = linear.problem, list[Columns]()

    def all_columns() -> Iterator[FloatArray]:
        yield problem.disturbances.columns
        for group in linear.contained():
            groups.append(replace(group, columns=np.zeros((0, 0, 0))))
            yield group.columns
        yield problem.misfit(linear.solution.parameters)[:, :, None]

    columns, common = problem.weighted_columns(all_columns()), len(problem.disturbances.names)
    matrix = columns.times(columns)
    deviations = np.concatenate([problem.disturbances.deviation, *(group.deviation for group in groups)])
    distances = np.concatenate([np.zeros(common), *(group.distance for group in groups)])
    power = float(matrix[-1, -1]) + float(np.sum(distances**2))
    limits = np.concatenate([unlimited(common), *(group.limits for group in groups)], axis=1)
    equations = NormalEquations(
        matrix[:-1, :-1], matrix[:-1, -1], power, deviations**-2.0, -distances / deviations, limits
    )
    owners = [*[""] * common, *(owner for group in groups for owner in group.owners)]
    errors = sum(len(group.owners) for group in groups[len(groups) - len(linear.explanation.forms) :])
    return _Contents(columns, equations, owners, len(groups[1].owners), errors)


def forget_columns() -> None:
    """Free the memory of stored columns; they are computed again when they are needed."""
    _STORED.clear()
