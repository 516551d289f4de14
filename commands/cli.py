"""The command line: ``tirefmu COMMAND``. Exit codes: 0 success, 1 completed but a check failed, 2 invalid input.

A command imports its packages when it runs and its files exist: SymPy, pandas, CasADi and Matplotlib would delay every
``--help`` and every error message. TIRE is a .tir file or the name of a published tire.
"""

from __future__ import annotations

import io
import os
import shlex
import sys
import warnings
from collections.abc import Iterator
from contextlib import contextmanager
from importlib import import_module
from pkgutil import iter_modules
from typing import Any

import click

from .. import commands
from ..boundary.errors import TirefmuError, TirefmuWarning
from ..boundary.escaping import excerpt, visible
from .command import SectionedGroup


@click.group(cls=SectionedGroup, context_settings={"help_option_names": ["-h", "--help"], "max_content_width": 100})
@click.version_option(package_name="tirefmu")
def cli() -> None:
    """From tire bench data to a fitted Magic Formula tire, exported as an FMU and checked against the data.

    Exit codes: 0 success, 1 completed but a check failed, 2 invalid input.
    """


for module in iter_modules(commands.__path__, f"{commands.__name__}."):
    if module.name.endswith(("_command", "_commands")):
        for value in vars(import_module(module.name)).values():
            if isinstance(value, click.Command):
                cli.add_command(value)


def main(arguments: list[str] | None = None) -> int:
    """Run the command line and return its exit code.

    `arguments`: none for the arguments of the process. Returns: 0: success; 1: completed, but a check failed; 2:
    invalid input.

    >>> main(["info", "missing.tir", "--quiet"])
    2
    """
    return run(cli, "tirefmu", arguments)


def run(command: click.Command, name: str, arguments: list[str] | None) -> int:
    """Run a command and return its exit code; an error is one line.

    In a process of its own, each BLAS has one thread, also that of CasADi: matrices are too small for more threads,
    which would wait for one another.
    """
    if arguments is None:
        os.environ.setdefault("OMP_NUM_THREADS", "1")  # NumPy is imported later
    if isinstance(sys.stdout, io.TextIOWrapper):
        sys.stdout.reconfigure(errors="backslashreplace")  # for encodings that lack a character of a file name
    try:
        given = sys.argv[1:] if arguments is None else arguments
        line = shlex.join([name, *given])
        with _warnings_as_lines(name, quiet="--quiet" in given):
            status = command.main(args=given or ["--help"], prog_name=name, standalone_mode=False, obj=line)
    except TirefmuError as error:
        return _invalid(name, str(error))
    except click.ClickException as error:
        return _invalid(name, _usage(error))
    except OSError as error:  # a name that is too long, a disk that is full
        return _invalid(name, f"{excerpt(error.filename, 200)}: {error.strerror}" if error.filename else str(error))
    except (click.Abort, KeyboardInterrupt):
        print(f"{name}: interrupted", file=sys.stderr)
        return 130
    return int(status or 0)


@contextmanager
def _warnings_as_lines(name: str, quiet: bool) -> Iterator[None]:
    """Print each warning of tirefmu once, as a line; those of other packages are shown as Python does."""
    with warnings.catch_warnings():
        shown_by_python, printed = warnings.showwarning, set()

        def show(message: Warning | str, category: type[Warning], *where: Any, **more: Any) -> None:
            if not issubclass(category, TirefmuWarning):
                shown_by_python(message, category, *where, **more)
            elif str(message) not in printed and not quiet:
                printed.add(str(message))
                print(f"{name}: warning: {message}", file=sys.stderr)

        warnings.simplefilter("always", TirefmuWarning)
        warnings.showwarning = show
        yield


def _usage(error: click.ClickException) -> str:
    """Return the message of an error in the command line; of an unknown name with the command that lists all."""
    message = " ".join(error.format_message().split())
    unknown = {"No such option": "options", "No such command": "commands"}
    listed = next((kind for start, kind in unknown.items() if message.startswith(start)), "")
    context = error.ctx if isinstance(error, click.UsageError) else None
    return f"{message} {context.command_path} --help lists all {listed}." if listed and context else message


def _invalid(name: str, message: str) -> int:
    print(f"{name}: error: {visible(message)}", file=sys.stderr)
    return 2
