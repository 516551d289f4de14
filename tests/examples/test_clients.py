"""The examples with other tools run and agree, each in a separate process."""

from __future__ import annotations

import importlib.util
import subprocess
import sys

import pytest

from .conftest import EXAMPLES

CLIENTS = [
    ("run_fmpy.py", "fmpy", 2),
    ("run_fmpy.py", "fmpy", 3),
    ("run_libcosimpy.py", "libcosimpy", 2),
    ("run_ecospy.py", "ecospy", 2),
    ("run_ecospy.py", "ecospy", 3),
    ("kart_system.py", "libcosimpy", "libcosimpy"),
    ("kart_system.py", "ecospy", "ecospy"),
    ("check_fmutool.py", "fmu_manipulation_toolbox", 2),
    ("check_fmutool.py", "fmu_manipulation_toolbox", 3),
]


@pytest.mark.parametrize(("script", "package", "argument"), CLIENTS)
def test_client(script, package, argument, compiler):
    if importlib.util.find_spec(package) is None:
        pytest.skip("needs the extra cosimulation")
    command = [sys.executable, EXAMPLES / script, str(argument)]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stdout + done.stderr
    output = done.stdout + done.stderr
    assert ("No semantic error" if package.startswith("fmu_") else "largest difference") in output


def test_a_wrong_result_is_reported(example):
    four = example("four_tires")
    right = four.expected(four.relaxing_tire())
    assert four.report("right", right) == 0
    right[70, 2, 1] += 1e-6 * (1.0 + abs(right[70, 2, 1]))
    assert four.report("wrong", right) == 1
    right[70, 2, 1] = float("nan")
    assert four.report("not a number", right) == 1
