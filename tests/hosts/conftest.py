"""Tires that are printed in every language, and the run of a printout's self-test."""

from __future__ import annotations

import shutil
import subprocess
import sys
import tempfile
from dataclasses import replace
from functools import lru_cache
from pathlib import Path

import pytest

from tirefmu.hosts.printout import generate
from tirefmu.symbolic.added import AddedEffect
from tirefmu.symbolic.added.effect import Act
from tirefmu.symbolic.declarations import Coefficient
from tirefmu.symbolic.printers.languages.program import FUNCTIONS, TOLERANCE
from tirefmu.tires import published, read_tir

#: Ends comments and strings of several languages.
HOSTILE = '*/ -- }% """ \' #= =# \\end{document} ??/ \u2028 $(touch ran) <script> {{7}} @name@ \\'


def wet_grip(text=HOSTILE):
    """Return a user-defined effect whose texts are a given one; its formula has a power with a quotient."""
    coefficient = Coefficient(text, "1", -1.0, 1.0)
    coefficient.name = "GRIPT"
    formula = "1 + GRIPT*sin(gamma)*(1 + gamma**2)**(1/(2 + GRIPT))"
    return AddedEffect("wet_grip", text, text, (coefficient,), (Act("friction_y", "factor", formula),))


@pytest.fixture(scope="session")
def mf61(golden):
    """Return an MF6.1 tire with all effects."""
    return read_tir(golden / "MagicFormula61_Parameters.tir")


@pytest.fixture(scope="session")
def trento():
    return published("trento_hoosier")


@pytest.fixture(scope="session")
def wet():
    """Return an MF96 tire with a user-defined effect, whose texts are all hostile, and effects with states."""
    trento = published("trento_hoosier")
    effects = {*trento.has, "wet_grip", "heat_friction", "slip_history"}
    values = {**trento.values, "GRIPT": 0.01, "HMU": 0.016, "SHMUX": 0.05, "SHMUY": 0.05, "SHKX": 0.1, "SHKY": 0.1}
    return replace(trento, values=values, effects=effects, name=HOSTILE, added=(wet_grip(),))


def tool(name):
    """Return the path of a program, or skip the test."""
    found = shutil.which(name)
    if not found:
        pytest.skip(f"{name} is not installed")
    return found


#: How the self-test of each language is compiled and run; {0} is the file, {1} its name without ending.
#: Octave warns that it ignores arguments blocks.
COMMANDS = {
    "c": ("cc", "-std=c99 -O0 -Wall -Wextra -Wpedantic -Werror {} -lm -o selftest", "./selftest"),
    "cpp": ("c++", "-std=c++17 -O0 -Wall -Wextra -Wpedantic -Werror {} -o selftest", "./selftest"),
    "javascript": ("node", "", "node {}"),
    "matlab": ("octave-cli", "", "octave-cli --norc --no-history --quiet --eval warning('off');{1}"),
    "rust": ("rustc", "{} --extern libm=LIBM -o selftest", "./selftest"),
    **dict.fromkeys(("numpy", "casadi", "jax", "torch"), ("python3", "", f"{sys.executable} -W error {{}}")),
}


def command_of(language, folder=None):
    """Return the command of a language's self-test, compiled; skip the test if its program is missing."""
    program, options, run = COMMANDS[language]
    path = tool(program)
    if language in ("jax", "torch"):
        pytest.importorskip(language)
    if language == "rust":
        options = options.replace("LIBM", str(libm(path)))
    if folder is None:
        return []
    (source,) = (file.name for file in folder.glob("*_selftest.*") if file.suffix != ".txt")
    if options:
        command = [path, *options.format(source).split()]
        built = subprocess.run(command, cwd=folder, capture_output=True, text=True, check=False)
        assert built.returncode == 0, built.stderr[:3000]
    return run.format(source, Path(source).stem).split()


@lru_cache(maxsize=1)
def libm(rustc):
    """Return the compiled crate libm, made from Debian's source of it; skip the test if that is not installed."""
    sources = sorted(Path("/usr/share/cargo/registry").glob("libm-*/src/lib.rs"))
    if not sources:
        pytest.skip("the crate libm (Debian: librust-libm-dev) is not installed")
    target = Path(tempfile.mkdtemp()) / "liblibm.rlib"
    command = [rustc, "--crate-type", "rlib", "--crate-name", "libm", "-O", "--cap-lints", "allow", sources[-1]]
    subprocess.run([*command, "-o", target], check=True)
    return target


def differences(command, folder):
    """Run a self-test: return its exit code and the largest difference of each function."""
    run = subprocess.run(command, cwd=folder, capture_output=True, text=True, timeout=300, check=False)
    lines = [line.split() for line in run.stdout.splitlines()]
    assert run.returncode or not run.stderr, run.stderr
    return run.returncode, {name: float(number) for name, number in lines}


def with_faults(stored):
    """Return the text of a self-test's file twice: its last result wrong, a result of its first row not a number.

    Later rows are correct, and a comparison with NaN is false: NaN must not be lost.
    """
    head, sizes, first, *rows = stored.splitlines()
    *values, last = rows[-1].split()
    wrong = [*values, repr(float(last) + 1e-3 * max(1.0, abs(float(last))))]
    undefined = [*first.split()[:-1], "nan"]
    return (
        "\n".join([head, sizes, first, *rows[:-1], " ".join(wrong), ""]),
        "\n".join([head, sizes, " ".join(undefined), *rows, ""]),
    )


@pytest.fixture(scope="session")
def assert_agrees():
    """Return a function that runs a printout's self-test, correct and with faults in its stored results."""

    def check(command, folder, functions=FUNCTIONS):
        code, found = differences(command, folder)
        assert code == 0, found
        assert set(found) == set(functions)
        for name, difference in found.items():
            assert 0 <= difference <= TOLERANCE[name], (name, difference)
        assert not (folder / "ran").exists()
        (stored,) = folder.glob("*_selftest.txt")
        correct = stored.read_text()
        try:
            for wrong in with_faults(correct):
                stored.write_text(wrong)
                assert differences(command, folder)[0] == 1
        finally:
            stored.write_text(correct)

    return check


@pytest.fixture(scope="session")
def printout(tmp_path_factory):
    """Return a function that prints a tire and returns the folder."""

    def make(tire, language, name, rows=40, **selection):
        folder = tmp_path_factory.mktemp(f"{language}_{name}")
        generate(tire, language, folder, rows=rows, **selection)
        return folder

    return make
