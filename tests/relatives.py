"""Parameters of tests of which most are slow: models that share their equations, other cases of one kind."""

from __future__ import annotations

from collections.abc import Collection, Iterable

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


def slow_but(fast: Collection[object], cases: Iterable[object]) -> list[object]:
    """Return parameters for pytest of which all but the fast ones are marked as slow."""
    return [
        case if case in fast else pytest.param(*case if isinstance(case, tuple) else (case,), marks=pytest.mark.slow)
        for case in cases
    ]
