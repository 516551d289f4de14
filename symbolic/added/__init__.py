"""Effects beyond the book: small files that say which named quantity they multiply or add to.

The library lies beside this module, a TOML file for each effect; a user's own effect and a formula found by the
diagnosis have the same form (`tirefmu.symbolic.added.file`).
"""

from __future__ import annotations

from functools import lru_cache
from importlib.resources import files

from .file import AddedEffect, effect_text, read_effect

__all__ = ["LIBRARY", "AddedEffect", "effect_text", "library", "read_effect"]

#: The effects that every tire may have by name.
LIBRARY = ("temp_friction", "temp_stiffness", "speed_friction", "wear_drift")


@lru_cache(maxsize=1)
def library() -> dict[str, AddedEffect]:
    """Return the effects of the library by name.

    Examples
    --------
    >>> library()["temp_friction"].acts_on
    ('friction_x', 'friction_y')
    """
    folder = files(__package__)
    return {
        name: read_effect((folder / f"{name}.toml").read_text(encoding="utf-8"), f"{name}.toml") for name in LIBRARY
    }
