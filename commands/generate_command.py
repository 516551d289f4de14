"""``tirefmu generate``: the code in generated/ of a checkout, all code in a folder, or a tire for another program."""

from __future__ import annotations

from pathlib import Path

import click

from ..boundary.errors import TirefmuError
from ..symbolic.printers.languages import LANGUAGES
from .arguments import FILE, check_input_paths, check_output_paths, common, names, write_json
from .command import command


@command(
    section="Other programs", place=1,
    examples=(
        "generate my.tir --language cpp -o code",
        "generate mf61 --language matlab --only Fy,Mz -o code",
    ),
)  # fmt: skip
@click.argument("tire", required=False)
@click.option("--language", help=f"Language of the code: {', '.join(LANGUAGES)}.")
@click.option("-o", "--output", type=FILE, help="Folder to write.")
@click.option("--functions", callback=names, default="forces,quantities,jacobian_inputs", show_default=True,
              help="Functions to print; also jacobian_parameters and states (of relaxation and effects).")  # fmt: skip
@click.option("--values", help="Coefficients: inline (numbers in the lines), struct (variables with default values) "
                               "or file  [default: inline for a tire, struct for a model]")  # fmt: skip
@click.option("--only", callback=names, default="none",
              help="Forces and moments to print, such as Fy,Mz  [default: all]")  # fmt: skip
@click.option(
    "--check",
    "only_check",
    is_flag=True,
    help="Without TIRE: change nothing; exit code 1 with a diff if generated/ is outdated.",
)
@common
def generate(
    tire: str | None, language: str | None, output: Path | None, functions: tuple[str, ...], values: str | None,
    only: tuple[str, ...], only_check: bool, quiet: bool, json_file: Path | None,
) -> int:  # fmt: skip
    """Write TIRE as code in a language, with a self-test.

    TIRE is a .tir file, a published tire or a model.

    Without TIRE: write the NumPy and C code of all models into generated/ of a checkout. With -o FOLDER: write it
    there, with the Jacobians and with the models that have the whole library of effects.
    """
    check_output_paths(json_file, folder=output)
    if tire is None:
        if language or only or values:
            given = "--language" if language else "--only" if only else "--values"
            raise TirefmuError(f"{given} needs a TIRE: a .tir file, a published tire or a model")
        if only_check and output:
            raise TirefmuError("--check is for generated/ of a checkout: it takes no -o")
        return _checked(quiet, json_file) if only_check else _written(output, quiet, json_file)
    if only_check:
        raise TirefmuError("--check is for generated/ of a checkout: it takes no TIRE")
    if language is None or output is None:
        raise TirefmuError(f"TIRE needs --language ({', '.join(LANGUAGES)}) and -o FOLDER")
    check_input_paths(Path(tire))
    from ..applications.exports.printout import generate as run
    from .terminal import Terminal

    terminal = Terminal(quiet)
    with terminal.working(f"printing {language}"):
        written = run(tire, language, output, functions=functions, values=values, only=only)
    write_json(json_file, {"ok": True, "language": language, "files": [str(path) for path in written]})
    for path in written:
        terminal.print(str(path))
    return 0


def _checked(quiet: bool, json_file: Path | None) -> int:
    """Compare generated/ with the equations."""
    from ..symbolic.printers.generate import difference
    from .terminal import Terminal

    terminal = Terminal(quiet)
    diff = difference(_committed())
    write_json(json_file, {"ok": not diff, "diff": diff})
    if diff:
        terminal.print(*diff.rstrip().split("\n"), 'generated/ is outdated: run "tirefmu generate"')
    else:
        terminal.print("generated/ is up to date")
    return 1 if diff else 0


def _written(output: Path | None, quiet: bool, json_file: Path | None) -> int:
    """Write the code of all models: what is committed into generated/, everything into another folder."""
    from ..symbolic.printers.generate import write
    from .terminal import Terminal

    terminal = Terminal(quiet)
    folder = output or _committed()
    with terminal.working("generating code"):
        changed = write(folder, everything=output is not None)
    write_json(json_file, {"ok": True, "changed": [path.relative_to(folder).as_posix() for path in changed]})
    shown = output or Path("generated")
    for path in changed:
        terminal.print((shown / path.relative_to(folder)).as_posix())
    if not changed:
        terminal.print(f"{shown} was up to date" if output else "generated/ was up to date")
    return 0


def _committed() -> Path:
    """Return the folder of the committed code."""
    from .. import generated

    return Path(generated.__file__).parent
