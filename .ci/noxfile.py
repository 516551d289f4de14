"""The test suite on every supported Python with each C compiler, and with the oldest dependencies that are allowed.

``make matrix`` runs all sessions, ``nox --list`` shows them, ``nox -s "tests-3.12(clang)"`` runs one. Interpreters and
compilers that the machine lacks are skipped and named.
"""

from __future__ import annotations

import shutil

import nox

nox.needs_version = ">=2024.10"
nox.options.default_venv_backend = "uv"
nox.options.error_on_missing_interpreters = False
nox.options.download_python = "never"

PYTHONS = ["3.11", "3.12", "3.13", "3.14"]
COMPILERS = ["gcc", "clang"]
#: Direct dependencies at the lower ends of their ranges in pyproject.toml.
OLDEST = "--resolution=lowest-direct"


def run_suite(session: nox.Session, compiler: str, *options: str) -> None:
    """Run the tests with one C compiler; arguments after ``--`` replace the options for pytest-xdist."""
    if shutil.which(compiler) is None:
        session.skip(f"{compiler} is not installed")
    session.run("pytest", *options, *(session.posargs or ["-n", "auto", "--dist", "loadfile"]), env={"CC": compiler})


@nox.session(python=PYTHONS)
@nox.parametrize("compiler", COMPILERS, ids=COMPILERS)
def tests(session: nox.Session, compiler: str) -> None:
    """Run the suite with the newest dependencies."""
    session.install("--editable", ".[matlab,parquet,test]")
    run_suite(session, compiler)


@nox.session(python=PYTHONS[0])
@nox.parametrize("compiler", COMPILERS[:1], ids=COMPILERS[:1])
def oldest(session: nox.Session, compiler: str) -> None:
    """Run the suite with the oldest dependencies that pyproject.toml allows."""
    # The extra "matlab" requires a newer NumPy than tirefmu itself: the tests of its files are skipped.
    session.install(OLDEST, "--editable", ".[parquet,test]")
    # An old release of one package may use what a newer release of another one deprecates.
    run_suite(session, compiler, "-W", "default::DeprecationWarning")
