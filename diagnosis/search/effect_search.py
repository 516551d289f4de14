"""Stepwise search: probe all candidates, refit the best, rank by blocked cross-validation, test, repeat."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace

import numpy as np
import numpy.typing as npt

from tirefmu.estimation.noise_model import Whitening, noise_parts
from tirefmu.symbolic.detection import Form

from ..least_squares import LeastSquares, Solution
from ..probing.baseline_fit import readable
from ..probing.candidates import Candidate, refinements_for, varies
from ..probing.confounding import correlations
from ..probing.effect_probing import Response, Screen
from ..thresholds import (
    CONFOUNDED,
    EFFECT_P,
    FINAL_ITERATIONS,
    LOOKAHEAD,
    PREFERRED_JOINT_SHARE,
    PREFERRED_SHARE,
    REFIT_P_FACTOR,
    REFITTED,
    REFITTED_REFINEMENTS,
    ROUNDS,
    SEARCH_ROWS,
)
from ..unexplained.structure import CORE_INPUTS, Structure, structure_of
from .refits import REFINEMENT, Refit, Tried, distinct, preferred

FloatArray = npt.NDArray[np.float64]


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
    screen : Screen
        Of the current solution.
    whitened : Screen
        Of the final solution with whitened rows, for confidence intervals.
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
    whitened: Screen = field(init=False)
    tests: int = 0

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
                self._accept_effect(best)
                self.progress(f"identified: {best.name} (gain {100 * best.gain:.2f} %)")
        self.screen = Screen(self.problem, self.solution)
        self.last = self.probe()

    def refit_whitened(self, before: Screen) -> Screen:
        """Refit the baseline model and the final model with whitened noise; return the screen of the baseline model.

        The search itself uses rows of equal weight. A missing effect resembles correlated noise, and whitening
        amplifies errors in the functional form of a model.
        """
        self.whitened = self.screen
        signals = self.problem.simulator.signals
        if not signals.timed:
            return before
        t = signals.t[signals.rows]
        rest, step = self.problem.weighted(self.solution.residual), float(np.median(np.diff(t)))
        inverse_noise = self.problem.inverse_noise
        noise = tuple(noise_parts(*rows, step) for rows in zip(rest, inverse_noise > 0.0, strict=True))
        whitening = Whitening(noise, t, inverse_noise)
        whitened, same = replace(self.problem, whitening=whitening), self.solution is before.solution
        self.solution = whitened.solve(self.solution.parameters, self.solution.free, iterations=FINAL_ITERATIONS)
        start = self.solution
        if not same:
            first = replace(before.problem, whitening=whitening)
            start = first.solve(before.solution.parameters, before.solution.free, iterations=FINAL_ITERATIONS)
        self.whitened = Screen(whitened, self.solution)
        self.whitened.learn_noise({})
        self.screen = Screen(self.problem, self.solution)
        self.last = self.probe()
        return Screen(before.problem, start)

    def round(self) -> Refit | Structure | None:
        """Return the best candidate that passes, or unexplained structure with a much larger gain."""
        best = self.best_effect()
        structure = structure_of(self.screen)
        if structure is None or not structure.passes or (best and best.gain > PREFERRED_SHARE * structure.gain):
            return best
        return best if best and self._joint_gain(best) > PREFERRED_JOINT_SHARE * structure.gain else structure

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
        promising = [t for t in chosen if t.response.p_coloured * self.tests < REFIT_P_FACTOR * EFFECT_P]
        refits = [refit for tried in promising if (refit := self.refit(tried)) is not None]
        passing = [refit for refit in refits if refit.passes and not self._is_form_artefact(refit)]
        return preferred(passing, self.candidates) if passing else None

    def _accept_effect(self, refit: Refit) -> None:
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
            lookahead._accept_effect(refit)
            refit = lookahead.best_effect()
        total, remaining = (
            float(screen.baseline.loss.sum()) for screen in (self.screen, Screen(self.problem, lookahead.solution))
        )
        return (total - remaining) / total

    def _accept_structure(self, structure: Structure) -> bool:
        """Add structure to the disturbances if it only corrects the form of the model; return whether it does."""
        varied = {name for refit in self.found for name in self.candidates[refit.name].requires}
        if {"distance", "T"} & varied:
            varied |= {"T", "distance"}
        if not set(structure.depends_on) <= CORE_INPUTS | varied:
            self.structures.append(structure)
            self.progress(f"unexplained structure: {structure.formula}")
            return False
        self.forms.append(structure)
        self.progress(f"correction of the functional form: {structure.formula}")
        sizes = np.maximum(np.abs(structure.response.estimate), 1e-6) * 20.0
        names = tuple(f"form_{len(self.forms)}_{i}" for i in range(len(sizes)))
        disturbances = self.problem.disturbances.extended(names, structure.columns, sizes)
        self.problem = replace(self.problem, disturbances=disturbances)
        self.solution = self.problem.solve(self.solution.parameters, self.solution.free, iterations=4)
        return True

    def _is_form_artefact(self, refit: Refit) -> bool:
        """Return whether a candidate is an artefact of model-form error: confounded with an identified effect."""
        columns = {refit.name: self.screen.columns(refit.form)}
        return any(
            correlations(self.screen, one.form.free, columns, {}).get(refit.name, 0.0) > CONFOUNDED
            for one in self.found
        )  # fmt: skip

    def probe(self) -> list[Tried]:
        """Estimate the noise, and return every testable form with its response."""
        signals, tire = self.problem.simulator.signals, self.problem.simulator.tire
        identified = frozenset(refit.name for refit in self.found)
        forms: list[tuple[str, Form]] = []
        for name, candidate in self.candidates.items():
            if name in identified or not all(varies(signals, tire, needed) for needed in candidate.requires):
                continue
            forms += [(name, form) for form in candidate.forms]
        forms += [(f"{REFINEMENT}{name}", form) for name, form in refinements_for(tire, identified)]
        tried = [(name, form) for name, declared in forms if (form := self._readable(declared))]
        columns = {i: self.screen.columns(form) for i, (_, form) in enumerate(tried)}
        self.screen.learn_noise(columns)
        return [Tried(name, form, self.screen.response(columns[i])) for i, (name, form) in enumerate(tried)]

    def _readable(self, form: Form) -> Form | None:
        """Return a form with the coefficients that influence a channel and are not yet free."""
        already_free, simulator = self.solution.free, self.problem.simulator
        names = [n for n in readable(form.free, simulator.signals, simulator.book) if n not in already_free]
        probes = tuple(probe for probe in form.probes if set(probe) & set(names))
        return replace(form, free=tuple(names), probes=probes) if names and probes else None

    def refit(self, tried: Tried) -> Refit | None:
        """Fit a form jointly with the current model, from its initial values."""
        form, response = tried.form, tried.response
        order = self.problem.simulator.names
        free = tuple(sorted({*self.solution.free, *form.free}, key=order.index))
        thin = slice(None, None, max(1, len(self.problem.simulator.signals.rows) // SEARCH_ROWS))
        tries = [self.problem.solve(start, free, rows=thin, iterations=8) for start in self._starts(form, response)]
        best = min(tries, key=lambda solution: solution.cost)
        solution = self.problem.solve(best.parameters, free, iterations=4)
        screen = Screen(self.problem, solution)
        gains = self.screen.baseline.loss - screen.baseline.loss
        total = float(self.screen.baseline.loss.sum())
        error = float(np.sqrt(len(gains)) * np.std(gains, ddof=1))
        p = min(1.0, response.p_coloured * self.tests)
        return Refit(
            tried.name, form, solution, screen, p, float(gains.sum()) / total, error / total, gains, response
        )  # fmt: skip

    def _starts(self, form: Form, response: Response) -> list[FloatArray]:
        if not form.scalable:
            return [self.screen.probed(form, probe) for probe in form.probes]
        start = self.solution.parameters.copy()
        for probe, times in zip(form.probes, response.estimate, strict=True):
            for name, value in probe.items():
                start[self.problem.simulator.index[name]] += float(np.clip(times, -3.0, 3.0)) * value
        return [start]
