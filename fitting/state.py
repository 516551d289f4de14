"""The state of a fit between two stages."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace

import pandas as pd

from ..tires.tire import Tire
from .constraints.verification import ConstraintPoints
from .problem.recipe import FreeCoefficient
from .problem.slope_targets import SlopeTarget
from .results.stages import StageResult


@dataclass(frozen=True, eq=False)
class FitState:
    """What a fit has found so far, in adapted SAE. `solve_stage` makes the next state from it.

    - `tire`: with the present values.
    - `table`: the fitted rows, with the states of effects as they were simulated last.
    - `free`: the coefficients that stages have freed: first guess, last bounds.
    - `stages`: the results of the stages that were solved.
    - `violated`, shape (n_inputs, n_points): points that the verification of constraints has added.
    - `targets`: the slip stiffnesses that are read from the data; None before a stage uses them.
    - `notes`: notes for the user.
    - `completed`: number of completed stages of the recipe.
    """

    tire: Tire
    table: pd.DataFrame
    free: Mapping[str, FreeCoefficient] = field(default_factory=dict)
    stages: tuple[StageResult, ...] = ()
    violated: tuple[ConstraintPoints, ...] = ()
    targets: tuple[SlopeTarget, ...] | None = None
    notes: tuple[str, ...] = ()
    completed: int = 0

    @property
    def determined(self) -> frozenset[str]:
        """The coefficients that a stage has determined."""
        return frozenset(name for name, freed in self.free.items() if freed.determined)

    def with_values(self, values: Mapping[str, float]) -> FitState:
        """Return the state with other values of some coefficients."""
        return replace(self, tire=replace(self.tire, values={**self.tire.values, **values}))

    def with_note(self, note: str) -> FitState:
        """Return the state with one more note."""
        return replace(self, notes=(*self.notes, note))
