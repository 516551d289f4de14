"""Common parts of the commands: types of arguments, checks of output paths, JSON output."""

from __future__ import annotations

import json
import os
from collections.abc import Callable
from dataclasses import dataclass, fields
from difflib import get_close_matches
from functools import wraps
from importlib.resources import files
from math import isfinite
from pathlib import Path
from typing import Any

import click

from ..boundary.errors import TirefmuError, writing
from ..measurements.files.formats import DEFAULT_SIGNS
from ..symbolic import DEFAULT_MODEL

#: The models of the package; the equations take too long to load for a help text.
_MODELS = json.loads((files("tirefmu.generated") / "MANIFEST.json").read_text(encoding="ascii"))["lines"]
#: Option of the commands that do not need a tire.
MODEL = click.option(
    "--model", help=f"Model: {', '.join(_MODELS)}.  [default: that of the given tire, else {DEFAULT_MODEL}]"
)
CONVENTIONS = click.Choice(["iso", "sae", "adapted-sae"])
#: Option of the commands that draw tables in another convention than that of `tables_read`.
DRAW_SIGNS = click.option(
    "--draw-signs", type=CONVENTIONS, help="Sign convention of the figures (default: that of --signs, else iso)."
)
SIGNS = click.option("--signs", type=CONVENTIONS, help=f"Convention of the tables (default: {DEFAULT_SIGNS}).")
FILE = click.Path(path_type=Path)
WHERE = click.option(
    "--where",
    metavar="EXPRESSION",
    help='Rows to use, such as "t > 120 and p in 70..90 kPa", or a file with an expression (.where, .txt).',
)


def command_line() -> str:
    """Return the command line of the running command, which `main` passes on."""
    return str(click.get_current_context().obj or "")


def all_commands(context: click.Context) -> click.Group:
    """Return the group of all commands."""
    group = context.find_root().command
    assert isinstance(group, click.Group)
    return group


def numbers_by_name(text: str) -> dict[str, float]:
    """Read ``name=number,name=number``."""
    pairs = {}
    for part in text.split(","):
        key, _, number = part.partition("=")
        try:
            pairs[key.strip()] = float(number)
        except ValueError:
            raise click.BadParameter(f"{part!r} is not like Fz0=1000") from None
        if not isfinite(pairs[key.strip()]):
            raise click.BadParameter(f"{part!r} is not finite")
    return pairs


def texts_by_channel(text: str) -> dict[str, str]:
    """Read ``channel=text,channel=text``."""
    pairs = {}
    for part in text.split(","):
        key, equals, value = (piece.strip() for piece in part.partition("="))
        if not (key and equals and value):
            raise click.BadParameter(f"{part!r} is not like Fy=FY")
        pairs[key] = value
    return pairs


def numbers(text: str) -> tuple[float, ...]:
    """Read ``number,number``."""
    try:
        return tuple(float(part) for part in text.split(","))
    except ValueError:
        raise click.BadParameter(f"{text!r} is not like 60,110,160") from None


def _radius(text: str) -> float:
    """Read ``R0=number``: the free radius of a tire file without it."""
    pairs = numbers_by_name(text)
    if pairs.keys() != {"R0"}:
        raise click.BadParameter(f"{text!r} is not like R0=0.3")
    return pairs["R0"]


NOMINAL = click.option("--nominal", type=numbers_by_name, metavar="NAME=VALUE,...",
                       help="Nominal values: Fz0 (N), R0 (m), p0 (Pa), V0 (m/s).")  # fmt: skip
RADIUS = click.option("--nominal", "radius", type=_radius, metavar="R0=VALUE",
                      help="R0 (m) of a tire file without UNLOADED_RADIUS: --nominal R0=0.3.")  # fmt: skip
#: How columns are read.
_COLUMNS = click.option("--columns", type=texts_by_channel, metavar="CHANNEL=NAME,...",
                        help="Columns by channel, such as Fy=FYC,alpha=-SA (minus: other sign; none: not read). "
                             "Channels: tirefmu columns")  # fmt: skip
_UNITS = click.option("--units", type=texts_by_channel, metavar="CHANNEL=NAME,...",
                      help="Units of columns, such as Fz=lbf,alpha=deg.")  # fmt: skip


def names(ctx: click.Context, param: click.Parameter, value: str | None) -> tuple[str, ...] | None:
    """Split a comma-separated list; "none" is the empty one."""
    if value is None:
        return None
    return () if value == "none" else tuple(part.strip() for part in value.split(",") if part.strip())


def common(command: Callable[..., Any]) -> Callable[..., Any]:
    """Add the options of all commands, --json and --quiet."""
    command = click.option("--json", "json_file", type=FILE, help="Write the result as JSON ('-': standard output).")(
        command
    )
    return click.option("--quiet", is_flag=True, help="Print errors only.")(command)


@dataclass(frozen=True)
class TableOptions:
    """How tables are read: sign convention, rows, columns and units."""

    signs: str | None
    where: str | None
    columns: dict[str, str] | None
    units: dict[str, str] | None

    @property
    def arguments(self) -> list[str]:
        """The options of a command that reads tables in the same way."""
        given: list[str] = []
        for name, value in vars(self).items():
            if value:
                text = ",".join(f"{key}={part}" for key, part in value.items()) if isinstance(value, dict) else value
                given += [f"--{name}", text]
        return given


@dataclass(frozen=True)
class Spread:
    """What computes in parallel: a Dask cluster, or a number of local processes."""

    scheduler: str | None
    workers: int | None

    def __post_init__(self) -> None:
        if self.scheduler and self.workers:
            raise TirefmuError("--workers is for this machine, --scheduler for a cluster")


def grouped(**groups: type[Any]) -> Callable[[Callable[..., Any]], Callable[..., Any]]:
    """Pass the options that are fields of a frozen class to a command as one value of that class."""

    def of(command: Callable[..., Any]) -> Callable[..., Any]:
        @wraps(command)
        def called(**options: Any) -> Any:
            for name, group in groups.items():
                options[name] = group(**{field.name: options.pop(field.name) for field in fields(group)})
            return command(**options)

        return called

    return of


def tables_read(command: Callable[..., Any]) -> Callable[..., Any]:
    """Add --signs, --where, --columns and --units; the command takes them as one value, `selection`."""
    command = grouped(selection=TableOptions)(command)
    for option in (_UNITS, _COLUMNS, WHERE, SIGNS):
        command = option(command)
    return command


def check_input_paths(*paths: Path | None) -> None:
    """Raise for a missing file, before the packages are loaded that read files.

    A path without an extension may be the name of a published tire. None is a path that was not given. Raises also if
    the command would write over one of them: the recording may be the only one.
    """
    written = [path for path in _outputs() if path.exists()]
    for path in paths:
        if path and path.exists() and any(path.samefile(output) for output in written):
            raise TirefmuError(f"{path}: is an input of this command: give its result another name")
        if path and path.suffix and not path.exists():
            neighbors = [Path(name) for name in _neighbors(path)]
            of_kind = {file.stem: file.name for file in neighbors if file.suffix == path.suffix}
            near = [of_kind[stem] for stem in get_close_matches(path.stem, of_kind, n=1)]
            near = near or [file.name for file in neighbors if file.stem == path.stem]
            raise TirefmuError(f"{path}: no such file{f': did you mean {near[0]}?' if near else ''}")


def _outputs() -> list[Path]:
    """Return the files that the running command has named as its results so far."""
    context = click.get_current_context(silent=True)
    outputs: list[Path] = [] if context is None else context.meta.setdefault(f"{__name__}.outputs", [])
    return outputs


def _neighbors(path: Path) -> list[str]:
    """Return the names of the files in the folder of a path; none if it cannot be read."""
    try:
        return sorted(entry.name for entry in path.absolute().parent.iterdir())
    except OSError:
        return []


def check_output_paths(*files: Path | None, folder: Path | None = None) -> None:
    """Raise for an output path that cannot be written, before any work starts and any output is written."""
    for path in files:
        if path is None or str(path) == "-":
            continue
        if not path.absolute().parent.is_dir():
            raise TirefmuError(f"{path}: no folder {path.parent}")
        if path.is_dir():
            raise TirefmuError(f"{path}: is a folder, not a file")
        if path.absolute() in (other.absolute() for other in _outputs()):
            raise TirefmuError(f"{path}: is the name of two results")
        _check_permission(path)
        _outputs().append(path)
    if folder is not None and folder.exists() and not folder.is_dir():
        raise TirefmuError(f"{folder}: is a file, not a folder")
    if folder is not None:
        _check_permission(folder)


def _check_permission(path: Path) -> None:
    """Raise if a path, or the nearest folder above it that exists, cannot be written."""
    nearest = next(place for place in (path.absolute(), *path.absolute().parents) if place.exists())
    if not os.access(nearest, os.W_OK):
        raise TirefmuError(f"{path}: cannot be written (no permission)")


def json_is_printed() -> bool:
    """Return whether the running command writes its result as JSON to standard output."""
    context = click.get_current_context(silent=True)
    return context is not None and str(context.params.get("json_file")) == "-"


def write_json(path: Path | None, content: dict[str, Any]) -> None:
    """Write a result as JSON to a file, or to standard output for "-"; nothing if `path` is None."""
    if path is None:
        return
    # A bool of NumPy is no bool for json; as a text it would be true whatever its value. All else is a path.
    text = json.dumps(content, indent=2, allow_nan=False, default=lambda value: getattr(value, "item", value.__str__)())
    if str(path) == "-":
        print(text)
        return
    with writing(path):
        path.write_text(text + "\n", encoding="utf-8")
