"""Temperatures in printed code: languages agree with NumPy on forces and on the derivatives of the states."""

from __future__ import annotations

import os
from dataclasses import replace

import pytest

from .conftest import command_of
from .self_tests import COMMANDS

FUNCTIONS = ["forces", "states"]


@pytest.fixture(scope="module")
def warm(trento):
    values = {**trento.values, "TMU1": -0.002, "TREF": 50.0, "THACT": 1.0, "THSHAREX": 0.8}
    return replace(trento, values=values, effects={*trento.has, "temperature", "temp_friction"})


@pytest.mark.parametrize("language", COMMANDS)
def test_a_language_has_the_temperatures(language, warm, printout, assert_agrees):
    command_of(language)
    if language in ("jax", "torch") and "TIREFMU_HOSTS" not in os.environ:
        pytest.skip("traces thousands of operations: make hosts")
    folder = printout(warm, language, f"warm_{language}", functions=FUNCTIONS)
    assert_agrees(command_of(language, folder), folder, FUNCTIONS)
