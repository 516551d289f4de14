"""``tirefmu draw``: figures of a tire."""

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
    numbers,
    tables_read,
    write_json,
)
from .command import command


@command(
    section="Work with a tire", place=3,
    examples=(
        "draw my.tir -o figures",
        "draw unicamp_small_tire points.csv --kappa -1.1,1.1 -o figures",
    ),
)  # fmt: skip
@click.argument("tire", type=FILE)
@click.argument("tables", type=FILE, nargs=-1)
@click.option("-o", "--output", type=FILE, required=True, help="Folder to write.")
@click.option("--loads", type=numbers, metavar="NUMBER,...",
              help="Loads in N (default: those of TABLES, or three over the tire's range).")  # fmt: skip
@click.option("--kappa", type=numbers, metavar="LOW,HIGH",
              help="Range of kappa, such as -1.1,1.1 (default: that of the tire, at most -1,1).")  # fmt: skip
@DRAW_SIGNS
@tables_read
@click.option("--format", "suffix", type=click.Choice(["png", "svg", "pdf"]), default="png", show_default=True)
@common
def draw(
    tire: Path, tables: tuple[Path, ...], output: Path, loads: tuple[float, ...] | None,
    kappa: tuple[float, ...] | None, selection: TableOptions,
    draw_signs: str | None, suffix: str, quiet: bool, json_file: Path | None,
) -> int:  # fmt: skip
    """Draw TIRE at several loads.

    The figures are pure slip, surfaces of Fx and Fy over both slips, and Fy over Fx. Measured rows of TABLES are
    points.
    """
    check_output_paths(json_file, folder=output)
    check_input_paths(tire, *tables)
    from ..tires import tire_from
    from ..tires.definition import default_loads
    from ..tires.description import limits_of
    from ..tires.drawing.files import draw as run
    from .terminal import Terminal

    terminal = Terminal(quiet)
    loaded = tire_from(tire)
    points = None
    if tables:
        import pandas as pd

        from ..measurements import check_columns, levels, recordings_from

        recordings = recordings_from(tables, **vars(selection))
        terminal.selection(*recordings)
        for recording in recordings:
            check_columns(recording, fitted=False)
        parts = [recording.with_signs("iso").table for recording in recordings]
        nominal = loaded.in_signs("iso").nominal("Fz")
        points = pd.concat([part.assign(Fz=part.get("Fz", nominal)) for part in parts], ignore_index=True)
        measured = dict.fromkeys(float(f"{level:.2g}") for level in levels(points["Fz"]))
        loads = tuple(measured) or None if loads is None else loads
    loads = default_loads(loaded) if loads is None else loads
    shown = draw_signs or selection.signs or "iso"
    with terminal.working("drawing"):
        drawn = run(loaded, output, loads=loads, signs=shown, suffix=suffix, points=points, kappa=kappa)
    write_json(json_file, {"ok": True, "loads": list(loads), "signs": shown, "figures": [str(p) for p in drawn]})
    terminal.print(f"figures at {', '.join(f'{load:g}' for load in loads)} N, signs {shown}:")
    for path in drawn:
        terminal.print(f"  {path}")
    terminal.print(*(f"note: {note}" for note in limits_of(loaded)))
    return 0
