"""The examples as modules."""

from __future__ import annotations

import importlib
from pathlib import Path

import pytest

from tirefmu.tires.code.compiler import CompilerError, find_compiler

EXAMPLES = Path(__file__).parents[2] / "examples"


@pytest.fixture(scope="session")
def example():
    """Return a function that imports an example by name."""
    with pytest.MonkeyPatch.context() as patch:
        patch.syspath_prepend(EXAMPLES)
        yield importlib.import_module


@pytest.fixture(scope="session")
def compiler():
    """Skip a test without a C compiler."""
    try:
        find_compiler()
    except CompilerError as error:
        pytest.skip(str(error))
