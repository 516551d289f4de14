"""One file, many readers: forces of a folder of .tir files by other programs, and how far they are from tirefmu's.

The files and programs are fetched by the user: the folder is the argument, `readers.py` has the variables of
the environment with the path of each program. A row has the largest difference of each force at 20 points, in percent
of its largest value: with side slip only, longitudinal slip only and both, all without camber, and both with camber.

    python benchmarks/readers_table.py FOLDER [--summary]
"""

from __future__ import annotations

import argparse
import contextlib
import io
import os
from collections import Counter
from collections.abc import Mapping
from pathlib import Path

import numpy as np
import pandas as pd
from readers import READERS, Reader

from tirefmu.boundary.errors import TirefmuError
from tirefmu.tires import read_tir

POINTS = 20
#: Inputs that are zero in each part of the table.
PARTS = {
    "side slip": ("kappa", "gamma"), "longitudinal": ("alpha", "gamma"), "combined": ("gamma",), "camber": (),
}  # fmt: skip
#: A difference up to here, relative to the largest force, is none.
EQUAL = 1e-6


def points(load: float, speed: float, zero: tuple[str, ...]) -> pd.DataFrame:
    """Return points up to 0.2 of slip, 3 deg of camber, and half to one and a half of the load."""
    rng = np.random.default_rng(1)
    ranges = {"kappa": (-0.2, 0.2), "alpha": (-0.2, 0.2), "gamma": (-0.05, 0.05), "Fz": (0.5 * load, 1.5 * load)}
    table = pd.DataFrame({name: rng.uniform(*ends, POINTS) for name, ends in ranges.items()})
    return table.assign(V=speed, **dict.fromkeys(zero, 0.0))


def differences(evaluate: Reader, path: Path, tables: Mapping[str, pd.DataFrame]) -> dict[tuple[str, str], float] | str:
    """Return the largest differences of a reader from tirefmu by part and force, or its last word."""
    tire, found = read_tir(path), {}
    for part, table in tables.items():
        expected = tire.evaluate(table)
        try:
            with contextlib.redirect_stdout(io.StringIO()), contextlib.redirect_stderr(io.StringIO()):
                forces = evaluate(path, table)
        except (Exception, SystemExit) as error:  # whatever a foreign program raises is its answer
            return f"no result: {' '.join(str(error).split())[-100:] or type(error).__name__}"
        for name in ("Fx", "Fy", "Mz"):
            if name in forces:
                size = float(np.abs(expected[name]).max())
                error = float(np.abs(forces[name] - expected[name]).max())
                found[part, name] = error / size if size else error
    return found


def written(found: dict[tuple[str, str], float] | str) -> str:
    """Return a line of the table."""
    if isinstance(found, str):
        return found
    cells = {
        part: [f"{name} {100 * error:.2g} %" for (of, name), error in found.items() if of == part] for part in PARTS
    }
    return "; ".join(f"{part}: {', '.join(texts)}" for part, texts in cells.items())


def main() -> None:
    """Print the table of a folder."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", type=Path)
    parser.add_argument("--summary", action="store_true", help="print how many files agree, not each file")
    arguments = parser.parse_args()
    files = sorted(arguments.folder.glob("*.tir"))
    present = {name: reader for name, (variable, reader) in READERS.items() if os.environ.get(variable)}
    print(f"{len(files)} files; readers: {', '.join(['tirefmu', *present])}")
    counts: dict[str, Counter[str]] = {name: Counter() for name in present}
    for path in files:
        try:
            tire = read_tir(path)
        except TirefmuError as error:
            print(f"{path.name}: tirefmu refuses it: {error}")
            continue
        tables = {part: points(tire.values["FNOMIN"], tire.values["LONGVL"], zero) for part, zero in PARTS.items()}
        if not arguments.summary:
            print(f"{path.name} ({tire.model})")
        for name, evaluate in present.items():
            found = differences(evaluate, path, tables)
            counts[name].update(["no result"] if isinstance(found, str) else ["read"])
            if not isinstance(found, str):
                counts[name].update(f"{part} {force}" for (part, force), error in found.items() if error <= EQUAL)
            if not arguments.summary:
                print(f"  {name}: {written(found)}", flush=True)
    for name, count in counts.items():
        equal = ", ".join(
            f"{part} {force} {count[f'{part} {force}']}" for part in PARTS for force in ("Fx", "Fy", "Mz")
        )
        print(f"{name}: reads {count['read']}, does not read {count['no result']}; equal within {EQUAL:g}: {equal}")


if __name__ == "__main__":
    main()
