"""The page of a tire: sliders for its coefficients and inputs, curves, measured points, numbers."""

from __future__ import annotations

import json
import re
from collections.abc import Iterable, Mapping, Sequence
from importlib.resources import files
from pathlib import Path
from typing import Any

from ...boundary.bounded_file import read_bounded
from ...boundary.errors import TirefmuError, UnknownName, nearest, path_from, writing
from ...boundary.escaping import html_text, script_json, script_text
from ...boundary.named_options import named
from ...drawing.chart_library import LIBRARY_SCRIPT, LIBRARY_STYLE, allowed, library_file
from ...drawing.page import style_sheet, write_page
from ...measurements import Recording, TableLike, recordings_from
from ...symbolic.declarations import Quantity
from ...symbolic.printers.languages import printer
from ...symbolic.printers.languages.program import PrintedProgram, PrintoutSelection, program
from ...tires import Tire, TireLike, tire_from
from ...tires.tire_argument import tire_label
from .measured_rows import measured_rows, rows_data
from .tire_data import switchable, tire_data

#: The scripts of the page, in their order, after the chart library.
SCRIPTS = (
    "tire_state.js", "property_file.js", "measured_rows.js", "curves.js", "time_response.js", "key_figures.js",
    "charts.js", "surface.js", "controls.js", "time_panel.js", "address.js", "page.js",
)  # fmt: skip


@named()
def explore(
    tire: TireLike,
    path: str | Path,
    *,
    tables: TableLike | Iterable[TableLike] = (),
    signs: str | None = None,
    compare: TireLike | None = None,
    intervals: Mapping[str, tuple[float, float]] | None = None,
) -> None:
    """Write a page on which coefficients, effects and inputs of a tire can be changed.

    The page is one file without connections to others: chart library, measured rows and the tire's code are in it.

    Parameters
    ----------
    tire : Tire, path of a .tir file, or name of a published tire
        The page is in ISO-W.
    path : str or Path
        The HTML file.
    tables : path, DataFrame or Recording, or a sequence of them
        Their rows are drawn under the curves.
    signs : str, optional
        Sign convention of the tables, as for `tirefmu.fit`.
    compare : Tire, path or name, optional
        A second tire, of any model.
    intervals : mapping of str to (float, float), optional
        95 % intervals of coefficients in ISO-W, as in `FitResult.to_json`.

    Raises
    ------
    TirefmuError
        If the page cannot be written, or the chart library is not installed.
    UnknownName
        If an interval belongs to no coefficient of the tire's model.
    DataError, WrongType
        If a table cannot be read.

    Examples
    --------
    >>> import tempfile
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     explore("trento_hoosier", Path(folder) / "tire.html")
    ...     (Path(folder) / "tire.html").stat().st_size > 100_000
    True
    """
    path = path_from(path)
    text = page_text(tire, recordings=recordings_from(tables, signs=signs), compare=compare, intervals=intervals or {})
    with writing(path):
        write_page(text, path)


def page_text(
    tire: TireLike,
    *,
    recordings: Sequence[Recording] = (),
    compare: TireLike | None = None,
    intervals: Mapping[str, tuple[float, float]],
) -> str:
    """Return the text of the page; `explore` documents the parameters."""
    given = [tire] if compare is None else [tire, compare]
    tires = [(tire_from(tire).in_signs("iso"), tire_label(tire)) for tire in given]
    first = tires[0][0]
    for name in intervals:
        if name not in first.symbolic_model.coefficients:
            raise UnknownName(f"coefficient of {first.model}", name, first.symbolic_model.coefficients)
    programs = [program_for_page(switchable(tire)) for tire, _ in tires]
    data: dict[str, Any] = {
        "tires": [
            tire_data(tire, name, program.coefficients, intervals if i == 0 else {}, lagged_slips(program))
            for i, ((tire, name), program) in enumerate(zip(tires, programs, strict=True))
        ],
        "rows": rows_data(measured_rows(recordings, first.inputs)),
    }
    code = ",\n".join(module_expression(program) for program in programs)
    scripts = [
        f"const GENERATED = [\n{code}\n];",
        "\n".join([library_file(LIBRARY_SCRIPT), *map(_file, SCRIPTS)]),
    ]
    return _filled(
        _file("page.html"),
        {
            "title": html_text(" and ".join(tire["name"] for tire in data["tires"])),
            "hashes": " ".join(map(allowed, scripts)),
            "style": "\n".join([library_file(LIBRARY_STYLE), style_sheet(), _file("style.css")]),
            "coefficients": "\n".join(_coefficient_table(tire, name) for tire, name in tires),
            "data": script_json(json.dumps(data, allow_nan=False, separators=(",", ":"))),
            "code": scripts[0],
            "scripts": scripts[1],
        },
    )


def _coefficient_table(tire: Tire, name: str) -> str:
    """Return the table that the page has in place of its sliders where scripts are off."""
    rows = [
        f'<tr><th>{html_text(c.name)}</th><td class="n">{tire.values[c.name]:.6g}</td>'
        f"<td>{html_text('' if c.unit == '1' else c.unit)}</td><td>{html_text(c.description)}</td></tr>"
        for c in tire.symbolic_model.coefficients.values()
    ]
    return f"<h2>{html_text(name)}</h2>\n<table>\n" + "\n".join(rows) + "\n</table>"


def _file(name: str) -> str:
    return (files("tirefmu.applications.explorer") / "browser" / name).read_text(encoding="utf-8")


def _filled(template: str, values: Mapping[str, str]) -> str:
    """Return a template with its marks @name@ replaced simultaneously: a value that contains a mark keeps it."""
    return re.sub("@([a-z]+)@", lambda mark: values[mark[1]], template)


#: Upper limit of the file, bytes.
LARGEST = 50_000_000


def fit_intervals(path: Path, tire: TireLike) -> dict[str, tuple[float, float]]:
    """Return the 95 % intervals of a fit in ISO-W, by coefficient; those without a finite interval are absent.

    `path`: result of ``tirefmu fit --json``. `tire`: the fitted tire. Raises `TirefmuError` if the file is not the
    result of a fit of a tire of this model.
    """
    declared = tire_from(tire).symbolic_model.coefficients
    intervals = {}
    try:
        content = json.loads(read_bounded(path, LARGEST))
        mirrored = content["signs"] != "iso"
        for coefficient in content["coefficients"]:
            name, half = coefficient["name"], coefficient["interval"]
            if half is not None:
                value = float(coefficient["value"]) * (-1.0 if mirrored and declared[name].flips else 1.0)
                intervals[str(name)] = (value - float(half), value + float(half))
    except (OSError, ValueError, TypeError, KeyError, RecursionError) as error:
        what = f"unknown or missing entry {error}" if isinstance(error, KeyError) else str(error)
        raise TirefmuError(f"{path}: not the JSON result of a fit of this tire's model ({what})") from error
    if unknown := sorted(intervals.keys() - declared.keys()):
        raise TirefmuError(f"{path}: {unknown[0]} is no coefficient of the tire's model{nearest(unknown[0], declared)}")
    return intervals


#: Name of the module's files; it does not occur in the page.
_NAME = "tire"


def program_for_page(tire: Tire) -> PrintedProgram:
    """Return what the page computes: forces, named quantities, rates of states, with the coefficients as variables.

    `tire`: in ISO-W. Its effects are those that can be switched on the page.
    """
    coefficients = dict(zip(tire.symbolic_model.coefficients, tire.parameters().tolist(), strict=False))
    nominal = {name: tire.nominal(name) for name in tire.inputs}
    states = ("states",) if tire.lags or tire.states else ()
    selection = PrintoutSelection(("forces", "quantities", *states), "struct")
    return program(_NAME, tire.symbolic_model, tire.has, coefficients, nominal, selection)


def lagged_slips(program: PrintedProgram) -> list[Quantity]:
    """Return the lagged slips of a program: inputs that its model does not have."""
    return [quantity for quantity in program.inputs if quantity not in program.model.inputs]


def module_expression(program: PrintedProgram) -> str:
    """Return a JavaScript expression whose value has the functions of a program.

    Returns: printable ASCII. Comments are not part of it: they may contain text from files.
    """
    module = printer("javascript")(program)[f"{_NAME}.mjs"]
    plain = re.sub(r"/\*.*?\*/|//[^\n]*", "", module, flags=re.DOTALL)
    lines = (line.rstrip() for line in plain.splitlines())
    body = "\n".join(line for line in lines if line).replace("export ", "")
    functions = ", ".join(routine.name for routine in program.routines)
    return script_text(f"(() => {{\n{body}\nreturn {{ {functions} }};\n}})()")
