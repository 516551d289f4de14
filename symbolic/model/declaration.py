"""The declarations of a tire model: the fields of its definition, such as those in `symbolic/mf96/__init__.py`."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

from ..added import AddedEffect
from ..contract import PhysicalConstraint, PropertyFile, Role
from ..declarations import Effect, Quantity, Section

if TYPE_CHECKING:
    from ..notation import Chapter


@dataclass(frozen=True, eq=False, repr=False)
class ModelDeclaration:
    """The declarations of a tire model: its lines, and everything that other packages need.

    - `name`: as on the command line: a lower-case word.
    - `inputs`, `outputs`: kappa and alpha first, Fz among them; Fx and Fy among the outputs.
    - `sections`: the coefficients, by .tir section.
    - `chapters`: the lines, in an order in which each uses only earlier ones: chapters, or modules of its folder that
      have one as ``eq`` and are imported when the lines are needed.
    - `results`: named quantities that are results in addition to the outputs, such as radii: a coefficient that reaches
      one of them is not idle.
    - `on_demand`: effects that act only in rows in which an input is not 0, and the input's name (turn_slip: phit).
    - `own_effects`: effects of its lines that are not in `tirefmu.symbolic.effects`.
    - `roles`: the named quantity of each of its `tirefmu.symbolic.contract.ROLES`; it lacks the others.
    - `property_file`: how its .tir files are recognized and written.
    - `constraints`: the constraints of a fit, by the output to which they belong.
    - `recipe`: the default fit recipe: one of the package's, or of its own.
    - `recipes`: its own recipes: ``<name>.toml`` in its folder.
    - `folder`: its package, with these files: ``__name__`` of the folder's ``__init__.py``.
    - `baseline`: the coefficients of the fit of a tire without effects.
    - `starts`: several starts of the baseline in adapted SAE, against local optima; others start at generic values.
    - `spread`: standard deviation among tires of coefficients of the baseline that a recording may leave undetermined.
    - `refinements`: refinements of the baseline that a diagnosis tries: coefficients and sizes to probe with, in
      adapted SAE.
    - `relaxation`: the coefficients of its relaxation lengths, which act through time only.
    - `own_relaxation`: the coefficient that scales relaxation lengths which follow from other coefficients, then those
      that must be known for it. An FMU with wheel inputs uses these lengths if the tire has no relaxation.
    - `low_speed`: the coefficient with the speed, m/s, below which slips are those of a standing wheel, if any.
    - `reverses`: whether its forces at a given kappa change their direction with the sign of V: kappa is then positive
      where it drives the wheel in its direction of travel. The equations of other models are those of a wheel that
      rolls forward: an FMU that computes slips mirrors their forces where the wheel rolls backward.
    - `friction_scales`: the coefficients to which friction is proportional: a road with another friction multiplies
      each of them.
    - `added`: effects beyond the book; see `extended`.
    """

    name: str
    title: str
    inputs: tuple[Quantity, ...]
    outputs: tuple[Quantity, ...]
    sections: tuple[type[Section], ...]
    chapters: tuple[str | Chapter, ...]
    results: tuple[str, ...] = ()
    on_demand: tuple[tuple[str, str], ...] = ()
    own_effects: tuple[Effect, ...] = ()
    roles: Mapping[str, Role] = field(default_factory=dict)
    property_file: PropertyFile = field(default_factory=PropertyFile)
    constraints: Mapping[str, tuple[PhysicalConstraint, ...]] = field(default_factory=dict)
    recipe: str = "joint"
    recipes: tuple[str, ...] = ()
    folder: str = ""
    baseline: tuple[str, ...] = ()
    starts: tuple[Mapping[str, float], ...] = ({},)
    spread: Mapping[str, float] = field(default_factory=dict)
    refinements: tuple[Mapping[str, float], ...] = ()
    relaxation: tuple[str, ...] = ()
    own_relaxation: tuple[str, ...] = ()
    low_speed: str = ""
    reverses: bool = False
    friction_scales: tuple[str, ...] = ()
    added: tuple[AddedEffect, ...] = ()
