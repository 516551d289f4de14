"""``tirefmu init``, ``run`` and ``studio``: a project file, the run of all its steps, a window over it."""

from __future__ import annotations

import os
import sys
import webbrowser
from contextlib import redirect_stdout
from importlib.util import find_spec
from io import StringIO
from pathlib import Path
from typing import Any

import click

from ..boundary.errors import TirefmuError, UnknownName
from ..boundary.escaping import command_text
from ..boundary.json_schema import write_toml
from ..symbolic import DEFAULT_MODEL
from .arguments import (
    FILE,
    MODEL,
    NOMINAL,
    SIGNS,
    all_commands,
    check_input_paths,
    check_output_paths,
    common,
    names,
    write_json,
)
from .command import command

#: The project file where none is given.
DEFAULT = Path("tirefmu.toml")


@command(
    section="All steps, many tires", place=2,
    examples=(
        "init cornering.mat drivebrake.mat --model mf61 --nominal Fz0=1100,R0=0.2",
        "init",
    ),
)  # fmt: skip
@click.argument("tables", type=FILE, nargs=-1)
@MODEL
@NOMINAL
@click.option("--effects", callback=names, help="Exactly these effects in addition to the core, or 'none'.")
@SIGNS
@click.option("-o", "--output", type=FILE, default=DEFAULT, show_default=True, help="Project file to write.")
@common
@click.pass_context
def init(
    context: click.Context, tables: tuple[Path, ...], model: str | None, nominal: dict[str, float] | None,
    effects: tuple[str, ...] | None, signs: str | None, output: Path, quiet: bool, json_file: Path | None,
) -> int:  # fmt: skip
    """Write a project file for the bench files TABLES.

    In a terminal, without TABLES, it requests what it needs. The JSON Schema beside the file is for editors.
    """
    check_output_paths(output, json_file)
    if output.exists():
        raise TirefmuError(f"{output}: exists already")
    if not tables:
        if not sys.stdin.isatty():
            raise TirefmuError("no bench file: name the tables, or run tirefmu init in a terminal")
        tables, model, nominal = _requested(model, nominal)
    for table in tables:
        if not table.is_file():
            raise TirefmuError(f"{table}: no such file")
    from ..applications.project.project_file import project_text
    from ..measurements.catalogue import effects as found_effects
    from ..measurements.nominal_values import NOMINAL
    from ..symbolic.models import model_named
    from .terminal import Terminal

    chosen = model or DEFAULT_MODEL
    model_named(chosen)  # raises for an unknown one
    for name in nominal or {}:
        if name not in NOMINAL:
            raise UnknownName("nominal value", name, NOMINAL)
    possible = [effect["name"] for effect in found_effects(only_model=chosen)] if effects else []
    for name in effects or ():
        if name not in possible:
            raise UnknownName(f"effect of {chosen}", name, possible)
    paths = [_relative(table, output.parent) for table in tables]
    _write_project(context, output, project_text(paths, chosen, nominal or {}, effects, signs))
    write_json(json_file, {"ok": True, "project": str(output), "tables": paths, "model": chosen})
    Terminal(quiet).print(f"project: {output}; edit it and run: {command_text('run', output)}")
    return 0


def _write_project(context: click.Context, path: Path, text: str) -> None:
    """Write a project file and its JSON Schema beside it."""
    from .schemas import schema

    write_toml(path, text, schema("project", all_commands(context)))


def _requested(model: str | None, nominal: dict[str, float] | None) -> tuple[tuple[Path, ...], str, dict[str, float]]:
    """Return tables, model and nominal values as the user enters them."""
    entered = click.prompt("Bench files, separated by blanks")
    tables = tuple(map(Path, entered.split()))
    model = model or click.prompt("Model", default=DEFAULT_MODEL)
    given = dict(nominal or {})
    for name, text in (("Fz0", "Nominal load, N"), ("R0", "Unloaded radius, m")):
        if name not in given:
            given[name] = click.prompt(text, type=float)
    return tables, model, given


def _relative(path: Path, folder: Path) -> str:
    """Return a path as the project file has it: relative to its folder, with slashes."""
    try:
        return Path(os.path.relpath(path, folder)).as_posix()
    except ValueError:  # another drive
        return path.absolute().as_posix()


@command(
    section="All steps, many tires", place=3,
    examples=(
        "run",
        "run tirefmu.toml --force",
    ),
)  # fmt: skip
@click.argument("project", type=FILE, default=DEFAULT)
@click.option("--force", is_flag=True, help="Repeat all steps, also those whose results are up to date.")
@click.option("--only", callback=names, default="none",
              help="Only steps of these commands, such as fit,check, and those whose results they read.")  # fmt: skip
@click.option("--outside", is_flag=True, help="Results may be outside the folder of PROJECT.")
@common
@click.pass_context
def run(
    context: click.Context, project: Path, force: bool, only: tuple[str, ...], outside: bool, quiet: bool,
    json_file: Path | None,
) -> int:  # fmt: skip
    """Run the steps of PROJECT that are out of date.

    The steps of a project file: inspect, fit, explore, export, convert, generate, check, diagnose, and a page over all
    results. Only steps whose command, input files or results have changed are repeated. Exit code 1 if a check of a
    step failed.
    """
    check_output_paths(json_file)
    from ..applications.project.project_file import read_project
    from ..applications.project.run import INDEX, run_limited, run_project
    from ..applications.project.steps import Step, steps_of
    from .terminal import Terminal

    group = all_commands(context)
    terminal = Terminal(quiet)

    def command(step: Step) -> int:
        """Run a step: its progress is shown, its result is in its file."""
        arguments = ["--quiet", *step.arguments] if quiet else [*step.arguments]
        if step.time_limit is not None:
            return run_limited(step.command, arguments, step.time_limit, terminal.begin)
        with redirect_stdout(StringIO()):
            status: Any = group.main(args=[step.command, *arguments], prog_name="tirefmu", standalone_mode=False)
        return int(status or 0)

    read = read_project(project)
    commands = dict.fromkeys(step.command for step in steps_of(read))
    for name in only:
        if name not in commands:
            raise UnknownName("step of a project", name, commands)
    for step in steps_of(read):  # a wrong option of a late step is found before the first one
        try:
            group.commands[step.command].make_context(step.command, list(step.arguments))
        except click.UsageError as error:
            raise TirefmuError(f"{project}: step {step.name}: {' '.join(error.format_message().split())}") from error
    index = read.folder / INDEX
    try:
        outcomes = run_project(read, command, terminal, force=force, outside=outside, only=only)
    except KeyboardInterrupt:
        terminal.print("", f"interrupted; index page: {index}; to continue: {command_text('run', project)}")
        raise
    failed = [outcome.step.name for outcome in outcomes if outcome.status]
    steps = [
        {
            "name": outcome.step.name,
            "ok": outcome.status == 0,
            "repeated": outcome.repeated,
            "summary": list(outcome.summary.lines),
        }
        for outcome in outcomes
    ]
    write_json(json_file, {"ok": not failed, "index": str(index), "steps": steps})
    terminal.print(
        "", f"{'check failed: ' + ', '.join(failed) if failed else 'all checks passed'}; index page: {index}"
    )
    return 1 if failed else 0


@command(
    section="All steps, many tires", place=1,
    examples=(
        "studio",
        "studio cornering.mat drivebrake.mat",
    ),
)  # fmt: skip
@click.argument("given", metavar="[FILES]...", type=FILE, nargs=-1)
@click.option("--project", type=FILE, default=DEFAULT, show_default=True, help="Project file; written if missing.")
@click.option("--no-browser", is_flag=True, help="Print the address only.")
@click.pass_context
def studio(context: click.Context, given: tuple[Path, ...], project: Path, no_browser: bool) -> int:
    """Open a window to work in: data, fit, comparison, diagnosis, export.

    FILES are bench files that are added to the project. The window is a page in the browser, served on this computer
    only. Its state is the project: every click changes PROJECT, and 'tirefmu run' repeats the work without the window.
    Ctrl-C ends it; nothing is lost.
    """
    for name in ("starlette", "tomlkit", "uvicorn", "websockets"):
        if find_spec(name) is None:
            raise TirefmuError(f"the window needs {name}: pip install 'tirefmu[studio]'")
    check_input_paths(*given)
    if not project.absolute().parent.is_dir():
        raise TirefmuError(f"{project}: no folder {project.parent}")
    from ..applications.project.project_file import project_text
    from ..applications.studio.project_state import ProjectState
    from ..applications.studio.serve import serve
    from .terminal import Terminal

    for path in given:
        if not path.is_file():
            raise TirefmuError(f"{path}: no such file")
    if not project.exists():
        _write_project(context, project, project_text([], DEFAULT_MODEL, {}, None, None))
    state = ProjectState(project)
    state.add_named([_relative(path, state.folder) for path in given])
    terminal = Terminal()

    def opened(address: str) -> None:
        terminal.print(f"studio: {address}", "Ctrl-C ends it")
        if not no_browser:
            webbrowser.open(address)

    serve(state, opened)
    return 0
