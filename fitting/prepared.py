"""The stages of a fit with all that their recipe and the data decide before the first of them is solved."""

from __future__ import annotations

from collections.abc import Mapping, Sequence, Set
from dataclasses import dataclass, replace

import numpy as np
import pandas as pd

from ..numerics.arrays import IntArray
from ..tires.tire import Tire
from .problem.influence import generic
from .problem.recipe import FreeCoefficient, Stage
from .problem.rows import Rows
from .problem.weighted_residuals import coefficients_by_output
from .setup import Setup


@dataclass(frozen=True, eq=False)
class PreparedStage:
    """A stage of a fit.

    - `recipe`: what the recipe states of it.
    - `channels`: its channels among the fitted ones.
    - `names`: the coefficients that it may free: those that influence its channels, by section and effect.
    - `kind`: "intermediate", "penultimate" (before a stage with all rows) or "final".
    - `continues`: whether the stage before has the same channels and coefficients, and fewer rows.
    """

    setup: Setup
    recipe: Stage
    channels: tuple[str, ...]
    names: tuple[str, ...]
    kind: str = "final"
    continues: bool = False

    @classmethod
    def of(cls, setup: Setup, stage: Stage) -> PreparedStage:
        """Return a stage without regard to the others."""
        channels = tuple(name for name in setup.channels if not stage.channels or name in stage.channels)
        return cls(setup, stage, channels, _names(setup, stage, channels))

    def among(self, before: PreparedStage | None, following: Sequence[PreparedStage]) -> PreparedStage:
        """Return the stage with its kind, and whether it continues the one before.

        A stage is final if it uses all rows, or if no later stage frees all of its coefficients.
        """
        whole = self.recipe.rows is None
        kind = "penultimate" if following and following[0].recipe.rows is None else "intermediate"
        if whole or not any(set(self.names).issubset(later.names) for later in following):
            kind = "final"
        continues = (
            whole
            and before is not None
            and before.recipe.rows is not None
            and (before.channels, before.names) == (self.channels, self.names)
        )
        return replace(self, kind=kind, continues=continues)

    def count(self) -> int:
        """Return the number of rows that it uses."""
        rows = len(self._chosen(self.setup.table))
        return min(rows, self.recipe.rows or rows)

    def rows(self, table: pd.DataFrame, tire: Tire) -> tuple[Rows, IntArray]:
        """Return the rows of the stage, and the number of each, counted over all rows of all recordings.

        `table`: all fitted rows. If the stage uses all of them, it shares their arrays with all other stages.
        """
        chosen = self._chosen(table)
        numbers = chosen.index.to_numpy(dtype=np.int64)
        if chosen is self.setup.table and self.setup.rows is not None:
            return self.setup.rows.only([name in self.channels for name in tire.outputs]), numbers
        return Rows.of(chosen, tire, self.channels), numbers

    def _chosen(self, table: pd.DataFrame) -> pd.DataFrame:
        chosen = self.recipe.select(table)
        if not self.channels:
            return chosen[:0]
        present = chosen[list(self.channels)].notna().any(axis=1)
        return chosen if present.all() else chosen[present]

    def guesses(self, determined: Set[str]) -> Mapping[str, float]:
        """Return the guesses of the recipe, or generic values of coefficients that no stage has `determined` yet."""
        plan, declared = self.setup.plan, self.setup.plan.symbolic_model.coefficients
        if self.recipe.free:
            given = {name: freed for name, freed in self.recipe.free.items() if name not in plan.options.fixed}
            return {name: min(max(freed.guess, freed.lower), freed.upper) for name, freed in given.items()}
        if plan.start is not None:  # generic values do not replace those of a start tire
            return {}
        new = [name for name in self.names if name not in determined]
        return {name: self.setup.read.get(name, generic(declared[name])) for name in new}

    def bounds(self, tire: Tire) -> dict[str, FreeCoefficient]:
        """Return its coefficients with the values of a tire as guesses."""
        declared = self.setup.plan.symbolic_model.coefficients
        limits = {name: self.recipe.free.get(name, declared[name]) for name in self.names}
        return {name: FreeCoefficient(tire.values[name], both.lower, both.upper) for name, both in limits.items()}


def prepared_stages(setup: Setup) -> tuple[PreparedStage, ...]:
    """Return the stages of the recipe in order."""
    stages = [PreparedStage.of(setup, stage) for stage in setup.plan.recipe.stages]
    befores = [None, *stages[:-1]]
    return tuple(
        stage.among(before, stages[number + 1 :])
        for number, (before, stage) in enumerate(zip(befores, stages, strict=True))
    )


def _names(setup: Setup, stage: Stage, channels: Sequence[str]) -> tuple[str, ...]:
    """Return the coefficients that a stage may free, in the order of the stage or of the model."""
    model, effects = setup.plan.symbolic_model, setup.tire.has
    reaching = coefficients_by_output(model, plain=setup.plain)
    reaches = frozenset[str]().union(*(reaching[name] for name in channels))
    live = (model.live(effects) & reaches) - setup.plan.options.fixed.keys()
    if stage.free:
        return tuple(name for name in stage.free if name in live)
    if stage.effects is not None:
        live &= model.live(effects.intersection(stage.effects))
    # A section whose coefficients are not fitted by default is freed as a whole by a stage that names it.
    requested = set(stage.sections) - {c.section for c in model.coefficients.values() if c.fitted}
    return tuple(
        name
        for name, c in model.coefficients.items()
        if name in live and (c.fitted or c.section in requested) and (not stage.sections or c.section in stage.sections)
    )
