"""The C++ header with other scalar types: float, and types of automatic differentiation."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import casadi
import pytest

from .conftest import tool

STRICT = ["-std=c++17", "-O0", "-Wall", "-Wextra", "-Wpedantic", "-Werror"]
AUTODIFF = Path(__file__).parent / "autodiff.cpp"
heavy = pytest.mark.skipif("TIREFMU_HOSTS" not in os.environ, reason="compiles for ten seconds: make hosts")


def compiled(folder, source, *options):
    target = folder / "program"
    command = [tool("c++"), *STRICT, str(source), *options, "-o", str(target)]
    built = subprocess.run(command, cwd=folder, capture_output=True, text=True, check=False)
    assert built.returncode == 0, built.stderr[:3000]
    return [str(target)]


@pytest.fixture(scope="module")
def inline(mf61, printout):
    """Return the folder of an MF6.1 tire with its values in the lines."""
    return printout(mf61, "cpp", "mf61")


def differentiated(folder, *options):
    """Compile autodiff.cpp with a printout and run it."""
    header = next(folder.glob("*.hpp"))
    options = [f'-DHEADER="{header.name}"', f"-DTIRE={header.stem}", f"-I{folder}", *options]
    run = subprocess.run(compiled(folder, AUTODIFF, *options), cwd=folder, capture_output=True, text=True, check=False)
    assert run.returncode == 0, run.stdout


def test_derivatives_of_a_dual_number_and_float(inline):
    """The forward derivative of every force equals the printed Jacobian; float agrees to its precision."""
    differentiated(inline)


@heavy
def test_ceres_jets(inline):
    if not Path("/usr/include/ceres/jet.h").exists():
        pytest.skip("Ceres is not installed")
    differentiated(inline, "-DJET", "-isystem/usr/include/eigen3")


@heavy
@pytest.mark.skipif(sys.platform != "linux", reason="the path of CasADi's library is that of Linux")
def test_casadi_symbols(inline):
    root = Path(casadi.__file__).parent
    differentiated(inline, "-DSYMBOLIC", f"-isystem{root}/include", f"-L{root}", "-lcasadi", f"-Wl,-rpath,{root}")
