"""Recipes: the stages of a fit, as TOML files.

A stage has one of three types. Intermediate stages use random rows and are followed by another such stage. A
penultimate stage precedes a stage with all rows. All others are final. A stage that a later one continues may end when
little further gain is possible. Rows are sampled at random, because every k-th row would alias with sweeps.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from importlib.resources import files
from math import inf
from pathlib import Path
from typing import Annotated, Any

import numpy as np
import pandas as pd

from ...boundary.bounded_file import toml_content, toml_file
from ...boundary.errors import DataError, FitError, UnknownName
from ...boundary.json_schema import document, object_schema, one_of
from ...boundary.schema_check import check_content
from ...measurements.row_selection.expression import Selection, parse_range, parse_selection
from ...numerics.arrays import FloatArray
from ...symbolic.channels import CHANNELS
from ...symbolic.effects import EFFECTS
from ...symbolic.model import Model
from ...symbolic.models import MODELS, model_named

#: The recipes that come with the package.
RECIPES = ("progressive", "joint", "trento", "scaling", "family")
#: How a stage weights its channels.
WEIGHTS = ("equal", "noise")


@dataclass(frozen=True)
class FreeCoefficient:
    """A coefficient that a stage frees, in adapted SAE.

    - `stage`, `determined`: the last stage that determined it, and whether one did.
    """

    guess: float
    lower: float
    upper: float
    stage: str = ""
    determined: bool = False


@dataclass(frozen=True)
class Stage:
    """One stage of a recipe.

    - `channels`: the fitted channels; all measured channels if empty.
    - `where`: operating conditions: values and tolerances of inputs, SI units, adapted SAE.
    - `selection`: condition of the key ``select``, an expression of channels as in ``--where``, in adapted SAE.
    - `hold`: inputs whose measured values are replaced by the nearest value in `where`.
    - `free`: the free coefficients; all coefficients of the core and of the effects if empty.
    - `sections`: only coefficients of these sections of the .tir file; of all sections if empty. Those that a fit does
      not free by default (`fitted` of their declaration) only if the section has no other.
    - `effects`: only coefficients of the core and of these effects of the tire; of all effects if None. A recipe may
      apply to several models: channels, sections and effects that a model does not have are ignored.
    - `rows`: number of random rows; all rows if None.
    - `weights`: "equal": weight of a channel by its mean square; "noise": weight of a channel of a recording by its
      residual variance at the initial values, times `SWEPT` if the slip of the channel is swept.
    - `again`: other initial values of a few coefficients. The stage is repeated from them if a start tire was given or
      one of these coefficients is at a bound; the best solution is used. Adapted SAE.
    """

    name: str
    channels: tuple[str, ...]
    where: dict[str, list[tuple[float, float]]]
    hold: tuple[str, ...]
    free: dict[str, FreeCoefficient]
    sections: tuple[str, ...]
    effects: tuple[str, ...] | None
    rows: int | None
    weights: str
    again: tuple[Mapping[str, float], ...] = ()
    selection: Selection | None = None

    def select(self, table: pd.DataFrame) -> pd.DataFrame:
        """Return the rows of a table (adapted SAE) that meet all conditions, with held inputs at their levels."""
        chosen = np.ones(len(table), dtype=bool)
        for channel, levels in self.where.items():
            values = _values_of(table, channel)
            chosen &= np.any([np.abs(values - value) <= tolerance for value, tolerance in levels], axis=0)
        if self.selection is not None:
            chosen &= self.selection.matches(lambda channel: _values_of(table, channel), "")
        rows = table if chosen.all() else table[chosen]
        for channel in self.hold:
            held = np.array([value for value, _ in self.where[channel]])
            values = _values_of(rows, channel)
            nearest = np.abs(values[:, None] - held).argmin(axis=1)
            rows = rows.assign(**{channel: held[nearest]})
        return rows


@dataclass(frozen=True)
class Recipe:
    """The stages of a fit.

    - `scales`: whether it scales a given tire and requires a start tire.
    """

    name: str
    description: str
    stages: tuple[Stage, ...]
    scales: bool = False


def load_recipe(name: str | None, model_name: str) -> Recipe:
    """Return a recipe by name or from a TOML file.

    Parameters
    ----------
    name : str or None
        One of `RECIPES`, a recipe of the model, or the path of a .toml file; by default the recipe of the model.
    model_name : str
        The model that is fitted.

    Returns
    -------
    Recipe
        The stages, with the bounds of the model.

    Raises
    ------
    UnknownName
        If there is no such recipe.
    FitError
        If the file is invalid or not for this model. The message names file, stage and key.

    Examples
    --------
    >>> len(load_recipe("trento", "mf96").stages)
    13
    """
    model = model_named(model_name)
    name = model.fit.recipe if name is None else name
    if name in model.fit.recipes or name in RECIPES:
        folder = files(model.source.folder) if name in model.fit.recipes else files("tirefmu.fitting") / "recipes"
        where = f"recipe {name}"
        content = toml_content((folder / f"{name}.toml").read_text(encoding="utf-8"), where, FitError)
    elif name.endswith(".toml"):
        where, content = name, toml_file(Path(name), FitError)
        check_content(content, recipe_schema(), where, FitError)
    else:
        raise UnknownName("recipe", name, (*RECIPES, *model.fit.recipes))
    models = content.get("models", list(MODELS))
    if model_name not in models:
        raise FitError(f"{where} is for {', '.join(models)}, not for {model_name}")
    stages = tuple(_stage(item, model, where) for item in content["stage"])
    texts = content.get("name", Path(name).stem), content.get("description", "")
    return Recipe(*texts, stages, content.get("scales", False))


def recipe_schema() -> dict[str, Any]:
    """Return the JSON Schema of a recipe."""
    free = {"type": "object", "additionalProperties": object_schema(dict.fromkeys(("guess", "lower", "upper"), float))}
    stage = object_schema({
        "name": str, "channels": list[str], "where": dict[str, str | list[str]], "select": str, "hold": list[str],
        "free": free, "sections": list[str], "effects": list[str], "rows": Annotated[int, {"minimum": 1}],
        "weights": one_of(WEIGHTS), "again": list[dict[str, float]],
    })  # fmt: skip
    stages = {"type": "array", "minItems": 1, "items": stage}
    keys = {"name": str, "description": str, "models": list[str], "scales": bool, "stage": stages}
    return document("recipe", "1.0", "Recipe of a fit", object_schema(keys, ["stage"]))


def _stage(item: dict[str, Any], model: Model, where: str) -> Stage:
    location = f"{where}, stage {item.get('name', '?')!r}"
    channels, sections, effects = item.get("channels", []), item.get("sections", []), item.get("effects")
    where_of = item.get("where", {})
    models = MODELS.values()
    for kind, names, possible in (
        ("channel", channels, [quantity.name for other in models for quantity in other.outputs]),
        ("section", sections, [section.title for other in models for section in other.sections]),
        ("coefficient", item.get("free", {}), model.coefficients),
        ("input", where_of, [quantity.name for quantity in model.inputs]),
        ("effect", effects or (), {**EFFECTS, **model.effects}),
        ("held input without a condition", item.get("hold", []), where_of),
        # A stage ignores initial values of coefficients that the model does not have.
        ("coefficient", [name for given in item.get("again", []) for name in given],
         {name: None for other in models for name in other.coefficients}),
    ):  # fmt: skip
        for name in names:
            if name not in possible:
                raise UnknownName(f"{kind} in {location}", name, possible)
    return Stage(
        name=item.get("name", "?"),
        channels=tuple(channels),
        where={
            channel: [
                _condition(level, channel, location) for level in (levels if isinstance(levels, list) else [levels])
            ]
            for channel, levels in where_of.items()
        },
        hold=tuple(item.get("hold", [])),
        free={name: _freed(given, f"{location}, {name}") for name, given in item.get("free", {}).items()},
        sections=tuple(sections),
        effects=None if effects is None else tuple(sorted(set(effects) & model.effects.keys())),
        rows=item.get("rows"),
        weights=item.get("weights", "equal"),
        again=tuple(item.get("again", [])),
        selection=_selection(item["select"], location) if "select" in item else None,
    )


def _freed(given: dict[str, float], location: str) -> FreeCoefficient:
    lower, upper, guess = given.get("lower", -inf), given.get("upper", inf), given.get("guess", 0.0)
    if lower > upper:
        raise FitError(f"{location}: bounds cross: lower {lower:g} is above upper {upper:g}")
    return FreeCoefficient(float(guess), float(lower), float(upper))


def _condition(text: str, channel: str, location: str) -> tuple[float, float]:
    """Return value and tolerance of a range such as "220 +- 100 N"."""
    try:
        return parse_range(text, channel)
    except DataError as error:
        raise FitError(f"{location}: {error}") from None


def _selection(expression: str, location: str) -> Selection:
    try:
        selection = parse_selection(expression)
    except DataError as error:
        raise FitError(f"{location}: select: {error}") from None
    for name in sorted(selection.names - CHANNELS.keys()):
        raise FitError(f"{location}: select: {name} is known in --where only, a stage selects by channels")
    return selection


def _values_of(table: pd.DataFrame, channel: str) -> FloatArray:
    """Return an input, or zeros if it was not recorded."""
    return table[channel].to_numpy(dtype=np.float64) if channel in table else np.zeros(len(table))
