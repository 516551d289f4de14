"""``tirefmu explore``: a page with sliders for a tire."""

from __future__ import annotations

from pathlib import Path

import click

from tirefmu.measurements.files.formats import DEFAULT_SIGNS

from ..arguments import (
    FILE,
    SIGNS,
    Selection,
    check_input_paths,
    check_output_paths,
    common,
    grouped,
    table_options,
    write_json,
)


@click.command()
@click.argument("tire", type=FILE)
@click.argument("tables", type=FILE, nargs=-1)
@click.option("-o", "--output", type=FILE, required=True, help="HTML page to write.")
@click.option("--compare", type=FILE, help="Second tire, of any model.")
@click.option("--fit", "fit_json", type=FILE, help="Result of 'fit --json': its 95 % intervals are marked.")
@click.option("--signs", type=SIGNS, help=f"Convention of the tables (default: {DEFAULT_SIGNS}).")
@table_options
@common
@grouped(selection=Selection)
def explore(
    tire: Path, tables: tuple[Path, ...], output: Path, compare: Path | None, fit_json: Path | None,
    selection: Selection, quiet: bool, json_file: Path | None,
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
