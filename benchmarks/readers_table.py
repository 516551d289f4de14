"""One file, many readers: forces of a folder of .tir files by other programs, and how far they are from tirefmu's.

The files and programs are fetched by whoever runs this: the folder is the argument, and each program whose path is in
the environment takes part. TIREFMU_MFEVAL is the folder above `+mfeval` of MFeval (run in Octave), TIREFMU_OPENTIRE the
folder `code` of OpenTirePython, TIREFMU_MFPY the folder above `mfpy` of MFPy. At 20 points each a row says the largest
difference of a force over the largest force, or why there is none; the letters say for which kind of slip.

    python benchmarks/readers_table.py FOLDER
"""

from __future__ import annotations

import argparse
import contextlib
import io
import os
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Callable, Mapping
from importlib import import_module
from pathlib import Path

import numpy as np
import pandas as pd

from tirefmu.boundary.errors import TirefmuError
from tirefmu.tires import read_tir

#: Forces by name; a reader without one of them leaves it out.
Forces = Mapping[str, np.ndarray]
POINTS = 20
#: Functions of MATLAB that MFeval calls and Octave lacks, by file.
MATLAB_FUNCTIONS = {
    "contains.m": "function found = contains(text, part)\n  found = ! isempty(strfind(text, part));\nend\n",
    "+coder/extrinsic.m": "function extrinsic(name)\nend\n",
}
#: Slips that are zero in each part of the table.
PARTS = {"side slip": "kappa", "longitudinal": "alpha", "combined": None}


def points(load: float, speed: float, zero: str | None) -> pd.DataFrame:
    """Return points up to 0.2 of slip, 3 deg of camber, and half to one and a half of the load."""
    rng = np.random.default_rng(1)
    ranges = {"kappa": (-0.2, 0.2), "alpha": (-0.2, 0.2), "gamma": (-0.05, 0.05), "Fz": (0.5 * load, 1.5 * load)}
    table = pd.DataFrame({name: rng.uniform(*ends, POINTS) for name, ends in ranges.items()})
    return table.assign(V=speed, **({zero: 0.0} if zero else {}))


def mfeval(path: Path, table: pd.DataFrame) -> Forces:
    """Evaluate with MFeval in Octave: combined slip, alpha* = tan(alpha), without limits."""
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        (folder / "+coder").mkdir()
        for file, text in MATLAB_FUNCTIONS.items():
            (folder / file).write_text(text)
        shutil.copy(path, folder / "tire.tir")
        inputs = table.assign(phit=0.0)[["Fz", "kappa", "alpha", "gamma", "phit", "V"]]
        np.savetxt(folder / "rows.txt", inputs.to_numpy(), fmt="%.17g")
        (folder / "evaluate_rows.m").write_text(
            f"addpath('{os.environ['TIREFMU_MFEVAL']}'); warning('off', 'all'); solver = mfeval.Solver();\n"
            "found = solver.fullSteadyState(mfeval.readTIR('tire.tir'), dlmread('rows.txt'), 221);\n"
            "printf('%.17g %.17g %.17g\\n', found(:, [1 2 6])');\n"
        )
        done = subprocess.run(
            ["octave-cli", "--norc", "--no-history", "--quiet", "evaluate_rows.m"],
            cwd=folder, capture_output=True, text=True, timeout=120, check=False,
        )  # fmt: skip
    if done.returncode:
        raise ValueError(done.stderr)
    columns = np.array([line.split() for line in done.stdout.splitlines()], dtype=float).T
    return dict(zip(("Fx", "Fy", "Mz"), columns, strict=True))


def mfeval_with_crlf(path: Path, table: pd.DataFrame) -> Forces:
    """Evaluate with MFeval a copy of the file that has the line ends which its older readers expect."""
    with tempfile.TemporaryDirectory() as name:
        copy = Path(name) / path.name
        copy.write_bytes(b"\r\n".join(path.read_bytes().splitlines()) + b"\r\n")
        return mfeval(copy, table)


def opentire(path: Path, table: pd.DataFrame) -> Forces:
    """Evaluate with OpenTirePython."""
    reader, state = import_module("opentire.Core.TIRFile"), import_module("opentire.Core.tirestate")
    model = reader.TIRFile().load(str(path))
    columns: dict[str, list[float]] = {"Fx": [], "Fy": [], "Mz": []}
    for row in table.to_dict("records"):
        now = state.TireState()
        names = {"SR": "kappa", "SA": "alpha", "IA": "gamma", "FZ": "Fz", "V": "V"}
        now.update({theirs: float(row[ours]) for theirs, ours in names.items()})
        for name, forces in columns.items():
            now[name.upper()] = getattr(model, f"calculate_{name.lower()}")(now)
            forces.append(now[name.upper()])
    return {name: np.array(forces) for name, forces in columns.items()}


def mfpy(path: Path, table: pd.DataFrame) -> Forces:
    """Evaluate with MFPy, with the tangent of the slip angle as in the book."""
    tire = import_module("mfpy.preprocess").preprocessing.read_tir(str(path))
    rows = [table[name].to_numpy() for name in ("alpha", "kappa", "gamma", "Fz", "V")]
    found = import_module("mfpy.solve").solve(rows, tire, star_correction=True)
    return {"Fx": np.asarray(found.FX), "Fy": np.asarray(found.FY), "Mz": np.asarray(found.MZ)}


READERS: dict[str, tuple[str, Callable[[Path, pd.DataFrame], Forces]]] = {
    "MFeval": ("TIREFMU_MFEVAL", mfeval),
    "MFeval, CRLF": ("TIREFMU_MFEVAL", mfeval_with_crlf),
    "OpenTirePython": ("TIREFMU_OPENTIRE", opentire),
    "MFPy": ("TIREFMU_MFPY", mfpy),
}


def compared(evaluate: Callable[[Path, pd.DataFrame], Forces], path: Path, tables: Mapping[str, pd.DataFrame]) -> str:
    """Return the largest differences of a reader from tirefmu by part, or its last word."""
    tire, cells = read_tir(path), []
    for part, table in tables.items():
        expected = tire.evaluate(table)
        try:
            with contextlib.redirect_stdout(io.StringIO()):
                forces = evaluate(path, table)
        except Exception as error:  # whatever a foreign program raises is its answer
            return f"no result: {' '.join(str(error).split())[-100:] or type(error).__name__}"
        sizes = {name: float(np.abs(expected[name]).max()) for name in forces}
        errors = {
            name: float(np.abs(values - expected[name]).max() / sizes[name]) if sizes[name] else 0.0
            for name, values in forces.items()
        }
        cells.append(f"{part}: " + " ".join(f"{name} {100 * error:.2g} %" for name, error in errors.items()))
    return "; ".join(cells)


def main() -> None:
    """Print the table of a folder."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", type=Path)
    files = sorted(parser.parse_args().folder.glob("*.tir"))
    present = {name: reader for name, (variable, reader) in READERS.items() if os.environ.get(variable)}
    sys.path += [os.environ[variable] for variable, _ in READERS.values() if os.environ.get(variable)]
    print(f"{len(files)} files; readers: {', '.join(['tirefmu', *present])}")
    for path in files:
        try:
            tire = read_tir(path)
        except TirefmuError as error:
            print(f"{path.name}: tirefmu refuses it: {error}")
            continue
        tables = {part: points(tire.values["FNOMIN"], tire.values["LONGVL"], zero) for part, zero in PARTS.items()}
        print(f"{path.name} ({tire.model})")
        for name, evaluate in present.items():
            print(f"  {name}: {compared(evaluate, path, tables)}", flush=True)


if __name__ == "__main__":
    main()
