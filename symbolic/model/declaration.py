"""The declarations of a tire model: the fields of its definition, such as those in `symbolic/mf96/__init__.py`."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

from ..added import AddedEffect
from ..contract import Baseline, FitDeclaration, Motion, PropertyFile, Role
from ..declarations import Effect, Quantity, Section

if TYPE_CHECKING:
    from ..notation import Chapter


@dataclass(frozen=True, eq=False)
class Source:
    """Where the lines of a model are.

    - `chapters`: the lines, in an order in which each uses only earlier ones: chapters, or modules of its folder that
      have one as ``eq`` and are imported when the lines are needed.
    - `folder`: its package, with these modules and its recipes: ``__name__`` of the folder's ``__init__.py``.
    - `own_effects`: effects of its lines that `tirefmu.symbolic.effects` does not have.
    """

    chapters: tuple[str | Chapter, ...]
    folder: str = ""
    own_effects: tuple[Effect, ...] = ()


@dataclass(frozen=True, eq=False, repr=False)
class ModelDeclaration:
    """The declarations of a tire model: its lines, and everything that other packages need.

    - `name`: as on the command line: a lower-case word.
    - `inputs`, `outputs`: kappa and alpha first, Fz among them; Fx and Fy among the outputs.
    - `sections`: the coefficients, by .tir section.
    - `source`: where its lines are.
    - `results`: named quantities that are results in addition to the outputs, such as radii: a coefficient that reaches
      one of them is not idle.
    - `on_demand`: effects that act only in rows in which an input is not 0, and the input's name (turn_slip: phit).
    - `roles`: which named quantity has which of `tirefmu.symbolic.contract.ROLES`; it lacks the others.
    - `property_file`: how its .tir files are recognized and written.
    - `fit`, `baseline`, `motion`: what a fit, a diagnosis and a simulation need of it.
    - `added`: effects beyond the book; see `extended`.
    """

    name: str
    title: str
    inputs: tuple[Quantity, ...]
    outputs: tuple[Quantity, ...]
    sections: tuple[type[Section], ...]
    source: Source
    results: tuple[str, ...] = ()
    on_demand: tuple[tuple[str, str], ...] = ()
    roles: Mapping[str, Role] = field(default_factory=dict)
    property_file: PropertyFile = field(default_factory=PropertyFile)
    fit: FitDeclaration = field(default_factory=FitDeclaration)
    baseline: Baseline = field(default_factory=Baseline)
    motion: Motion = field(default_factory=Motion)
    added: tuple[AddedEffect, ...] = ()
