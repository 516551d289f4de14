"""Every model by name, with added effects in its lines if a tire has them."""

from __future__ import annotations

import json
from collections.abc import Callable, Collection, Mapping, Sequence
from functools import lru_cache
from importlib.resources import files
from importlib.resources.abc import Traversable

from ..boundary.errors import UnknownName
from .added import AddedEffect, effect_text, library, texts_digest
from .model import Model
from .model.discovery import found_models

#: Every model by name: those of this package's folders and of other packages; see ARCHITECTURE.md, "Where to add".
MODELS: dict[str, Model] = found_models()

#: Finds the stored structure of a model with effects.
FindStructure = Callable[[str, Sequence[AddedEffect]], Traversable | None]
#: The folder of the generated code; read as data, because the packages of the code import this one.
GENERATED: Traversable = files("tirefmu.generated")
#: The folder in it of the models with the whole library of effects: in a wheel, not in a clone.
WITH_EFFECTS = "with_effects"

for _model in MODELS.values():
    _stored = GENERATED / "structure" / f"{_model.name}.json"
    if _stored.is_file():
        _model.use(_stored)

_EXTENDED: dict[tuple[Model, tuple[str, ...]], Model] = {}


def model_named(name: str, added: Sequence[AddedEffect] = (), find: FindStructure = lambda name, added: None) -> Model:
    """Return a model by its name on the command line.

    `added`: effects beyond the book to be put into its lines. `find`: of name and effects: the file with the structure
    of a model that has been printed before, or None. Returns: the same object for the same model and effects. Raises
    `UnknownName` if there is none; the message offers the nearest. Raises `EffectError` if an added effect does not fit
    the model.

    >>> model_named("mf96").title
    'Magic Formula 1996, Trento form'
    """
    if name not in tuple(MODELS):  # a value that has no hash is unknown, too
        raise UnknownName("model", name, MODELS)
    if not added:
        return MODELS[name]
    key = (MODELS[name], tuple(effect_text(effect) for effect in added))
    if key not in _EXTENDED:
        _EXTENDED[key] = MODELS[name].extended(added, _stored_with_library(name, added) or find(name, added))
    return _EXTENDED[key]


def whole_library(model: Model, effects: Mapping[str, AddedEffect] | None = None) -> tuple[AddedEffect, ...]:
    """Return the effects of the library that a diagnosis can find in a model, including those with states.

    An installed wheel has the model with them (`generated/with_effects`).

    `effects`: the library by name; None for `library`, which has the effects of other packages, too.

    >>> [effect.name for effect in whole_library(model_named("mf96")) if not effect.states]
    ['temp_friction', 'temp_stiffness', 'wear_drift']
    """
    declared = library() if effects is None else effects
    return tuple(effect for effect in declared.values() if effect.detection and model.has_place_for(effect))


def _stored_with_library(name: str, added: Sequence[AddedEffect]) -> Traversable | None:
    """Return the stored structure of a model if it was printed with exactly these effects."""
    if MODELS[name].stored is None or _printed_library().get(name) != texts_digest(added):
        return None
    return GENERATED / WITH_EFFECTS / "structure" / f"{name}.json"


@lru_cache(maxsize=1)
def _printed_library() -> dict[str, str]:
    """Return the digest of the added effects with which each model was printed."""
    printed: dict[str, str] = json.loads((GENERATED / "MANIFEST.json").read_text(encoding="ascii"))[WITH_EFFECTS]
    return printed


def with_library(name: str, effects: Collection[str], added: Sequence[AddedEffect] = ()) -> tuple[AddedEffect, ...]:
    """Return the added effects of a tire: the given ones, and the library if one of its effects is named.

    Effects of the library without states come together, so that few models have to be printed; a model that lacks what
    some of them act on or read gets what is named. An effect with states comes if it is named: a state costs time.

    `name`: the model. `effects`: names of effects, those of the book among them.

    >>> [effect.name for effect in with_library("mf96", ["camber_thrust", "temp_friction"])]
    ['temp_friction']
    """
    model = model_named(name)
    there = {effect.name for effect in added} | model.effects.keys()
    others = set(effects) - there
    named = [effect for effect in library() if effect in others] if others else []
    if not named:
        return tuple(added)
    plain = [effect for effect in library().values() if not effect.states]
    whole = [effect.name for effect in plain] if all(map(model.has_place_for, plain)) else []
    wanted = [*whole, *(effect for effect in named if effect not in whole)]
    return (*added, *(library()[effect] for effect in wanted if effect not in there))
