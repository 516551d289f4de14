"""Pages of tires: ``tirefmu compare``, what differs between two, and ``tirefmu explore``, sliders for one."""

from __future__ import annotations

from pathlib import Path

import click

from .arguments import (
    DRAW_SIGNS,
    FILE,
    TableOptions,
    check_input_paths,
    check_output_paths,
    common,
    tables_read,
    write_json,
)
from .command import command


@command(
    section="Work with a tire", place=4,
    examples=(
        "compare old.tir new.tir run.csv -o comparison",
        "compare my.tir trento_hoosier -o comparison",
    ),
)  # fmt: skip
@click.argument("tire", type=FILE)
@click.argument("tire2", type=FILE)
@click.argument("tables", type=FILE, nargs=-1)
@click.option("-o", "--output", type=FILE, required=True, help="Folder for report.html and the figures.")
@DRAW_SIGNS
@tables_read
@click.option("--all", "every", is_flag=True, help="List every coefficient that differs.")
@common
def compare(
    tire: Path, tire2: Path, tables: tuple[Path, ...], output: Path, selection: TableOptions, draw_signs: str | None,
    every: bool, quiet: bool, json_file: Path | None,
) -> int:  # fmt: skip
    """Compare TIRE with TIRE2, of any models.

    Coefficients, errors over TABLES, figures of old and new parameters.
    """
    check_output_paths(json_file, folder=output)
    check_input_paths(tire, tire2, *tables)
    from ..applications.comparison.comparison import compare as run
    from ..applications.comparison.figures import short, write_comparison
    from ..measurements import recordings_from
    from ..tires import tire_from
    from .terminal import Terminal

    terminal = Terminal(quiet)
    first, second = tire_from(tire), tire_from(tire2)
    recordings = recordings_from(tables, **vars(selection)) if tables else []
    terminal.selection(*recordings)
    with terminal.working("comparing"):
        result = run(first, second, recordings, names=(tire.stem, tire2.stem))
        written = write_comparison(result, recordings, output, signs=draw_signs or selection.signs or "iso")
    write_json(json_file, {**result.to_json(), "files": [str(path) for path in written]})
    terminal.print(f"verdict: {result.verdict}")
    if result.characteristics:
        header = ["", *result.names, "unit", "change"]
        rows = [
            [
                c.remark,
                short(c.first),
                short(c.second),
                "" if c.unit == "1" else c.unit,
                f"{c.change:+.1%}" if c.first else "",
            ]
            for c in result.characteristics
        ]
        terminal.table(f"At {short(result.characteristics[0].load)} N, without slip", (header, rows))
    for name, names in zip(result.names, result.effects, strict=True):
        if names:
            terminal.print(f"effects of {name} only: {', '.join(names)}")
    quality = []
    for error in result.errors:
        pairs = zip(error.rmse, error.r2, strict=True)
        numbers = [short(number) for pair in pairs for number in pair]
        quality.append([error.recording, error.channel, str(error.rows), *numbers])
    if quality:
        columns = [f"{what} {name}" for name in result.names for what in ("RMSE", "R2")]
        terminal.table("", (["recording", "channel", "rows", *columns], quality))
    values = [
        [difference.name, short(difference.first), short(difference.second), difference.unit, difference.remark]
        for difference in result.differences
    ]
    header = ["coefficient", *result.names, "unit", "description"]
    terminal.table(result.counted, (header, values), most=10_000 if every else 12)
    terminal.print(f"report: {written[0]}")
    return 0


@command(
    section="From a recording to a tire", place=3,
    examples=(
        "explore my.tir -o tire.html",
        "explore my.tir run.csv --fit fit.json -o tire.html",
        "explore new.tir --compare trento_hoosier -o tires.html",
    ),
)  # fmt: skip
@click.argument("tire", type=FILE)
@click.argument("tables", type=FILE, nargs=-1)
@click.option("-o", "--output", type=FILE, required=True, help="HTML page to write.")
@click.option("--compare", type=FILE, help="Second tire, of any model.")
@click.option("--fit", "fit_json", type=FILE, help="Result of 'fit --json': its 95 % intervals are marked.")
@tables_read
@common
def explore(
    tire: Path, tables: tuple[Path, ...], output: Path, compare: Path | None, fit_json: Path | None,
    selection: TableOptions, quiet: bool, json_file: Path | None,
) -> int:  # fmt: skip
    """Write a page with sliders and curves of TIRE.

    Coefficients, effects and inputs have sliders; the data of TABLES are under the curves. The page is one file that
    needs no connection. It saves a changed tire as .tir; its address contains its state.
    """
    check_output_paths(output, json_file)
    check_input_paths(tire, *tables, compare, fit_json)
    from ..applications.explorer.explore import explore as run
    from ..applications.explorer.explore import fit_intervals
    from ..measurements import recordings_from
    from .terminal import Terminal

    terminal = Terminal(quiet)
    intervals = fit_intervals(fit_json, tire) if fit_json else {}
    recordings = recordings_from(tables, **vars(selection)) if tables else []
    terminal.selection(*recordings)
    with terminal.working("writing the page"):
        run(tire, output, tables=recordings, compare=compare, intervals=intervals)
    size = output.stat().st_size
    write_json(json_file, {"ok": True, "page": str(output), "bytes": size})
    terminal.print(f"page: {output} ({size / 1024:.0f} KB)")
    return 0
