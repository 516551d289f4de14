"""The effects of tire models: one TOML file per effect in this folder.

A file with [[acts]] declares an effect on named quantities of any model. `library` in `tirefmu.symbolic.added` returns
these effects. A file without [[acts]] declares an effect that is part of the equations of chapters (``effect.term``,
``effect.factor``, ``effect.either``). The chapters import it by name: ``from ..effects import
turn_slip``. docs/effects.md explains the keys.
"""

from __future__ import annotations

from ..added.folder import declared_effects
from ..declarations import Effect

#: Effects of the chapters by public name.
EFFECTS: dict[str, Effect] = {name: effect for name, effect in declared_effects().items() if isinstance(effect, Effect)}


def __getattr__(name: str) -> Effect:
    if name in EFFECTS:
        return EFFECTS[name]
    raise AttributeError(f"module {__name__} has no effect {name}")
