"""Every language against NumPy: the self-test of its printout, with values in the lines and with coefficients."""

from __future__ import annotations

import os
import subprocess

import pytest

from tirefmu.symbolic.printers.languages import LANGUAGES
from tirefmu.symbolic.printers.languages.program import FUNCTIONS

from .conftest import command_of
from .self_tests import COMMANDS

#: The compiler of Modelica repeats all lines for every result: test_modelica.py.
RUN_HERE = sorted(set(COMMANDS) - {"modelica"})


def test_every_language_has_a_command_or_a_test_of_its_own():
    assert set(COMMANDS) | {"latex"} == set(LANGUAGES)


@pytest.fixture(params=RUN_HERE)
def language(request):
    """Name each language that can be run here."""
    command_of(request.param)
    if request.param in ("jax", "torch") and "TIREFMU_HOSTS" not in os.environ:
        pytest.skip("traces thousands of operations: make hosts")
    return request.param


def test_values_in_the_lines(language, mf61, printout, assert_agrees):
    """MF6.1 has every function and condition that a line can have."""
    folder = printout(mf61, language, "mf61", functions=FUNCTIONS[:3:2])
    assert_agrees(command_of(language, folder), folder, FUNCTIONS[:3:2])


def test_coefficients_from_a_file(language, wet, printout, assert_agrees):
    """Jacobians by the coefficients, states, and a user-defined effect with hostile texts."""
    folder = printout(wet, language, "wet", functions=FUNCTIONS, values="file", rows=15)
    command = command_of(language, folder)
    assert_agrees(command, folder)
    (values,) = folder.glob("*_coefficients.txt")
    values.write_text("\n".join([*values.read_text().splitlines()[1:], ""]))
    broken = subprocess.run(command, cwd=folder, check=False, capture_output=True)
    assert broken.returncode == 1, "a coefficient is missing"
