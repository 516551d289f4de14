"""Many tires and long runs of FMUs: bytes per instance and per step, time of a step, states restored at random, copies.

    python benchmarks/many_tires.py [--steps 1000000] [--instances 1000] [--other FOLDER]

The tire is MFeval's example of MF6.1 (tests/golden) with relaxation. FOLDER has FMUs wheel.fmu, hub.fmu, hub-torque.fmu
of the same tire from another version, whose steps are measured in turns with those of this one; `--keep FOLDER` writes
them.
"""

from __future__ import annotations

import argparse
import json
import re
import shutil
import subprocess
import tempfile
import zipfile
from pathlib import Path

import tirefmu
from tirefmu.fmu.packaging.export import fmi_headers
from tirefmu.symbolic.models import MODELS
from tirefmu.tires import Tire
from tirefmu.tires.code.compiler import find_compiler

ROOT = Path(__file__).parents[1]
KINDS = ("wheel", "hub", "hub-torque")


def tire() -> Tire:
    """Return the tire."""
    (path,) = (ROOT / "tests" / "golden").glob("mf61_*_params.json")
    model = MODELS["mf61"]
    values = {k: v for k, v in json.loads(path.read_text(encoding="utf-8")).items() if k in model.coefficients}
    effects = model.default_effects | {"relax_lon", "relax_lat"}
    return Tire("mf61", {**values, "SIGX": 0.2, "SIGY": 0.5}, effects=effects, name="mf61")


def library(fmu: Path, folder: Path) -> tuple[Path, str, dict[str, tuple[int, float]]]:
    """Return the library of an FMU, its token, and the references and start values of its variables."""
    with zipfile.ZipFile(fmu) as archive:
        (binary,) = (name for name in archive.namelist() if name.endswith((".so", ".dylib")))
        path = Path(archive.extract(binary, folder))
        text = archive.read("modelDescription.xml").decode()
    token = re.search('instantiationToken="([^"]*)"', text)
    variables = {}
    for element in re.findall("<Float64 [^>]*>", text):
        about = dict(re.findall(r'(\w+)="([^"]*)"', element))
        variables[about["name"]] = (int(about["valueReference"]), float(about.get("start", 0.0)))
    return path, token[1] if token else "", variables


def limits(variables: dict[str, tuple[int, float]]) -> list[str]:
    """Return references and limits of the inputs that move."""
    load = tire().nominal("Fz")
    moves = {"V_x": (15.0, 25.0), "V_y": (-1.0, 1.0), "Fz": (0.5 * load, 1.5 * load)}
    if "r_z" in variables:
        height = variables["r_z"][1]
        moves = {"v_x": (15.0, 25.0), "v_y": (-1.0, 1.0), "r_z": (height - 0.01, height + 0.005)}
    moves |= {"T_drive": (-300.0, 300.0)} if "T_drive" in variables else {"omega": (45.0, 65.0)}
    return [f"{variables[name][0]}:{low}:{high}" for name, (low, high) in moves.items()]


def main() -> None:
    """Print the measurements of each kind of inputs."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("--steps", type=int, default=1_000_000)
    parser.add_argument("--instances", type=int, default=1000)
    parser.add_argument("--other", type=Path, help="folder with FMUs of another version")
    parser.add_argument("--keep", type=Path, help="folder into which the FMUs are written")
    given = parser.parse_args()
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        program = folder / "many_tires"
        command = [*find_compiler(), "-O2", "-I", str(fmi_headers()), str(ROOT / "benchmarks" / "many_tires.c")]
        subprocess.run([*command, "-o", str(program), "-lm", "-ldl"], check=True)
        for kind in KINDS:
            fmu = tirefmu.export(tire(), (given.keep or folder) / f"{kind}.fmu", inputs=kind, fmi=3)
            path, token, variables = library(fmu, folder / kind)
            other = library((given.other or fmu.parent) / fmu.name, folder / "other" / kind)
            copy = shutil.copy(path, folder / f"{kind}_copy.so")
            numbers = [str(given.instances), str(given.steps), str(variables["Fx"][0])]
            arguments = [str(path), token, str(other[0]), other[1], str(copy), *numbers, *limits(variables)]
            done = subprocess.run([str(program), *arguments], check=True, capture_output=True, text=True)
            print(kind, *done.stdout.splitlines(), sep=", ", flush=True)


if __name__ == "__main__":
    main()
