"""The book: the Magic Formula as named, numbered lines, and the passes over them."""

from collections.abc import Collection, Sequence

from .added import AddedEffect, effect_text, library
from .effects import EFFECTS
from .errors import UnknownName
from .mf6 import MF52, MF61, MF62
from .mf96 import MF96
from .model import Model

MODELS: dict[str, Model] = {book.name: book for book in (MF96, MF52, MF61, MF62)}
#: The model of a fit and of a diagnosis where neither a model nor a tire is given.
DEFAULT_MODEL = "mf61"


_EXTENDED: dict[tuple[str, ...], Model] = {}


def model(name: str, added: Sequence[AddedEffect] = ()) -> Model:
    """Return a model of the book by its name on the command line.

    Parameters
    ----------
    name : str
    added : sequence of AddedEffect
        Effects beyond the book that stand in its lines too.

    Returns
    -------
    Model
        One object for one name and the same effects.

    Raises
    ------
    UnknownName
        If there is none; the message offers the nearest.
    EffectError
        If an added effect has no place in the model.

    Examples
    --------
    >>> model("mf96").title
    'Magic Formula 1996, Trento form'
    """
    if name not in tuple(MODELS):  # a value that has no hash is unknown, too
        raise UnknownName("model", name, MODELS)
    if not added:
        return MODELS[name]
    key = (name, *(effect_text(effect) for effect in added))
    if key not in _EXTENDED:
        _EXTENDED[key] = MODELS[name].extended(added)
    return _EXTENDED[key]


def with_library(name: str, effects: Collection[str], added: Sequence[AddedEffect] = ()) -> tuple[AddedEffect, ...]:
    """Return the added effects of a tire: those given, and the library where one of its effects is named.

    The library comes whole, so that few models have to be printed; MF96, which lacks what some of it reads, gets
    what is named.

    Parameters
    ----------
    name : str
        The model.
    effects : collection of str
        Names of effects, those of the book among them.
    added : sequence of AddedEffect

    Returns
    -------
    tuple of AddedEffect

    Examples
    --------
    >>> [effect.name for effect in with_library("mf96", ["camber_thrust", "temp_friction"])]
    ['temp_friction']
    """
    there = {effect.name for effect in added} | model(name).effects.keys()
    named = [effect for effect in library() if effect in effects and effect not in there]
    wanted = library() if model(name).results else named
    return (*added, *(library()[effect] for effect in wanted if named and effect not in there))


__all__ = ["DEFAULT_MODEL", "EFFECTS", "MF52", "MF61", "MF62", "MF96", "MODELS", "Model", "model", "with_library"]
