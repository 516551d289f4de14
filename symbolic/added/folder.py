"""The folder of effect files that come with the package; every TOML file found in it is an effect."""

from __future__ import annotations

from importlib.resources import files
from importlib.resources.abc import Traversable

from ..notation import Effect
from .file import AddedEffect, read_declared

FOLDER: Traversable = files(__package__.rpartition(".")[0]) / "effects"


def declared_effects() -> dict[str, Effect | AddedEffect]:
    """Return the effects of all files of the folder by name, in alphabetical order.

    Returns
    -------
    dict of str to Effect or AddedEffect
        An `Effect` is in the lines of chapters, an `AddedEffect` is put into the lines of a model.

    Raises
    ------
    EffectError
        If a file cannot be read, or declares an effect of another name than its own.

    Examples
    --------
    >>> declared_effects()["turn_slip"].physics
    'a turning contact patch takes from the forces and makes a moment'
    """
    texts = {file.name: file.read_text(encoding="utf-8") for file in FOLDER.iterdir() if file.name.endswith(".toml")}
    return {name.removesuffix(".toml"): read_declared(texts[name], name) for name in sorted(texts)}
