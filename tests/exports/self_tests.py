"""The run of a printout's self-test in every language: by the tests, and by benchmarks/languages.py."""

from __future__ import annotations

import importlib.util
import shutil
import subprocess
import sys
import tempfile
from functools import lru_cache
from pathlib import Path

#: How the self-test of each language is compiled and run; {0} is the file, {1} its name without ending.
#: Octave warns that it ignores arguments blocks.
COMMANDS = {
    "c": ("cc", "-std=c99 -O0 -Wall -Wextra -Wpedantic -Werror {} -lm -o selftest", "./selftest"),
    "cpp": ("c++", "-std=c++17 -O0 -Wall -Wextra -Wpedantic -Werror {} -o selftest", "./selftest"),
    "javascript": ("node", "", "node {}"),
    "matlab": ("octave-cli", "", "octave-cli --norc --no-history --quiet --eval warning('off');{1}"),
    "rust": ("rustc", "{} --extern libm=LIBM -o selftest", "./selftest"),
    "modelica": ("python3", "", f"{sys.executable} {Path(__file__).with_name('run_modelica.py')} {{}}"),
    **dict.fromkeys(("numpy", "casadi", "jax", "torch"), ("python3", "", f"{sys.executable} -W error {{}}")),
}
#: Packages of languages that run in Python.
PACKAGES = {"modelica": "rumoca", "jax": "jax", "torch": "torch"}
#: s, the longest self-test.
TIME_LIMIT = 1500


class NotInstalledError(RuntimeError):
    """The program or the package of a language is missing."""


def tool(name: str) -> str:
    """Return the path of a program."""
    path = shutil.which(name)
    if not path:
        raise NotInstalledError(f"{name} is not installed")
    return path


def command_of(language: str, folder: Path | None = None, source: str = "", level: str = "-O0") -> list[str]:
    """Compile the self-test in a folder, or another source, and return the command that runs it.

    Without a folder it is only seen whether that is possible. `level`: of optimization in C and C++.
    """
    program, options, run = COMMANDS[language]
    path = tool(program)
    if language in PACKAGES and importlib.util.find_spec(PACKAGES[language]) is None:
        raise NotInstalledError(f"{PACKAGES[language]} is not installed")
    if language == "rust":
        options = options.replace("LIBM", str(libm(path)))
    if folder is None:
        return []
    if not source:
        (source,) = (file.name for file in folder.glob("*_selftest.*") if file.suffix != ".txt")
    if options:
        command = [path, *options.replace("-O0", level).format(source).split()]
        built = subprocess.run(command, cwd=folder, capture_output=True, text=True, check=False)
        if built.returncode:
            raise RuntimeError(built.stderr[:3000])
    return run.format(source, Path(source).stem).split()


@lru_cache(maxsize=1)
def libm(rustc: str) -> Path:
    """Return the compiled crate libm, made from Debian's source of it."""
    sources = sorted(Path("/usr/share/cargo/registry").glob("libm-*/src/lib.rs"))
    if not sources:
        raise NotInstalledError("the crate libm (Debian: librust-libm-dev) is not installed")
    target = Path(tempfile.mkdtemp()) / "liblibm.rlib"
    command = [rustc, "--crate-type", "rlib", "--crate-name", "libm", "-O", "--cap-lints", "allow", sources[-1]]
    subprocess.run([*command, "-o", target], check=True)
    return target


def differences(command: list[str], folder: Path) -> tuple[int, dict[str, float]]:
    """Run a self-test: return its exit code and the largest difference of each function."""
    run = subprocess.run(command, cwd=folder, capture_output=True, text=True, timeout=TIME_LIMIT, check=False)
    lines = [line.split() for line in run.stdout.splitlines()]
    if not run.returncode and run.stderr:
        raise RuntimeError(run.stderr)
    return run.returncode, {name: float(number) for name, number in lines}
