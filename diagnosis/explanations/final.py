"""The final fits: baseline model and most probable explanation, as they are delivered.

A tire contains no discrepancies and no errors of its functional form, so these are left out. Channels are weighted by
the squares of their residuals over noise, so that a channel with an inexact formula does not make the others worse; the
baseline tire is fitted with the same weights. If nothing is missing, both are one tire. An offset of the bench without
evidence is left out at the end: the fits would take errors of the tire's own form for one. In each fit, states are
driven by the forces of the fit before.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping
from dataclasses import dataclass, replace

import numpy as np

from ...numerics.arrays import FloatArray
from ...numerics.noise_model import Whitening, noise_parts
from ...numerics.ties import graded
from ...symbolic.detection import Form
from ...symbolic.model import Model
from ...tires.tire import Tire
from ..least_squares import LeastSquares, Solution
from ..probing.baseline_fit import readable
from ..probing.candidates import CORE, refinements_for
from ..probing.effect_probing import Screen
from ..signals.disturbances import CROSS_TALK, OFFSET, Disturbances
from ..unexplained.formula_proposal import UnexplainedStructure, Unknown, proposed
from .answer import Answer
from .budget import Budget
from .compare import ComparedExplanations
from .effect_evidence import CERTAIN, Evidence, effect_evidence, proof_of
from .explanation import UNKNOWN, Explanation
from .form import form_of
from .refit import fitted_as_tire

#: Ratio of root mean square residuals, whitened to equal weights, above which the whitened fit is not used. Convention:
#: the agreement that is required of reported residuals.
MAX_WHITENED_MISFIT = 1.02


#: Refinements, each with its effect.
Refinements = tuple[tuple[str, Form], ...]


@dataclass(frozen=True, eq=False)
class Final:
    """The final fits of the baseline model and of the most probable explanation.

    - `before`, `after`: of the baseline model and of the model with the effects.
    - `errors`: standard errors of the free coefficients of `after`, from whitened rows and all disturbances, with what
      an offset that was left out would change.
    - `effects`: those of the explanation, and their free coefficients.
    - `evidence`: for the same effects.
    - `refinements`: those that the recording needs, each with its effect.
    - `unknown`: the unknown component; at most one.
    - `unknown_evidence`: for its formula, if this was added.
    - `answer`: the probabilities, smaller ones for what the recording does not prove.
    - `form`, shape (n_channels, n): what the formula's own form errs by, N and N m, if the model with the effects has a
      correction of it (`form_of`).
    """

    before: Screen
    after: Screen
    errors: FloatArray
    effects: Mapping[str, tuple[str, ...]]
    evidence: Mapping[str, Evidence]
    refinements: Refinements
    unknown: tuple[Unknown, ...]
    unknown_evidence: Evidence | None
    answer: Answer
    form: FloatArray | None = None

    @property
    def start(self) -> Tire:
        """The baseline model with all effects that were tested, switched off, and with what was added to its lines."""
        return self.after.problem.simulator.tire


def final_fits(
    comparison: ComparedExplanations, problem: LeastSquares, baseline: Solution, budget: Budget,
    *, formula: bool = True, no_formula: str = "", correct_form: bool = True,
) -> Final:  # fmt: skip
    """Return the final fits. When the time ends, fits stay where they are, and the form is not corrected.

    `problem`, `baseline`: of the baseline model. `formula`: whether an unknown component has one. `no_formula`: the
    reason why it may not be added to the model, if any. `correct_form`: whether the model may have a correction of its
    own form.
    """
    linear, given = comparison.leader.linear, problem
    offsets = linear.errors_of_bench(OFFSET)  # unknown while effects are judged, which have to explain more than these
    signals = problem.simulator.signals
    aligned = signals.delayed(linear.skew - signals.skew)
    problem = problem.knowing(linear.errors_of_bench(CROSS_TALK)).over(problem.simulator.with_signals(aligned))
    problem = replace(problem, stop=lambda: budget.late)
    free = _in_order(problem, [*baseline.free, *refined_core(problem)])
    problem, base = problem.driven(baseline).fitted(baseline.parameters, free)
    refinements = linear.needed_refinements()
    extended, solution = problem, base
    freed = {*base.free, *linear.solution.free, *(name for _, form in refinements for name in form.free)}
    if freed > set(base.free):
        extended, solution = fitted_as_tire(problem, linear, base, _in_order(problem, freed))
    unknown, change = tuple[Unknown, ...](), None
    if formula and (terms := linear.explanation.terms):
        features = tuple(term.feature for term in terms)
        structure = UnexplainedStructure(terms[0].location, features, comparison.leader.term_sizes)
        budget.tell("adding the proposed formula to the model equations")
        part, with_formula = proposed(structure, extended, solution, no_formula)
        unknown, (extended, solution) = (part,), with_formula or (extended, solution)
    noise = _noise_of(comparison, extended)
    for correcting in (False, correct_form, False):
        extended, solution = balanced(extended, solution, noise).fitted(solution.parameters, solution.free)
        if correcting and not budget.late and (corrected := form_of(extended, solution)):
            extended, solution, change = corrected
    added = [declared.name for part in unknown if part.added and part.effect for declared in part.effect.declarations]
    extended, solution, explanation, refinements, unproved = with_proven(
        extended, solution, noise, linear.explanation, refinements, added
    )
    if UNKNOWN in unproved:
        without = replace(comparison, answer=comparison.answer.with_unproven(UNKNOWN))
        return final_fits(without, given, baseline, budget, formula=False, correct_form=correct_form)
    answer = comparison.answer
    for name in unproved:
        answer = answer.with_unproven(name)
    judged = solution
    problem, extended = (other.knowing(offsets) for other in (problem, extended))
    extended, solution = extended.fitted(solution.parameters, solution.free)
    index = [extended.simulator.index[name] for name in solution.free]
    moved = solution.parameters[index] - judged.parameters[index]
    before = Screen(extended, solution)
    if solution.free != base.free:  # with the same weights: a channel could give way to another one in one fit only
        problem = replace(problem, inverse_noise=extended.inverse_noise)
        before = Screen(*problem.fitted(base.parameters, base.free))
    before, solution, whitened = _whitened(extended, solution, before, given.disturbances)
    errors = whitened.standard_errors()[: len(moved)]
    after = Screen(extended, solution)
    model = extended.simulator.symbolic_model
    effects = {name: coefficients_of(name, explanation, model, solution) for name in explanation.effects}
    evidence = {name: effect_evidence(after, _absent_without(name, explanation, model, solution)) for name in effects}
    of_formula = effect_evidence(after, added) if added else None
    for name, coefficients in effects.items():  # at a bound, something is missing there in another form than this one
        if extended.at_bounds(solution.parameters, coefficients):
            answer = answer.with_rival(name, UNKNOWN, better=True)
    return Final(
        before, after, np.hypot(errors, moved), effects, evidence, refinements, unknown, of_formula, answer, change
    )


def _noise_of(comparison: ComparedExplanations, problem: LeastSquares) -> FloatArray:
    """Return the inverse noise of the comparison, what no column explains, for the rows of a problem."""
    of_some, of_all = (of.inverse_noise.max(axis=1) for of in (comparison.shared.problem, problem))
    return np.asarray(problem.inverse_noise * (of_some / np.where(of_all > 0.0, of_all, 1.0))[:, None])


def _in_order(problem: LeastSquares, names: Collection[str]) -> tuple[str, ...]:
    """Return different coefficients in the order of the model."""
    return tuple(sorted(set(names), key=problem.simulator.names.index))


def refined_core(problem: LeastSquares) -> list[str]:
    """Return the refinements of the core that the given tire has: they are fitted together with what they refine."""
    tire, signals, model = problem.simulator.tire, problem.simulator.signals, problem.simulator.symbolic_model
    names = {name for effect, form in refinements_for(tire, frozenset()) if effect == CORE for name in form.free}
    neutral = {name: model.coefficients[name].neutral for name in sorted(names & tire.values.keys())}
    return [name for name in readable(tuple(neutral), signals, model) if tire.values[name] != neutral[name]]


def with_proven(
    problem: LeastSquares, solution: Solution, noise: FloatArray, explanation: Explanation,
    refinements: Refinements = (), formula: Collection[str] = (),
) -> tuple[LeastSquares, Solution, Explanation, Refinements, tuple[str, ...]]:  # fmt: skip
    """Return a fit without what the recording does not prove, what it has of the explanation, and the absent effects.

    The comparison counts an effect beside errors of the form of all others, which the tire does not have, and knows the
    noise from the recording alone: in what the tire can say, each has to prove itself (`CERTAIN`). One after another is
    left out, the least certain one first: of two that are in each other's place, one remains. Only those that were not
    proven are judged again at once, and all when these are proven or left out.

    `noise`: inverse, without weights. `refinements`: they are absent with their effects. `formula`: coefficients of the
    formula of an unknown component, which is judged with the effects. If it is the one to omit, the fit ends: the
    others were fitted together with it.
    """
    absent, doubtful = list[str](), list[str]()
    while (explanation.effects or formula) and not problem.stop():
        weighted = balanced(problem, solution, noise)
        after = Screen(weighted, weighted.at(solution.parameters, solution.free))
        model = problem.simulator.symbolic_model
        judged = {name: _absent_without(name, explanation, model, solution) for name in explanation.effects}
        judged |= {UNKNOWN: tuple(formula)} if formula else {}
        certainty = {name: proof_of(after, judged[name]) for name in doubtful or judged}
        if not (unproven := [name for name, size in certainty.items() if size <= CERTAIN]):
            if not doubtful:
                break
            doubtful = []
            continue
        effect = min(unproven, key=lambda name: graded(certainty[name]))
        doubtful = [name for name in unproven if name != effect]
        absent.append(effect)
        if effect == UNKNOWN:
            break
        lost = {name for finer, form in refinements if finer == effect for name in form.free}
        lost |= set(coefficients_of(effect, explanation, model, solution))
        explanation = replace(explanation, forms=tuple(form for form in explanation.forms if form[0] != effect))
        refinements = tuple(refinement for refinement in refinements if refinement[0] != effect)
        lost -= {name for _, form in (*explanation.forms, *refinements) for name in form.free}
        free = tuple(name for name in solution.free if name not in lost)
        problem, solution = problem.fitted(problem.simulator.without(solution.parameters, lost), free)
    return problem, solution, explanation, refinements, tuple(absent)


def coefficients_of(effect: str, explanation: Explanation, model: Model, solution: Solution) -> tuple[str, ...]:
    """Return the free coefficients that belong to an effect, also those of its refinements.

    One of several effects of the model (PHYP2: camber thrust and turn slip) is that of the one it is free for.
    """
    of_form = dict(explanation.forms)[effect].free
    only = explanation.only_of(effect, model.owned(effect) if effect in model.effects else ())
    return tuple(name for name in solution.free if name in only or name in of_form)


def _absent_without(effect: str, explanation: Explanation, model: Model, solution: Solution) -> tuple[str, ...]:
    """Return those that no other effect is free for either, or all if it shares all of them."""
    both = coefficients_of(effect, explanation, model, solution)
    shared = {name for other, form in explanation.forms if other != effect for name in form.free}
    return tuple(name for name in both if name not in shared) or both


def balanced(problem: LeastSquares, solution: Solution, noise: FloatArray) -> LeastSquares:
    """Return the problem with each channel weighted by the square of its residual over noise.

    By the residual alone, as in a fit of maximum likelihood, rows of a channel whose formula is inexact would count as
    independent. They are wrong together, and the fit would make the other channels worse for them.

    `noise`, shape (n_channels, n): inverse, without weights.
    """
    size = replace(problem, inverse_noise=noise).sizes(solution.residual) ** 2
    relative = size / np.sqrt(np.mean(size[size > 0.0] ** 2)) if size.any() else np.ones_like(size)
    return replace(problem, inverse_noise=noise / np.where(size > 0.0, relative, 1.0)[:, None])


def _whitened(
    problem: LeastSquares, solution: Solution, before: Screen, disturbances: Disturbances
) -> tuple[Screen, Solution, Screen]:
    """Refit baseline and final model with whitened noise.

    Whitening amplifies errors in the functional form of a model: solutions that fit the rows much worse than without it
    are not used. Returns: the baseline model, the solution of the final model, and, for standard errors, this model
    with whitened rows and all disturbances: a coefficient is as uncertain as an offset that was left out makes it.
    """
    signals, uncertain = problem.simulator.signals, replace(problem, disturbances=disturbances)
    if not signals.timed:
        return before, solution, Screen(uncertain, uncertain.at(solution.parameters, solution.free))
    t = signals.t[signals.rows]
    rest, step = problem.weighted(solution.residual), float(np.median(np.diff(t)))
    parts = [noise_parts(*rows, step) for rows in zip(rest, problem.inverse_noise > 0.0, strict=True)]
    size = problem.sizes(solution.residual)
    level = (size.max() / np.where(size > 0.0, size, size.max())) ** 2  # the channels keep their weights
    noise = tuple(part.times(float(factor)) for part, factor in zip(parts, level, strict=True))
    whitening = Whitening(noise, t, problem.inverse_noise)
    final, base = _refitted(problem, solution, whitening), before.solution
    base = final if base is solution else _refitted(before.problem, base, whitening)
    whitened = replace(uncertain, whitening=whitening)
    return Screen(before.problem, base), final, Screen(whitened, whitened.at(final.parameters, final.free))


def _refitted(problem: LeastSquares, equal: Solution, whitening: Whitening) -> Solution:
    """Return the whitened solution unless its misfit over rows of equal weight is much larger in a channel."""
    whitened = replace(problem, whitening=whitening)
    other = whitened.solve(equal.parameters, equal.free)
    squares = [np.sum(problem.weighted(solution.residual) ** 2, axis=1) for solution in (other, equal)]
    return other if np.all(squares[0] <= MAX_WHITENED_MISFIT**2 * squares[1]) else equal
