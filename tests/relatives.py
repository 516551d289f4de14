"""Models that share their equations with another one: what is tested of each model is slow to test of all relatives."""

from __future__ import annotations

from collections.abc import Iterable

import pytest

from tirefmu.symbolic.models import MODELS

#: The one of its folder that is always tested.
TESTED = "mf61"


def is_slow(model: str) -> bool:
    """Return whether a model is a relative of the tested one."""
    return model != TESTED and MODELS[model].source.folder == MODELS[TESTED].source.folder


def slow_relatives(models: Iterable[str]) -> list[object]:
    """Return parameters for pytest of which the relatives of the tested model are marked as slow."""
    return [pytest.param(name, marks=pytest.mark.slow) if is_slow(name) else name for name in models]
