"""Stepwise search: probe all candidates, refit the best, rank by blocked cross-validation, test, repeat."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from copy import copy
from dataclasses import dataclass, field, replace

import numpy as np
import numpy.typing as npt

from tirefmu.estimation.block_regression import error_of_sum
from tirefmu.symbolic.detection import Form

from ..least_squares import LeastSquares, Solution
from ..probing.candidates import Candidate, is_testable, refinements_for
from ..probing.confounding import correlations
from ..probing.effect_probing import Screen, starts, unfitted
from ..thresholds import (
    CONFOUNDED,
    EFFECT_P,
    FURTHER_MEMORY,
    LOOKAHEAD,
    P_FACTOR,
    PREFERRED_JOINT_SHARE,
    PREFERRED_SHARE,
    REFITTED,
    REFITTED_REFINEMENTS,
    ROUNDS,
    SEARCH_ROWS,
)
from ..unexplained.drift import is_drift
from ..unexplained.structure import CORE_INPUTS, Structure, core_part, structure_of
from .refits import REFINEMENT, Refit, Tried, distinct, preferred, rivals

FloatArray = npt.NDArray[np.float64]

#: Variables of structure that may correct the form of an identified effect with states.
PAST = {"memory", "dalpha/dt", "dkappa/dt", "dFz/dt", "T", "distance", "V"}


@dataclass(eq=False)
class Search:
    """The state of a search.

    Attributes
    ----------
    problem : LeastSquares
    solution : Solution
        Of the baseline model with the identified effects.
    candidates : mapping of str to Candidate
    found : list of Refit
    refinements : list of Refit
        Refinements of effects that the model already had.
    structures, forms : list of Structure
        Structure that no candidate explains; and structure that only corrects the functional form of the model.
    last : list of Tried
        Candidates of the last round with their responses.
    rivals : frozenset of str
        Effects that explained the residual of the baseline model nearly as well as the first one that was identified.
    stopped : bool
        Whether the last of `ROUNDS` rounds still identified something.
    screen : Screen
        Of the current solution.
    tests : int
        Number of forms tested in a round.
    progress : callable
        Called with a sentence at each step.
    """

    problem: LeastSquares
    solution: Solution
    candidates: Mapping[str, Candidate]
    progress: Callable[[str], None]
    found: list[Refit] = field(default_factory=list)
    refinements: list[Refit] = field(default_factory=list)
    structures: list[Structure] = field(default_factory=list)
    forms: list[Structure] = field(default_factory=list)
    last: list[Tried] = field(default_factory=list)
    screen: Screen = field(init=False)
    tests: int = 0
    rivals: frozenset[str] = frozenset()
    stopped: bool = False
    _passing: list[Refit] = field(default_factory=list)  # of the last round

    def copy(self) -> Search:
        """Return a search that continues from here without a change of this one."""
        other = copy(self)
        other.found, other.refinements = list(self.found), list(self.refinements)
        return other

    def run(self) -> None:
        """Repeat rounds until no candidate passes the criteria."""
        for _ in range(ROUNDS):
            best = self.round()
            if best is None:
                break
            if isinstance(best, Structure):
                if not self._accept_structure(best):
                    break
            else:
                if not self.found:
                    self.rivals = rivals(best, self._passing)
                self.accept(best)
                self.progress(f"identified: {best.name} (gain {100 * best.gain:.2f} %)")
        else:
            self.stopped = True
        self.screen = Screen(self.problem, self.solution)
        self.last = self.probe()

    def extended(self) -> bool:
        """Add the effects that pass the criteria to the model, and return whether there were any."""
        before = len(self.found) + len(self.refinements)
        for _ in range(ROUNDS):
            best = self.best_effect()
            if best is None:
                break
            self.accept(best)
            self.progress(f"identified: {best.name} (gain {100 * best.gain:.2f} %)")
        return len(self.found) + len(self.refinements) > before

    def round(self) -> Refit | Structure | None:
        """Return the best candidate that passes, or unexplained structure with a much larger gain."""
        best = self.best_effect()
        structure = structure_of(self.screen)
        if structure is None or not structure.passes or not self._predicts_holdout(structure):
            return best
        if is_drift(self.screen, structure):
            return best
        if not set(structure.depends_on) <= CORE_INPUTS | self._varied():
            structure = self._core_first(structure)
        share = 1.0 if self._is_finer_form(structure) else PREFERRED_SHARE
        if best and best.gain > share * structure.gain:
            return best
        if self._is_finer_form(structure):
            return structure
        return best if best and self._joint_gain(best) > PREFERRED_JOINT_SHARE * structure.gain else structure

    def _core_first(self, structure: Structure) -> Structure:
        """Return the part of a structure that is an error of the functional form, if this alone is significant."""
        part = core_part(self.screen, structure)
        return part if part is not None and part.passes and self._predicts_holdout(part) else structure

    def best_effect(self) -> Refit | None:
        """Test all candidates on the residual and return the best one that passes."""
        self.screen = Screen(self.problem, self.solution)
        self.last = self.probe()
        self.tests = len(self.last)
        ordered = sorted(self.last, key=lambda tried: float(tried.response.loss.sum()))
        effects = [tried for tried in ordered if not tried.name.startswith(REFINEMENT)]
        chosen = (
            distinct(effects)[:REFITTED]
            + distinct([t for t in ordered if t.name.startswith(REFINEMENT)])[:REFITTED_REFINEMENTS]
        )
        promising = [t for t in chosen if t.response.p_coloured * self.tests < P_FACTOR * EFFECT_P]
        refits = [refit for tried in promising if (refit := self.refit(tried)) is not None]
        passing = [refit for refit in refits if refit.passes and not self._is_form_artefact(refit)]
        self._passing = [refit for refit in passing if not self._is_part_of_memory(refit)]
        found = {refit.name for refit in self.found}
        return preferred(self._passing, self.candidates, found) if self._passing else None

    def accept(self, refit: Refit) -> None:
        """Add an effect or a refinement to the model."""
        (self.refinements if refit.name.startswith(REFINEMENT) else self.found).append(refit)
        self.solution = refit.solution

    def _joint_gain(self, first: Refit) -> float:
        """Return the gain of an effect together with those that the next rounds would identify.

        If several effects are missing, no single one explains the residual.
        """
        lookahead = Search(self.problem, self.solution, self.candidates, lambda sentence: None)
        lookahead.found, lookahead.refinements = list(self.found), list(self.refinements)
        refit: Refit | None = first
        for _ in range(LOOKAHEAD):
            if refit is None:
                break
            lookahead.accept(refit)
            refit = lookahead.best_effect()
        total, remaining = (
            float(screen.baseline.loss.sum()) for screen in (self.screen, Screen(self.problem, lookahead.solution))
        )
        return (total - remaining) / total

    def _varied(self) -> set[str]:
        """Return the inputs of the identified effects."""
        varied = {name for refit in self.found for name in self.candidates[refit.name].requires}
        if any(self.candidates[refit.name].has_states for refit in self.found):
            return varied | PAST
        return varied | {"T", "distance"} if {"distance", "T"} & varied else varied

    def _is_finer_form(self, structure: Structure) -> bool:
        """Return whether structure is an error of the form of an identified effect."""
        varied = self._varied()
        return set(structure.depends_on) <= CORE_INPUTS | varied and bool(
            set(structure.depends_on) & varied - CORE_INPUTS
        )

    def _predicts_holdout(self, structure: Structure) -> bool:
        """Return whether structure reduces the error on the hold-out set, or in every long stretch."""
        return (
            bool(np.all(structure.stretch_gains > 0.0))
            or self.problem.holdout_gain(self.solution, self._with_structure(structure, "structure")[1]) > 0.0
        )

    def _with_structure(self, structure: Structure, name: str) -> tuple[LeastSquares, Solution]:
        """Return problem and solution with structure as a disturbance."""
        sizes = np.maximum(np.abs(structure.response.estimate), 1e-6) * 20.0
        names = tuple(f"{name}_{i}" for i in range(len(sizes)))
        disturbances = self.problem.disturbances.extended(names, structure.columns, sizes)
        problem = replace(self.problem, disturbances=disturbances)
        return problem, problem.solve(self.solution.parameters, self.solution.free, iterations=4)

    def _accept_structure(self, structure: Structure) -> bool:
        """Add structure to the disturbances if it only corrects the form of the model; return whether it does."""
        if not set(structure.depends_on) <= CORE_INPUTS | self._varied():
            self.structures.append(structure)
            self.progress(f"unexplained structure: {structure.formula}")
            return False
        self.forms.append(structure)
        self.progress(f"correction of the functional form: {structure.formula}")
        self.problem, self.solution = self._with_structure(structure, f"form_{len(self.forms)}")
        return True

    def _is_form_artefact(self, refit: Refit) -> bool:
        """Return whether a candidate is an artefact of model-form error: confounded with an identified effect."""
        columns = {refit.name: self.screen.columns(refit.form)}
        return any(
            correlations(self.screen, one.form.free, columns, {}).get(refit.name, 0.0) > CONFOUNDED
            for one in self.found
        )  # fmt: skip

    def _is_part_of_memory(self, refit: Refit) -> bool:
        """Return whether a candidate of the past, or of what heats, gains little beside a found effect of the past.

        The form of an effect with states is uncertain, and its error resembles a further one, also a relaxation. A
        recorded temperature
        follows the sliding, too: the error of its effect resembles an effect with states.
        """
        candidate = self.candidates.get(refit.name)
        lags = refit.name in self.problem.simulator.symbolic_model.relaxing_effects
        if candidate is None or not (lags or candidate.has_states or PAST.intersection(candidate.requires)):
            return False
        resembled = [
            float(one.gains.sum())
            for one in self.found
            if (known := self.candidates[one.name]).has_states or (candidate.has_states and "T" in known.requires)
        ]
        return bool(resembled) and float(refit.gains.sum()) < FURTHER_MEMORY * max(resembled)

    def probe(self) -> list[Tried]:
        """Estimate the noise, and return every testable form with its response."""
        tire, identified = self.problem.simulator.tire, frozenset(refit.name for refit in self.found)
        candidates = [candidate for name, candidate in self.candidates.items() if name not in identified]
        refinements = [(f"{REFINEMENT}{name}", form) for name, form in refinements_for(tire, identified)]
        return self.tested([*self.forms_of(candidates), *refinements])

    def forms_of(self, candidates: Iterable[Candidate]) -> list[tuple[str, Form]]:
        """Return the forms of candidates whose inputs vary with their names, one for each point of a grid."""
        signals, tire = self.problem.simulator.signals, self.problem.simulator.tire
        return [
            (candidate.name, point)
            for candidate in candidates
            if is_testable(signals, tire, candidate)
            for form in candidate.forms
            for point in form.points()
        ]

    def tested(self, forms: Iterable[tuple[str, Form]]) -> list[Tried]:
        """Estimate the noise, and return the forms that can be tested with their responses."""
        tried = [
            (name, form)
            for name, declared in forms
            if (form := unfitted(declared, self.problem.simulator, self.solution.free))
        ]
        columns = {i: self.screen.columns(form) for i, (_, form) in enumerate(tried)}
        self.screen.learn_noise(columns)
        return [Tried(name, form, self.screen.response(columns[i])) for i, (name, form) in enumerate(tried)]

    def refit(self, tried: Tried) -> Refit | None:
        """Fit a form jointly with the current model, from its initial values."""
        form, response = tried.form, tried.response
        order = self.problem.simulator.names
        free = tuple(sorted({*self.solution.free, *form.free}, key=order.index))
        thin = slice(None, None, max(1, len(self.problem.simulator.signals.rows) // SEARCH_ROWS))
        tries = [
            self.problem.solve(start, free, rows=thin, iterations=8)
            for start in starts(self.problem.simulator, self.solution, form, response.estimate)
        ]
        best = min(tries, key=lambda solution: solution.cost)
        solution = self.problem.solve(best.parameters, free, iterations=4)
        screen = Screen(self.problem, solution)
        gains = self.screen.baseline.loss - screen.baseline.loss
        total = float(self.screen.baseline.loss.sum())
        error = error_of_sum(gains)
        p = min(1.0, response.p_coloured * self.tests)
        return Refit(
            tried.name, form, solution, screen, p, float(gains.sum()) / total, error / total, gains, response
        )  # fmt: skip
