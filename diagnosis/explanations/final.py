"""The final fits: baseline model and most probable explanation, as they are delivered.

A tire contains no discrepancies and no errors of its functional form, so these are left out. Channels are weighted by
their residuals, so that a channel with an inexact formula does not make the others worse; the baseline tire is fitted
with the same weights. If nothing is missing, both are one tire. In each fit, states are driven by
the forces of the fit before.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping
from dataclasses import dataclass, replace

import numpy as np

from ...numerics.arrays import FloatArray
from ...numerics.noise_model import Whitening, noise_parts
from ...symbolic.detection import Form
from ...tires.tire import Tire
from ..least_squares import LeastSquares, Solution
from ..probing.effect_probing import Screen
from ..thresholds import FINAL_ITERATIONS
from ..unexplained.formula_proposal import (
    AddedFormula,
    UnexplainedStructure,
    Unknown,
    effect_of,
    unknown_of,
    with_formula,
)
from .budget import Budget
from .compare import ComparedExplanations
from .effect_evidence import Evidence, effect_evidence
from .explanation import Explanation
from .form import Form as FormCorrection
from .form import form_of

#: Ratio of root mean square residuals, whitened to equal weights, above which the whitened fit is not used. Convention:
#: the agreement that is required of reported residuals.
MAX_WHITENED_MISFIT = 1.02

#: Number of times that the channels are weighted by their residuals and fitted.
BALANCING = 2


@dataclass(frozen=True, eq=False)
class Final:
    """The final fits of the baseline model and of the most probable explanation.

    Attributes
    ----------
    before, after : Screen
        Of the baseline model and of the model with the effects.
    whitened : Screen
        The same as `after` with whitened rows, for confidence intervals.
    start : Tire
        The baseline model with all effects that were tested, switched off, and with an added formula.
    effects : mapping of str to tuple of str
        The effects of the explanation and their free coefficients.
    evidence : mapping of str to Evidence
        For the same effects.
    refinements : tuple of (str, Form)
        Finer forms that the recording needs, each with its effect.
    unknown : tuple of Unknown
        The unknown component; at most one.
    unknown_evidence : Evidence or None
        For its formula, if this was added.
    form : FormCorrection or None
        The correction of the formula's own form in the model with the effects, if it predicts the hold-out set better.
    """

    before: Screen
    after: Screen
    whitened: Screen
    start: Tire
    effects: Mapping[str, tuple[str, ...]]
    evidence: Mapping[str, Evidence]
    refinements: tuple[tuple[str, Form], ...]
    unknown: tuple[Unknown, ...]
    unknown_evidence: Evidence | None
    form: FormCorrection | None = None


def final_fits(
    comparison: ComparedExplanations, problem: LeastSquares, baseline: Solution, start: Tire,
    budget: Budget, *, no_formula: str = "", correct_form: bool = True,
) -> Final:  # fmt: skip
    """Return the final fits. When the time ends, fits stay where they are, and the form is not corrected.

    Parameters
    ----------
    comparison : ComparedExplanations
    problem : LeastSquares
        Of the baseline model.
    baseline : Solution
    start : Tire
        The baseline model with all effects that were tested, switched off.
    budget : Budget
    no_formula : str
        The reason why the formula of an unknown component may not be added to the model, if any.
    correct_form : bool
        Whether the model may have a correction of the formula's own form.
    """
    linear = comparison.leader.linear
    disturbances = problem.disturbances.without(linear.unneeded_cross_talk())
    signals = problem.simulator.signals
    aligned = signals.delayed(linear.simulator.signals.skew - signals.skew)
    problem = replace(problem, disturbances=disturbances, stop=lambda: budget.late).over(
        problem.simulator.with_signals(aligned)
    )
    problem, base = _fitted(driven(problem, baseline), baseline.parameters, baseline.free)
    refinements = linear.needed_refinements()
    extended, solution = problem, base
    freed = {*linear.solution.free, *(name for _, form in refinements for name in form.free)}
    if freed > set(base.free):
        free = tuple(sorted(freed, key=linear.simulator.names.index))
        extended, solution = _fitted(driven(problem, linear.solution), linear.solution.parameters, free)
    unknown, added = _unknown(comparison, start, extended, solution, budget, no_formula)
    if added is not None:
        extended, solution, start = added.problem, added.solution, added.tire
    form = form_of(extended, solution, start) if correct_form and not budget.late else None
    if form is not None:
        extended, solution, start = form.problem, form.solution, form.start
    for _ in range(BALANCING):
        extended, solution = _fitted(balanced(extended, solution), solution.parameters, solution.free)
    before = Screen(extended, solution)
    if solution.free != base.free:  # with the same weights: a channel could give way to another one in one fit only
        problem = replace(problem, inverse_noise=extended.inverse_noise)
        before = Screen(*_fitted(problem, base.parameters, base.free))
    before, solution, whitened = _whitened(extended, solution, before)
    after, explanation = Screen(extended, solution), linear.explanation
    effects = {name: _coefficients(name, explanation, after) for name in explanation.effects}
    evidence = {name: effect_evidence(after, coefficients) for name, coefficients in effects.items()}
    formula = [declaration.name for declaration in added.effect.declarations] if added else []
    of_formula = effect_evidence(after, formula) if added else None
    return Final(before, after, whitened, start, effects, evidence, refinements, unknown, of_formula, form)


def driven(problem: LeastSquares, solution: Solution) -> LeastSquares:
    """Return a problem whose states are driven by the forces of a solution."""
    return problem.over(problem.simulator.driven_at(solution.parameters))


def _fitted(problem: LeastSquares, start: FloatArray, free: Collection[str]) -> tuple[LeastSquares, Solution]:
    """Return a solution, and the problem with states that its forces drive."""
    solution = problem.solve(start, tuple(free), iterations=FINAL_ITERATIONS)
    after = driven(problem, solution)
    return after, after.at(solution.parameters, solution.free)


def _unknown(
    comparison: ComparedExplanations, start: Tire, problem: LeastSquares, solution: Solution,
    budget: Budget, no_formula: str,
) -> tuple[tuple[Unknown, ...], AddedFormula | None]:  # fmt: skip
    """Return the report of the unknown component, and the model with its formula if possible."""
    terms = comparison.leader.explanation.terms
    if not terms:
        return (), None
    structure = UnexplainedStructure(
        terms[0].location, tuple(term.feature for term in terms), comparison.leader.term_sizes
    )
    effect = effect_of(structure)
    budget.report("adding the proposed formula to the model equations")
    added = no_formula or with_formula(structure, effect, start, problem, solution)
    return (unknown_of(structure, effect, added),), added if isinstance(added, AddedFormula) else None


def _coefficients(effect: str, explanation: Explanation, after: Screen) -> tuple[str, ...]:
    """Return the free coefficients that belong to an effect, also those of its refinements."""
    model = after.problem.simulator.symbolic_model
    owned = model.owned(effect) if effect in model.effects else frozenset()
    freed = {name for owner, form in explanation.forms if owner == effect for name in form.free}
    return tuple(name for name in after.solution.free if name in freed or name in owned)


def balanced(problem: LeastSquares, solution: Solution) -> LeastSquares:
    """Return the problem with each channel weighted by its residual, as in a fit of maximum likelihood.

    The comparison weights a channel by its short-range noise. A channel whose formula is inexact has a larger residual;
    the fit would then make the other channels worse for it.
    """
    used = problem.inverse_noise > 0.0
    sums = np.sum((problem.inverse_noise * solution.residual) ** 2, axis=1, where=used)
    size = np.sqrt(sums / np.maximum(used.sum(axis=1), 1))
    relative = size / np.sqrt(np.mean(size[size > 0.0] ** 2)) if size.any() else np.ones_like(size)
    return replace(problem, inverse_noise=problem.inverse_noise / np.where(size > 0.0, relative, 1.0)[:, None])


def _whitened(problem: LeastSquares, solution: Solution, before: Screen) -> tuple[Screen, Solution, Screen]:
    """Refit baseline and final model with whitened noise.

    Whitening amplifies errors in the functional form of a model: solutions that fit the rows much worse than without it
    are not used.

    Returns
    -------
    Screen
        Of the baseline model.
    Solution
        Of the final model.
    Screen
        Of the final model with whitened rows.
    """
    signals = problem.simulator.signals
    if not signals.timed:
        return before, solution, Screen(problem, solution)
    t = signals.t[signals.rows]
    rest, step = problem.weighted(solution.residual), float(np.median(np.diff(t)))
    noise = tuple(noise_parts(*rows, step) for rows in zip(rest, problem.inverse_noise > 0.0, strict=True))
    whitening = Whitening(noise, t, problem.inverse_noise)
    whitened = replace(problem, whitening=whitening)
    final = _not_worse(
        problem, whitened.solve(solution.parameters, solution.free, iterations=FINAL_ITERATIONS), solution
    )
    screen = Screen(whitened, whitened.at(final.parameters, final.free))
    of_base = before.solution
    if of_base is solution:
        return Screen(before.problem, final), final, screen
    first = replace(before.problem, whitening=whitening).solve(
        of_base.parameters, of_base.free, iterations=FINAL_ITERATIONS
    )
    return Screen(before.problem, _not_worse(before.problem, first, of_base)), final, screen


def _not_worse(problem: LeastSquares, whitened: Solution, equal: Solution) -> Solution:
    """Return the whitened solution unless its misfit over rows of equal weight is much larger in a channel."""
    squares = [np.sum(problem.weighted(solution.residual) ** 2, axis=1) for solution in (whitened, equal)]
    return whitened if np.all(squares[0] <= MAX_WHITENED_MISFIT**2 * squares[1]) else equal
