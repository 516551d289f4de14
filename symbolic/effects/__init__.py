"""The effects that a tire model has or lacks: a TOML file for each, in this folder.

A file with [[acts]] is an effect that acts on named quantities of any model: the library
(`tirefmu.symbolic.added.library`). A file without them is an effect in the lines of chapters (``effect.term``,
``effect.factor``, ``effect.either``), which import it by name: ``from ..effects import turn_slip``. What the keys mean
is in docs/effects.md.
"""

from __future__ import annotations

from ..added.folder import declared_effects
from ..notation import Effect

#: Every effect of the chapters by its public name.
EFFECTS: dict[str, Effect] = {name: effect for name, effect in declared_effects().items() if isinstance(effect, Effect)}


def __getattr__(name: str) -> Effect:
    if name in EFFECTS:
        return EFFECTS[name]
    raise AttributeError(f"module {__name__} has no effect {name}")
