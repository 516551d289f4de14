"""The folders of effect files, of this package and of others; every TOML file in them is an effect."""

from __future__ import annotations

from importlib.resources import files
from importlib.resources.abc import Traversable

from ...boundary.errors import EffectError
from ...boundary.plugins import described, loaded, plugins
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
    return _effects_in(FOLDER, checked=False)


def installed_effects() -> dict[str, AddedEffect]:
    """Return the effects of other installed packages by name.

    Entry points of the group ``tirefmu.effects`` name packages; their TOML files are the effects.

    Raises `EffectError` if a file is not that of an effect with [[acts]], or two effects have one name.
    """
    installed: dict[str, AddedEffect] = {}
    for entry in plugins("effects"):
        loaded(entry)
        try:
            effects = _effects_in(files(entry.module), checked=True)
        except EffectError as error:
            raise EffectError(f"{described(entry)}: {error}") from error
        for name, effect in effects.items():
            if not isinstance(effect, AddedEffect):
                raise EffectError(f"{described(entry)}: effect {name} has no [[acts]]")
            if name in installed or (FOLDER / f"{name}.toml").is_file():
                raise EffectError(f"{described(entry)}: there is another effect {name}")
            installed[name] = effect
    return installed


def _effects_in(folder: Traversable, *, checked: bool) -> dict[str, Effect | AddedEffect]:
    texts = {file.name: file.read_text(encoding="utf-8") for file in folder.iterdir() if file.name.endswith(".toml")}
    return {name.removesuffix(".toml"): read_declared(texts[name], name, checked=checked) for name in sorted(texts)}
