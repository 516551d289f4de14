"""Files of FMUs, and hosts in C that are linked with the sources of an FMU, for tests and benchmarks/step_times.py."""

from __future__ import annotations

import re
import subprocess
import zipfile
from collections.abc import Mapping, Sequence
from pathlib import Path

from tirefmu.fmu.description.interface import interface
from tirefmu.fmu.packaging.export import contents, fmi_headers
from tirefmu.tires import Tire

HERE = Path(__file__).parent
#: Limits of the inputs in random steps of a hub; the height is relative to the free radius.
LIMITS = {
    "r_z": (0.85, 1.02), "R_32": (-0.1, 0.1), "v_x": (-10.0, 60.0), "v_y": (-3.0, 3.0), "v_z": (-0.5, 0.5),
    "w_z": (-1.0, 1.0), "omega": (-20.0, 150.0), "T_drive": (-300.0, 300.0), "T_brake": (0.0, 500.0),
    "road_mu": (0.1, 1.2),
}  # fmt: skip


def unzipped(path: Path) -> dict[str, bytes]:
    """Return the files of an archive."""
    with zipfile.ZipFile(path) as archive:
        return {name: archive.read(name) for name in archive.namelist()}


def zipped(path: Path, files: Mapping[str, bytes | str]) -> Path:
    """Write an archive and return its path."""
    with zipfile.ZipFile(path, "w") as archive:
        for name, content in files.items():
            archive.writestr(name, content)
    return path


def sources_of(files: Mapping[str, bytes]) -> dict[str, bytes]:
    """Return the C files and headers among the files of an FMU."""
    return {name.removeprefix("sources/"): text for name, text in files.items() if name.startswith("sources/")}


def token_of(files: Mapping[str, bytes]) -> str:
    """Return the token of the model description among the files of an FMU."""
    (token,) = re.findall(rb'(?:guid|instantiationToken)="([^"]+)"', files["modelDescription.xml"])
    return str(token.decode())


def linked(
    compiler: Sequence[str],
    folder: Path,
    host: str,
    sources: Mapping[str, bytes],
    *flags: str,
    ready: Mapping[str, Path] | None = None,
) -> Path:
    """Return the program of a host in C (a file beside this one), linked with the sources of an FMU.

    `ready`: objects of files that are compiled already.
    """
    for name, text in sources.items():
        (folder / name).write_bytes(text)
    code = [str(folder / name) for name in sources if name.endswith(".c") and name not in (ready or {})]
    objects = [str(path) for path in (ready or {}).values()]
    program = folder / "program"
    includes = [f"-I{folder}", f"-I{fmi_headers()}"]
    command = [*compiler, "-std=gnu99", "-O0", *flags, *includes, str(HERE / host), *code, *objects, "-o", str(program)]
    built = subprocess.run([*command, "-lm", "-lpthread"], capture_output=True, text=True, check=False)
    assert built.returncode == 0, built.stderr
    return program


def random_steps(
    compiler: Sequence[str], folder: Path, tire: Tire, inputs: str, steps: int, *flags: str
) -> dict[str, float]:
    """Run steps of 1 ms with random motions of a hub, from reverse to 60 m/s, and return what `steps.c` prints."""
    files = contents(tire, 3, "tire", inputs=inputs)
    program = linked(compiler, folder, "steps.c", sources_of(files), *flags)
    listed = {v.name: (i, v.causality) for i, v in enumerate(interface(tire, inputs=inputs).variables)}
    size = {"r_z": tire.values["UNLOADED_RADIUS"]}
    moved = [
        f"{listed[name][0]}:{low * size.get(name, 1.0)!r}:{high * size.get(name, 1.0)!r}"
        for name, (low, high) in LIMITS.items()
        if listed.get(name, (0, ""))[1] == "input"
    ]
    command = [str(program), token_of(files), str(steps), str(listed["F_x"][0]), *moved]
    done = subprocess.run(command, capture_output=True, text=True, check=True)
    names = ("median", "high", "longest", "allocations before", "allocations", "largest force")
    return dict(zip(names, map(float, done.stdout.split()), strict=True))


#: Limits of slips and load.
SLIPS = {"kappa": (-1.0, 1.0), "alpha": (-1.2, 1.2), "gamma": (-0.1, 0.1), "Fz": (-500.0, 9000.0), "V": (-10.0, 50.0)}


def moving_inputs(tire: Tire, listed: dict[str, tuple[int, str]]) -> list[str]:
    """Return the inputs of other_processor.c with their limits: beyond what a tire knows, and in reverse."""
    size = {"r_z": tire.values["UNLOADED_RADIUS"]}
    return [
        f"{listed[name][0]}:{low * size.get(name, 1.0)!r}:{high * size.get(name, 1.0)!r}"
        for name, (low, high) in (LIMITS | SLIPS).items()
        if listed.get(name, (0, ""))[1] == "input"
    ]
