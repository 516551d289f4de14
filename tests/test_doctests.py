"""The examples in the docstrings run, each module imported as tirefmu.<package>.<module>.

(pytest --doctest-modules would import the root folders as top-level packages and define every class twice.)
"""

from __future__ import annotations

import doctest
import importlib

import pytest

from .rooms import ROOMS, ROOT


def modules_with_examples() -> list[str]:
    """Return the import names of all modules that contain an example."""
    names = []
    for room in ROOMS:
        for path in sorted((ROOT / room).rglob("*.py")):
            if ">>> " in path.read_text(encoding="utf-8"):
                below = path.relative_to(ROOT).with_suffix("").parts
                names.append(".".join(["tirefmu", *(part for part in below if part != "__init__")]))
    return names


@pytest.mark.parametrize("name", modules_with_examples())
def test_examples(name, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)  # examples may write files
    result = doctest.testmod(importlib.import_module(name), optionflags=doctest.ELLIPSIS)
    assert result.attempted > 0
    assert result.failed == 0
