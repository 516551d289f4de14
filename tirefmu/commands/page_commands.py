"""Pages of tires: ``tirefmu compare``, what differs between two, and ``tirefmu explore``, sliders for one."""

from __future__ import annotations

from pathlib import Path

import click

from tirefmu.measurements.files.formats import DEFAULT_SIGNS

from ..arguments import (
    FILE,
    SIGNS,
    TableOptions,
    check_input_paths,
    check_output_paths,
    common,
    grouped,
    table_options,
    write_json,
)


@click.command()
@click.argument("tire", type=FILE)
@click.argument("tire2", type=FILE)
@click.argument("tables", type=FILE, nargs=-1)
@click.option("-o", "--output", type=FILE, required=True, help="Folder for report.html and the figures.")
@click.option("--signs", type=SIGNS, help=f"Convention of the tables (default: {DEFAULT_SIGNS}).")
@click.option("--draw-signs", type=SIGNS, help="Sign convention of the figures (default: that of --signs, else iso).")
@table_options
@click.option("--all", "every", is_flag=True, help="List every coefficient that differs.")
@common
@grouped(selection=TableOptions)
def compare(
    tire: Path, tire2: Path, tables: tuple[Path, ...], output: Path, selection: TableOptions, draw_signs: str | None,
    every: bool, quiet: bool, json_file: Path | None,
) -> int:  # fmt: skip
    """Compare TIRE with TIRE2, of any models.

    Coefficients, errors over TABLES, figures of old and new parameters.
    """
    check_output_paths(json_file, folder=output)
    check_input_paths(tire, tire2, *tables)
    from tirefmu.comparison.comparison import compare as run
    from tirefmu.comparison.report import write_comparison
    from tirefmu.measurements import recordings_from
    from tirefmu.tires import tire_from

    from ..terminal import Terminal

    terminal = Terminal(quiet)
    first, second = tire_from(tire), tire_from(tire2)
    recordings = recordings_from(tables, **vars(selection)) if tables else []
    terminal.selection(*recordings)
    with terminal.working("comparing"):
        result = run(first, second, recordings, names=(tire.stem, tire2.stem))
        written = write_comparison(result, recordings, output, signs=draw_signs or selection.signs or "iso")
    write_json(json_file, {**result.to_json(), "files": [str(path) for path in written]})
    terminal.print(f"verdict: {result.verdict}")
    for name, names in zip(result.names, result.effects, strict=True):
        if names:
            terminal.print(f"effects of {name} only: {', '.join(names)}")
    quality = []
    for error in result.errors:
        pairs = zip(error.rmse, error.r2, strict=True)
        numbers = [_short(number) for pair in pairs for number in pair]
        quality.append([error.recording, error.channel, str(error.rows), *numbers])
    if quality:
        columns = [f"{what} {name}" for name in result.names for what in ("RMSE", "R2")]
        terminal.table("", (["recording", "channel", "rows", *columns], quality))
    values = [
        [difference.name, _short(difference.first), _short(difference.second), difference.unit, difference.description]
        for difference in result.differences
    ]
    terminal.table("", (["coefficient", *result.names, "unit", "description"], values), most=10_000 if every else 12)
    terminal.print(f"report: {written[0]}")
    return 0


def _short(value: float | None) -> str:
    return "-" if value is None else f"{value:.5g}"


@click.command()
@click.argument("tire", type=FILE)
@click.argument("tables", type=FILE, nargs=-1)
@click.option("-o", "--output", type=FILE, required=True, help="HTML page to write.")
@click.option("--compare", type=FILE, help="Second tire, of any model.")
@click.option("--fit", "fit_json", type=FILE, help="Result of 'fit --json': its 95 % intervals are marked.")
@click.option("--signs", type=SIGNS, help=f"Convention of the tables (default: {DEFAULT_SIGNS}).")
@table_options
@common
@grouped(selection=TableOptions)
def explore(
    tire: Path, tables: tuple[Path, ...], output: Path, compare: Path | None, fit_json: Path | None,
    selection: TableOptions, quiet: bool, json_file: Path | None,
) -> int:  # fmt: skip
    """Write a page with sliders and curves of TIRE.

    Coefficients, effects and inputs have sliders; the data of TABLES are under the curves. The page is one file that
    needs no connection. It saves a changed tire as .tir; its address contains its state.
    """
    check_output_paths(output, json_file)
    check_input_paths(tire, *tables, *(path for path in (compare, fit_json) if path))
    from tirefmu.explorer.explore import explore as run
    from tirefmu.explorer.fit_intervals import fit_intervals
    from tirefmu.measurements import recordings_from

    from ..terminal import Terminal

    terminal = Terminal(quiet)
    intervals = fit_intervals(fit_json, tire) if fit_json else {}
    recordings = recordings_from(tables, **vars(selection)) if tables else []
    terminal.selection(*recordings)
    with terminal.working("writing the page"):
        run(tire, output, recordings=recordings, compare=compare, intervals=intervals)
    size = output.stat().st_size
    write_json(json_file, {"ok": True, "page": str(output), "bytes": size})
    terminal.print(f"page: {output} ({size / 1024:.0f} KB)")
    return 0
