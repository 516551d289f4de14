"""Effects that are added to the equations of a model. A file declares which named quantity changes, and how.

The library is in the folder `tirefmu.symbolic.effects`. User-defined effects and formulas proposed by the diagnosis
have the same form (`tirefmu.symbolic.added.file`).
"""

from __future__ import annotations

import hashlib
from collections.abc import Iterable
from functools import lru_cache

from .effect import AddedEffect
from .file import effect_from, effect_schema, effect_text, read_effect
from .folder import declared_effects, installed_effects

__all__ = ["AddedEffect", "effect_from", "effect_schema", "effect_text", "library", "packaged_library", "read_effect",
           "texts_digest"]  # fmt: skip


@lru_cache(maxsize=1)
def library() -> dict[str, AddedEffect]:
    """Return the effects of the library by name, and those of other installed packages.

    Every tire can have them without declaring them.

    Examples
    --------
    >>> library()["temp_friction"].acts_on
    ('friction_x', 'friction_y')
    """
    return packaged_library() | installed_effects()


@lru_cache(maxsize=1)
def packaged_library() -> dict[str, AddedEffect]:
    """Return the effects of the library that are part of this package; every installation has them.

    >>> "temp_friction" in packaged_library()
    True
    """
    return {name: effect for name, effect in declared_effects().items() if isinstance(effect, AddedEffect)}


def texts_digest(effects: Iterable[AddedEffect]) -> str:
    """Return the SHA-256 digest of the texts of effects, which identifies what they add to a model."""
    return hashlib.sha256("\0".join(effect_text(effect) for effect in effects).encode()).hexdigest()
