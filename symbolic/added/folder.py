"""The folder of the effect files of the package; every TOML file in it is an effect."""

from __future__ import annotations

from importlib.resources import files
from importlib.resources.abc import Traversable

from ..declarations import Effect
from .effect import AddedEffect
from .file import read_declared

FOLDER: Traversable = files(__package__.rpartition(".")[0]) / "effects"


def declared_effects() -> dict[str, Effect | AddedEffect]:
    """Return the effects of all files of the folder by name, in alphabetical order.

    Returns
    -------
    dict of str to Effect or AddedEffect
        An `Effect` belongs to the equations of chapters, an `AddedEffect` is added to the equations of a model.

    Raises
    ------
    EffectError
        If a file cannot be read, or the names of file and effect differ.

    Examples
    --------
    >>> declared_effects()["turn_slip"].physics
    'turn slip reduces the forces and generates a moment'
    """
    texts = {file.name: file.read_text(encoding="utf-8") for file in FOLDER.iterdir() if file.name.endswith(".toml")}
    return {name.removesuffix(".toml"): read_declared(texts[name], name) for name in sorted(texts)}
