"""Every language against NumPy: the self-test of its printout, with values in the lines and with coefficients."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import casadi
import pytest

from tirefmu.applications.exports import printed
from tirefmu.symbolic.models import MODELS
from tirefmu.symbolic.printers.languages import LANGUAGES
from tirefmu.symbolic.printers.languages.program import FUNCTIONS

from ..relatives import slow_but
from .conftest import command_of, tool
from .self_tests import COMMANDS

#: The compiler of Modelica repeats all lines for every result: test_modelica.py.
RUN_HERE = sorted(set(COMMANDS) - {"modelica"})


def test_every_language_has_a_command_or_a_test_of_its_own():
    assert set(COMMANDS) | {"latex"} == set(LANGUAGES)


def fast(languages):
    """Parametrize a test by all languages, of which all but these are slow."""
    return pytest.mark.parametrize("language", slow_but(languages, RUN_HERE), indirect=True)


@pytest.fixture
def language(request):
    """Name each language that can be run here."""
    command_of(request.param)
    if request.param in ("jax", "torch") and "TIREFMU_HOSTS" not in os.environ:
        pytest.skip("traces thousands of operations: make hosts")
    return request.param


@fast(RUN_HERE[::2])
def test_values_in_the_lines(language, mf61, printout, assert_agrees):
    """MF6.1 has every function and condition that a line can have."""
    folder = printout(mf61, language, "mf61", functions=FUNCTIONS[:3:2])
    assert_agrees(command_of(language, folder), folder, FUNCTIONS[:3:2])


@fast(RUN_HERE[1::2])
def test_coefficients_from_a_file(language, wet, printout, assert_agrees):
    """Jacobians by the coefficients, states, and a user-defined effect with hostile texts."""
    folder = printout(wet, language, "wet", functions=FUNCTIONS, values="file", rows=15)
    command = command_of(language, folder)
    assert_agrees(command, folder)
    (values,) = folder.glob("*_coefficients.txt")
    values.write_text("\n".join([*values.read_text().splitlines()[1:], ""]))
    broken = subprocess.run(command, cwd=folder, check=False, capture_output=True)
    assert broken.returncode == 1, "a coefficient is missing"


# ------------------------------- The C++ header with other scalar types: float, and types of automatic differentiation


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


# -------------------------------------------------- The book of equations: what it contains, and that LaTeX accepts it


def test_every_line_has_its_number_and_every_coefficient_its_row():
    text = printed("mf96", "latex", rows=1)["mf96.tex"]
    lines = MODELS["mf96"].lines()
    assert text.count("\\tag{") == len(lines)
    assert text.count("\\begin{equation}") == len(lines)
    for name in MODELS["mf96"].coefficients:
        assert f"$\\mathrm{{{name}}}$".replace("_", "\\_") in text
    for effect in MODELS["mf96"].effects:
        assert effect.replace("_", "\\_") in text


def test_latex_compiles_the_book_with_hostile_texts(wet, tmp_path):
    latex = tool("pdflatex")
    (tmp_path / "book.tex").write_text(printed(wet, "latex", rows=1, values="struct")["mf96.tex"])
    command = [latex, "-interaction=nonstopmode", "-halt-on-error", "-no-shell-escape", "book.tex"]
    run = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, errors="replace", check=False)
    assert run.returncode == 0, run.stdout[-2000:]
    assert (tmp_path / "book.pdf").stat().st_size > 50_000
