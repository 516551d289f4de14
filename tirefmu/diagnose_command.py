"""``tirefmu diagnose``: the missing effect named, added to the tire, and shown in two FMUs and a page."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import click

from tirefmu.symbolic import DEFAULT_MODEL
from tirefmu.symbolic.errors import TirefmuError
from tirefmu.tires import tire_from

from .arguments import FILE, MODEL, SIGNS, Pairs, check_places, common, names, write_json
from .terminal import Terminal


@click.command()
@click.argument("table", type=FILE)
@click.option("--tire", type=FILE, help="The tire that the recording is held against (else --model and what follows).")
@MODEL
@click.option("--effects", callback=names, help="What the start model has on top of its core, or 'none'.")
@click.option("--nominal", type=Pairs(), help="Nominal values: Fz0 (N), R0 (m), p0 (Pa), V0 (m/s).")
@click.option("--signs", type=SIGNS, help="Convention of the table (default: sae for .mat and .dat, iso for tables).")
@click.option("--candidates", callback=names, help="Try only these effects.")
@click.option("--effect", "own", type=FILE, multiple=True, help="File of an effect of your own, tried too.")
@click.option("--holdout", "others", type=FILE, multiple=True,
              help="Untouched recording over which both tires are simulated too; may be given again.")  # fmt: skip
@click.option("--fmu/--no-fmu", "fmus", default=True, show_default=True, help="Export and simulate both tires.")
@click.option("-o", "--output", type=FILE, required=True, help="Folder for diagnosis.json, report.html, tires, FMUs.")
@common
def diagnose(
    table: Path, tire: Path | None, model: str | None, effects: tuple[str, ...] | None,
    nominal: dict[str, float] | None,
    signs: str | None, candidates: tuple[str, ...] | None, own: tuple[Path, ...], others: tuple[Path, ...], fmus: bool,
    output: Path, quiet: bool, json_file: Path | None,
) -> int:  # fmt: skip
    """Find the effect that a tire model lacks to explain the recording TABLE, add it, and show the gap shrink."""
    from tirefmu.diagnosis import diagnose as run
    from tirefmu.diagnosis import export_and_simulate, write_report
    from tirefmu.measurements import recordings_from

    terminal = Terminal(quiet)
    check_places(json_file, folder=output)
    if others and not fmus:
        raise TirefmuError("--holdout is what FMUs are simulated over: not together with --no-fmu")
    recording, *further = recordings_from([table, *others], signs=signs)
    for one in (recording, *further):
        one.measured()  # refuses a table without a measured output
    started = tire_from(tire) if tire else None
    own_effects = [own_effect(path) for path in own]
    tried = [*own_effects, *(candidates or ())] or None
    with terminal.working("diagnosing"):
        result = run(
            recording, model=model or DEFAULT_MODEL, effects=effects or (), nominal=nominal, tire=started,
            candidates=tried, progress=terminal.print,
        )  # fmt: skip
        path = result.save(output)
        written = {"tire": "improved.tir", "base_tire": "base.tir"}
        simulated: dict[str, Any] = {}
        if fmus:
            terminal.print("building both FMUs and simulating them")
            simulated = export_and_simulate(result, recording, output, further)
            written |= {"fmu": "improved.fmu", "base_fmu": "base.fmu"}
        told = {**result.to_json(**written), "simulated": simulated}
        write_json(path, told)
        write_report(result, recording, output / "report.html", simulated)
    ok = bool(simulated.get("ok", True))
    write_json(json_file, {"ok": ok, **told})
    terminal.print(result.verdict)
    for line in _gap_lines(told):
        terminal.print(line)
    proposed = [one.effect.name + ".toml" for one in result.unknown if one.effect]
    written_names = [*written.values(), *proposed]
    terminal.print(f"written: {output / 'report.html'}, diagnosis.json, {', '.join(written_names)}")
    return 0 if ok else 1


def _gap_lines(told: dict[str, Any]) -> list[str]:
    """Tell the hold-out's gap and what the FMUs are worth."""
    lines = [
        f"  {channel} on the hold-out: {gap['before']:.4g} before, {gap['after']:.4g} after, floor {gap['floor']:.4g}"
        for channel, gap in told["gap"]["holdout"].items() if gap["before"] is not None
    ]  # fmt: skip
    if told["simulated"]:
        worst = max(told["simulated"][when]["difference_from_direct_evaluation"] for when in ("before", "after"))
        lines.append(f"  both FMUs are their tires evaluated with --hold, to {worst:.1e}")
    return lines


def own_effect(path: Path) -> Any:
    """Return the effect that a file describes."""
    from tirefmu.symbolic.added import read_effect

    try:
        return read_effect(path.read_text(encoding="utf-8"), str(path))
    except (OSError, UnicodeDecodeError) as error:
        raise TirefmuError(f"{path}: cannot be read ({getattr(error, 'strerror', None) or error})") from None
