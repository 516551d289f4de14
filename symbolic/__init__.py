"""The book: the Magic Formula as named, numbered lines, and the passes over them."""

from .effects import EFFECTS
from .errors import UnknownName
from .mf96 import MF96
from .model import Model

MODELS: dict[str, Model] = {book.name: book for book in (MF96,)}


def model(name: str) -> Model:
    """Return a model of the book by its name on the command line.

    Raises
    ------
    UnknownName
        If there is none; the message offers the nearest.

    Examples
    --------
    >>> model("mf96").title
    'Magic Formula 1996, Trento form'
    """
    if name not in MODELS:
        raise UnknownName("model", name, MODELS)
    return MODELS[name]


__all__ = ["EFFECTS", "MF96", "MODELS", "Model", "model"]
