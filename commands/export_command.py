"""``tirefmu export``: an FMU, a library with the Standard Tyre Interface, a parameter set or a system of tires."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import click

from ..boundary.errors import TirefmuError
from ..boundary.escaping import command_text
from .arguments import (
    FILE,
    RADIUS,
    TableOptions,
    check_input_paths,
    check_output_paths,
    common,
    grouped,
    tables_read,
    write_json,
)
from .command import command


@dataclass(frozen=True)
class InterfaceOptions:
    """Version, inputs and outputs of an FMU."""

    fmi: str | None
    inputs: str
    axes: str
    quantities: bool


@dataclass(frozen=True)
class SystemOptions:
    """The file of a system of tires, the vehicle in it, and whether tires of the other side are mirrored."""

    ssp: Path | None
    vehicle: Path | None
    mirror: bool


@dataclass(frozen=True)
class Proof:
    """The table of a proof, and the result of the fit; `table` may be "none"."""

    table: str
    fit: Path | None

    @property
    def path(self) -> Path | None:
        """The path of the table; None without a proof."""
        return None if self.table == "none" else Path(self.table)

    def export(self, tire: Any, target: Path, selection: TableOptions, **options: Any) -> Path:
        """Write an FMU, with its proof if there is a table; either the complete file is written or none."""
        from ..fmu import add_proof, export
        from ..fmu.proof.repetition import read_verdict
        from ..measurements import recording_from

        if self.path is None:
            return export(tire, target, **options)
        recording = recording_from(self.path, **vars(selection))
        verdict = None if self.fit is None else read_verdict(self.fit)
        with TemporaryDirectory(prefix="tirefmu-") as folder:
            # The same file name: it determines the model identifier.
            return add_proof(export(tire, Path(folder) / target.name, **options), recording, target, verdict=verdict)


@command(
    section="From a recording to a tire", place=4,
    examples=(
        "export my.tir -o my.fmu",
        "export my.tir -o my.fmu --proof run.csv",
        "export my.tir -o my.fmu --inputs wheel --fmi 2 --platforms all",
        "export my.tir --kind sti -o libmy.so",
        "export front.tir front.tir rear.tir rear.tir --ssp car.ssp",
    ),
)  # fmt: skip
@click.argument("tires", metavar="TIRE...", type=FILE, nargs=-1, required=True)
@click.option("-o", "--output", type=FILE, help="FMU to write; with --kind sti a library, with ssv a parameter set.")
@click.option("--ssp", type=FILE, metavar="FILE",
              help="Write a system of the tires (SSP): FMUs, parameter sets. Four are FL, FR, RL, RR.")  # fmt: skip
@click.option("--vehicle", type=FILE, help="With --ssp: an FMU that is connected to the tires by names such as FL_Fz.")
@click.option("--mirror/--no-mirror", default=True, show_default=True,
              help="With --ssp: mirror a tire at a corner of the side opposite to its TYRESIDE.")  # fmt: skip
@RADIUS
@click.option("--fmi", type=click.Choice(["2", "3"]),
              help="FMI version; 2 is SSP 1.0, 3 is SSP 2.0  [default: 3; pythonfmu, ssv, --ssp: 2]")  # fmt: skip
@click.option("--inputs", default="slip", show_default=True,
              help="slip: kappa, alpha, ...; wheel: velocities of the contact point and angular speed; hub: motion of"
              " the wheel carrier, spin, road; hub-torque: drive and brake torque in place of the spin.")  # fmt: skip
@click.option("--arrays", is_flag=True, help="FMI 3, hub inputs: vectors and the rotation matrix are array variables.")
@click.option("--axes", type=click.Choice(["iso", "sae"]), default="iso", show_default=True, help="Axes of the FMU.")
@click.option("--quantities", is_flag=True, help="Every named quantity is an output.")
@click.option(
    "--kind",
    type=click.Choice(["native", "pythonfmu", "sti", "ssv"]),
    default="native",
    show_default=True,
    help="FMU in C or in editable Python, library with the Standard Tyre Interface, or parameter set of SSP.",
)
@click.option(
    "--platforms",
    default="host",
    show_default=True,
    help="host, all, or FMI 3 names separated by commas (x86_64-windows, ...); to compile for others needs ziglang.",
)
@click.option(
    "--proof",
    "table",
    metavar="TABLE|none",
    default="none",
    show_default=True,
    help="Put a proof into the FMU, which `check` repeats without data. It contains the inputs of TABLE.",
)
@click.option("--fit", type=FILE, help="With --proof: JSON of the fit, whose verdict becomes part of the proof.")
@tables_read
@common
@grouped(system=SystemOptions, interface=InterfaceOptions, proof=Proof)
def export(
    tires: tuple[Path, ...], output: Path | None, system: SystemOptions, radius: float | None,
    interface: InterfaceOptions, proof: Proof, selection: TableOptions, kind: str, platforms: str,
    arrays: bool, quiet: bool, json_file: Path | None,
) -> int:  # fmt: skip
    """Export TIRE as an FMU.

    The FMU is native (Co-Simulation and Model Exchange, no Python) or contains editable Python. --ssp exports several
    tires as a system.
    """
    ssp, vehicle = system.ssp, system.vehicle
    target = output or ssp
    if target is None or (output and ssp):
        raise TirefmuError("export writes one file: give -o or --ssp")
    if output and len(tires) > 1:
        raise TirefmuError("several tires are one file as a system only: give --ssp instead of -o")
    if ssp and kind != "native":
        raise TirefmuError(f"--ssp packs native FMUs, not kind {kind}")
    if kind == "sti" and interface != InterfaceOptions(None, "slip", "iso", False):
        raise TirefmuError("--kind sti has inputs and outputs of its own: omit --fmi, --inputs, --axes, --quantities")
    if arrays and (ssp or kind != "native"):
        raise TirefmuError("--arrays is for one native FMU")
    if proof.path is None and (proof.fit or selection.arguments):
        raise TirefmuError("--fit, --signs, --where, --columns, --units belong to a proof: give --proof TABLE")
    if proof.path and (ssp or arrays or kind not in ("native", "pythonfmu")):
        raise TirefmuError("--proof is for one FMU with scalar inputs: omit --ssp, --arrays and other kinds")
    if vehicle and not ssp:
        raise TirefmuError("--vehicle is part of a system: give --ssp")
    check_output_paths(target, json_file)
    check_input_paths(*tires, vehicle, proof.path, proof.fit)
    from ..applications.sti.export import export_sti
    from ..fmu import export_parameters, export_system
    from ..fmu.description.standstill import with_lengths
    from ..fmu.packaging.system import side_notes
    from ..tires import tire_from
    from ..tires.description import limits_of
    from .terminal import Terminal

    terminal = Terminal(quiet)
    loaded = [tire_from(tire, radius=radius) for tire in tires]
    inputs = interface.inputs
    version = int(interface.fmi) if interface.fmi else 3 if kind == "native" and not ssp else 2
    shared: dict[str, Any] = {"fmi": version, "inputs": inputs, "axes": interface.axes}
    with terminal.working("compiling" if kind in ("native", "sti") else "packing"):
        if ssp:
            packed: dict[str, Any] = {"quantities": interface.quantities, "platforms": platforms, "vehicle": vehicle}
            written = export_system(loaded, target, **shared, **packed, mirror=system.mirror)
        elif kind == "ssv":
            written = export_parameters(loaded[0], target, **shared)
        elif kind == "sti":
            written = export_sti(loaded[0], target, platforms=platforms)
        else:
            options = {**shared, "quantities": interface.quantities, "kind": kind, "platforms": platforms}
            written = proof.export(loaded[0], target, selection, **options, arrays=arrays)
    size = written.stat().st_size
    what = "ssp" if ssp else kind if kind in ("ssv", "sti") else "fmu"
    described = {} if kind == "sti" else {"fmi": version, "inputs": inputs}
    summary = {"ok": True, what: str(written), **described, "kind": kind, "bytes": size}
    write_json(json_file, summary)
    tires_of = f"{len(loaded)} tire{'s' if len(loaded) > 1 else ''}, " if ssp else ""
    form = {
        "ssp": f"SSP {version - 1}.0, FMI {version}.0",
        "ssv": f"SSP {version - 1}.0 parameter set",
        "sti": "Standard Tyre Interface",
        "fmu": f"FMI {version}.0 Co-Simulation{' and Model Exchange' if kind == 'native' else ''}, {kind}",
    }[what]
    shown = "" if kind == "sti" else f"{inputs} inputs, "
    terminal.print(f"{form}, {tires_of}{shown}{size / 1024:.0f} KB: {written}")
    terminal.print(*(f"note: {note}" for note in (side_notes(loaded, system.mirror) if ssp else ())))
    if (inputs != "slip" or kind == "sti") and (note := with_lengths(loaded[0])[1]):
        terminal.print(f"note: {note}")
    terminal.print(*(f"note: {note}" for tire in loaded for note in limits_of(tire)))
    if proof.path:
        terminal.print(f"next: {command_text('check', written)}")
    else:
        terminal.print(f"next: {command_text('explore', tires[0], '-o', written.with_suffix('.html'))}")
    return 0
