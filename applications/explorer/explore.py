"""The page of a tire: sliders for its coefficients and inputs, curves, measured points, numbers."""

from __future__ import annotations

import json
import re
from collections.abc import Iterable, Mapping, Sequence
from importlib.resources import files
from pathlib import Path
from typing import Any

from ...boundary.errors import UnknownName, path_from, writing
from ...boundary.escaping import html_text, script_json
from ...boundary.named_options import named
from ...drawing.chart_library import LIBRARY_SCRIPT, LIBRARY_STYLE, allowed, library_file
from ...drawing.page import style_sheet, write_page
from ...measurements import Recording, TableLike, recordings_from
from ...tires import Tire, TireLike, tire_from
from ...tires.tire_argument import tire_label
from .measured_rows import measured_rows, rows_data
from .page_code import lagged_slips, module_expression, program_for_page
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
