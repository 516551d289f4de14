"""``tirefmu demo``: the full workflow on the virtual bench."""

from __future__ import annotations

from pathlib import Path

import click

from .arguments import (
    FILE,
    check_output_paths,
    common,
    write_json,
)
from .command import command


@command(
    section="To try it", place=1,
    examples=(
        "demo -o demo-output",
    ),
)  # fmt: skip
@click.option("-o", "--output", type=FILE, default=Path("demo-output"), show_default=True, help="Folder to write.")
@common
def demo(output: Path, quiet: bool, json_file: Path | None) -> int:
    """Run the full workflow on the virtual bench.

    Measurement, fit, FMU, check, and the diagnosis of a missing effect. index.html shows all results.
    """
    check_output_paths(json_file, folder=output)
    from .demo import run
    from .terminal import Terminal

    terminal = Terminal(quiet)
    summary = run(output, terminal)
    write_json(json_file, summary)
    return 0 if summary["ok"] else 1
