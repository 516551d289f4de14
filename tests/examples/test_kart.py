"""A kart on four tires with hub inputs: the co-simulation converges to the monolithic simulation."""

from __future__ import annotations

import importlib
from pathlib import Path

import pytest

from tirefmu.tires.code.compiler import CompilerError, find_compiler

EXAMPLES = Path(__file__).parents[2] / "examples"


def test_the_error_is_of_first_order_in_the_step(monkeypatch):
    try:
        find_compiler()
    except CompilerError as error:
        pytest.skip(str(error))
    monkeypatch.syspath_prepend(EXAMPLES)
    coarse, fine = importlib.import_module("kart").errors((0.004, 0.002))
    assert fine < 0.6 * coarse
    assert fine < 2e-3
