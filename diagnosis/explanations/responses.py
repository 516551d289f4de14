"""What the effects of an explanation change in the forces at a solution, and by how much their forms may err."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from ...numerics.arrays import FloatArray
from ..least_squares import Solution
from ..probing.candidates import Candidate, declared_candidate, varies
from ..signals.simulation import Simulator
from ..thresholds import FORM_ERROR, PAST_ERROR
from ..unexplained.features import CORE_INPUTS
from .discrepancy import effect_discrepancy, envelope
from .explanation import Explanation

#: Factor between the memories of an effect of the past. Convention.
OTHER_MEMORY = 3.0


@dataclass(frozen=True, eq=False)
class Responses:
    """Of the forces to the effects of an explanation at a solution."""

    explanation: Explanation
    simulator: Simulator
    solution: Solution
    candidates: Mapping[str, Candidate]

    @cached_property
    def forces(self) -> FloatArray:
        """Of the solution, shape (n_channels, n)."""
        return self.simulator.forces(self.solution.parameters)

    def of(self, effect: str) -> FloatArray:
        """Return the change of the forces by an effect of the explanation, shape (n_channels, n)."""
        return np.asarray(np.nan_to_num(self.forces - self.without(effect)))

    def without(self, effect: str) -> FloatArray:
        """Return the forces without an effect of the explanation, shape (n_channels, n)."""
        simulator = self.simulator
        owned = self.explanation.only_of(effect, simulator.symbolic_model.owned(effect)) & simulator.index.keys()
        return simulator.forces(simulator.without(self.solution.parameters, owned))

    @property
    def static(self) -> Explanation:
        """The effects of the explanation that follow their inputs at once, without turn slip, which is a rate."""
        forms = [(name, form) for name, form in self.explanation.forms if self._follows_at_once(name)]
        return Explanation(tuple(form for form in forms if "phit" not in self.candidates[form[0]].requires))

    def _follows_at_once(self, effect: str) -> bool:
        relaxing = self.simulator.symbolic_model.relaxing_effects
        return not self.candidates[effect].has_states and effect not in relaxing

    def errors_of(self, effect: str) -> FloatArray:
        """Return errors of the form of an effect, N and N m, shape (n_channels, n, k), each of deviation 1.

        Those of an effect with states are larger and depend on these. A tire has more than one memory: the effect of
        the past with shorter and longer memories is an error, too. An effect of a path may turn elsewhere on it: its
        errors are in proportion to its size there.
        """
        simulator, candidate = self.simulator, self.candidates[effect]
        model = simulator.symbolic_model
        response = self.of(effect)
        if self._follows_at_once(effect):
            return self.errors_at_once(response, candidate.reads)
        inputs = self._inputs(candidate.reads)
        states = [state for added in model.added if added.name == effect for state in added.states]
        if candidate.has_states:
            rows = simulator.effective_inputs(self.solution.parameters)
            acting = dict(zip(simulator.signals.names, rows, strict=True))
            inputs |= {state.name: acting[state.name] for state in states}
            inputs |= {f"lagged {name}": np.abs(acting[name]) for name in ("alpha", "kappa") if name in acting}
        if any(state.follows_a_path for state in states):
            response = envelope(response, simulator.signals)
        # The contact moves on one carcass, as in a relaxation; a tire has several memories.
        size = PAST_ERROR if candidate.has_states and not any(state.oscillates for state in states) else FORM_ERROR
        smooth = effect_discrepancy(size * response, inputs)
        return np.concatenate([smooth, size * self._other_pasts(effect)], axis=-1)

    def errors_at_once(self, response: FloatArray, depends_on: Collection[str]) -> FloatArray:
        """Return errors of a form that follows the inputs of the core and others at once, N and N m, of deviation 1."""
        return effect_discrepancy(FORM_ERROR * response, self._inputs(depends_on))

    def errors_of_baseline(self) -> FloatArray:
        """Return errors of the forms of the baseline model's effects, N and N m, shape (n_channels, n, k).

        Those of effects of the core inputs alone are in the discrepancy of the model. Each column is the sum of the
        errors of all effects, by independent random functions: the covariance is that of a sum of independent Gaussian
        processes.
        """
        model, index = self.simulator.symbolic_model, self.simulator.index
        errors = np.zeros((*self.forces.shape, 0))
        for number, effect in enumerate(sorted(self.simulator.tire.has)):
            absent, declared = self.solution.parameters.copy(), declared_candidate(effect, model)
            if declared is None or CORE_INPUTS.issuperset(declared.requires):
                continue
            for name in model.owned(effect) & index.keys():
                if (neutral := model.coefficients[name].neutral) is not None:
                    absent[index[name]] = neutral
            response = np.nan_to_num(self.forces - self.simulator.forces(absent))
            of_effect = effect_discrepancy(response, self._inputs(declared.reads), seed=number + 1)
            errors = of_effect + errors if errors.size else of_effect
        return FORM_ERROR * errors

    def _inputs(self, others: Collection[str]) -> dict[str, FloatArray]:
        """Return the inputs of an error of form at the compared rows: those of the core, and others that vary."""
        signals, tire = self.simulator.signals, self.simulator.tire
        varying = {name for name in others if varies(signals, tire, name)}
        named = signals.named()
        return {name: named[name] for name in sorted(CORE_INPUTS.union(varying).intersection(named))}

    def _other_pasts(self, effect: str) -> FloatArray:
        """Return the change of the forces by an effect with shorter and longer memories, N and N m."""
        simulator, solution, absent = self.simulator, self.solution, self.without(effect)
        form = dict(self.explanation.forms)[effect]
        memories, pasts = form.grid or (() if form.scalable else form.free), []
        for name in memories:
            for times in (1.0 / OTHER_MEMORY, OTHER_MEMORY):
                parameters = solution.parameters.copy()
                parameters[simulator.index[name]] *= times
                pasts.append(np.nan_to_num(simulator.forces(parameters) - absent))
        return np.stack(pasts, axis=-1) if pasts else np.zeros((*self.forces.shape, 0))
