"""``tirefmu diagnose``: the missing effect named, added to the tire, and shown in two FMUs and a page."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from tirefmu.symbolic.errors import TirefmuError

from .arguments import FILE, SIGNS, Pairs, check_places, common, names, tire_named, write_json
from .terminal import Terminal

if TYPE_CHECKING:
    from tirefmu.diagnosis import Diagnosis
    from tirefmu.measurements import Recording


@click.command()
@click.argument("table", type=FILE)
@click.option("--tire", type=FILE, help="The tire that the recording is held against (else --model and what follows).")
@click.option("--model", default="mf61", show_default=True, help="Model of the start tire.")
@click.option("--effects", callback=names, help="What the start model has on top of its core, or 'none'.")
@click.option("--nominal", type=Pairs(), help="Nominal values: Fz0 (N), R0 (m), p0 (Pa), V0 (m/s).")
@click.option("--signs", type=SIGNS, help="Convention of the table (default: sae for .mat and .dat, iso for tables).")
@click.option("--candidates", callback=names, help="Try only these effects.")
@click.option("--effect", "own", type=FILE, multiple=True, help="File of an effect of your own, tried too.")
@click.option("--fmu/--no-fmu", "fmus", default=True, show_default=True, help="Export and simulate both tires.")
@click.option("-o", "--output", type=FILE, required=True, help="Folder for diagnosis.json, report.html, tires, FMUs.")
@common
def diagnose(
    table: Path, tire: Path | None, model: str, effects: tuple[str, ...] | None, nominal: dict[str, float] | None,
    signs: str | None, candidates: tuple[str, ...] | None, own: tuple[Path, ...], fmus: bool, output: Path,
    quiet: bool, json_file: Path | None,
) -> int:  # fmt: skip
    """Find the effect that a tire model lacks to explain the recording TABLE, add it, and show the gap shrink."""
    from tirefmu.diagnosis import diagnose as run
    from tirefmu.diagnosis import write_report
    from tirefmu.measurements import check_plausible, read_recording

    terminal = Terminal(quiet)
    check_places(json_file, folder=output)
    recording = read_recording(table, signs=signs)
    check_plausible(recording)
    started = tire_named(tire) if tire else None
    own_effects = [_own_effect(path) for path in own]
    tried = [*own_effects, *(candidates or ())] or None
    with terminal.working("diagnosing"):
        result = run(
            recording.table, signs=recording.signs, model=model, effects=effects or (), nominal=nominal, tire=started,
            candidates=tried, progress=terminal.print,
        )  # fmt: skip
        path = result.save(output)
        written = {"tire": "improved.tir", "base_tire": "base.tir"}
        simulated: dict[str, Any] = {}
        if fmus:
            simulated = _simulated(result, recording, output)
            written |= {"fmu": "improved.fmu", "base_fmu": "base.fmu"}
        told = {**result.to_json(**written), "simulated": simulated}
        write_json(path, told)
        write_report(result, recording, output / "report.html")
    write_json(json_file, {"ok": True, **told})
    terminal.print(result.verdict)
    terminal.print(f"written: {output / 'report.html'}, diagnosis.json, {', '.join(written.values())}")
    return 0


def _own_effect(path: Path) -> Any:
    from tirefmu.symbolic.added import read_effect

    try:
        return read_effect(path.read_text(encoding="utf-8"), str(path))
    except (OSError, UnicodeDecodeError) as error:
        raise TirefmuError(f"{path}: cannot be read ({getattr(error, 'strerror', None) or error})") from None


def _simulated(result: Diagnosis, recording: Recording, folder: Path) -> dict[str, Any]:
    """Export both tires, simulate both FMUs over the recording, and return what each leaves of every channel."""
    from tirefmu.fmu import check, export

    told = {}
    for when, tire, name in (("before", result.base_tire, "base.fmu"), ("after", result.tire, "improved.fmu")):
        export(replace(tire.in_signs("iso"), name=tire.name or name.removesuffix(".fmu")), folder / name, fmi=3)
        simulation = check(folder / name, recording)
        told[when] = {
            "rmse": {one.name: one.rmse for one in simulation.channels},
            "difference_from_direct_evaluation": simulation.evaluation_difference,
        }
    return told
