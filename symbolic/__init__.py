"""The book: the Magic Formula as named, numbered lines, and the passes over them."""

from collections.abc import Sequence

from .added import AddedEffect, effect_text
from .effects import EFFECTS
from .errors import UnknownName
from .mf6 import MF52, MF61, MF62
from .mf96 import MF96
from .model import Model

MODELS: dict[str, Model] = {book.name: book for book in (MF96, MF52, MF61, MF62)}


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
    if name not in MODELS:
        raise UnknownName("model", name, MODELS)
    if not added:
        return MODELS[name]
    key = (name, *(effect_text(effect) for effect in added))
    if key not in _EXTENDED:
        _EXTENDED[key] = MODELS[name].extended(added)
    return _EXTENDED[key]


__all__ = ["EFFECTS", "MF52", "MF61", "MF62", "MF96", "MODELS", "Model", "model"]
