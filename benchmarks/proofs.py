"""Proofs of FMUs of every model, version and kind of inputs: repeated by FMPy alone, and what a change does to them.

    python benchmarks/proofs.py [--python PYTHON]

`--python`: an interpreter with FMPy and NumPy, which runs the program inside each FMU; by default this one. Each FMU is
changed in four ways: a bit of the binary at a random place, a coefficient of the tire file, a start value of the model
description, and a number of the stimuli. The table of docs/proof.md has the result.
"""

from __future__ import annotations

import argparse
import re
import subprocess
import sys
import tempfile
import zipfile
from pathlib import Path

import numpy as np
import pandas as pd
from languages import BRUSH, FIALA

from tirefmu.fmu import add_proof, export, repeat_proof
from tirefmu.symbolic.models import MODELS
from tirefmu.tires import Tire, published, read_tir

ROOT = Path(__file__).parents[1]
STIMULI = "extra/org.fmi-standard.fmi-ls-ref/stimuli.csv"
#: A file of an FMU, and the number in it that is changed.
NUMBERS = {
    "resources/tire.tir": rb"(?m)^P[A-Z0-9]+ *= *-?(\d)|^(?:CALPHA|CSLIP) *= *-?(\d)",
    "modelDescription.xml": rb'start="-?(\d)',
    STIMULI: rb"\n-?(\d)",
}


def tires() -> dict[str, Tire]:
    """Return a tire of every model."""
    golden = {f"mf{v}": read_tir(ROOT / f"tests/golden/MagicFormula{v}_Parameters.tir") for v in (52, 61, 62)}
    return {
        "mf96": published("trento_hoosier"),
        **golden,
        "fiala": Tire("fiala", FIALA),
        "brush": Tire("brush", BRUSH),
    }


def recording(tire: Tire, rng: np.random.Generator) -> pd.DataFrame:
    """Return 600 rows in two segments that cover slips, camber and loads up to 1.5 times the nominal one."""
    n, load = 300, tire.values["FNOMIN"]
    t = np.r_[0.02 * np.arange(n), 50.0 + 0.02 * np.arange(n)]
    sweeps = {name: rng.uniform(0.2, 2.0) for name in ("kappa", "alpha", "gamma", "Fz")}
    wave = {name: np.sin(rate * t) for name, rate in sweeps.items()}
    return pd.DataFrame(
        {"t": t, "kappa": 0.1 * wave["kappa"], "alpha": 0.15 * wave["alpha"], "gamma": 0.04 * wave["gamma"],
         "Fz": load * (1.0 + 0.5 * wave["Fz"]), "V": 15.0}
    )  # fmt: skip


def changed(files: dict[str, bytes], rng: np.random.Generator) -> dict[str, dict[str, bytes]]:
    """Return the files of an FMU after each change."""
    binary = next(name for name in files if name.startswith("binaries/"))
    content = bytearray(files[binary])
    content[rng.integers(len(content))] ^= 1 << int(rng.integers(8))
    variants = {binary: {**files, binary: bytes(content)}}
    for name, pattern in NUMBERS.items():
        match = re.search(pattern, files[name])
        assert match is not None
        assert match.lastindex is not None
        place = match.start(match.lastindex)
        digit = b"%d" % ((int(match[match.lastindex]) + 1) % 10)
        variants[name] = {**files, name: files[name][:place] + digit + files[name][place + 1 :]}
    return variants


def main() -> int:
    """Write a line for each FMU; return 1 if a proof fails or a change is not detected."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--python", default=sys.executable)
    python, rng = parser.parse_args().python, np.random.default_rng(40)
    repeated = detected = changes = total = 0
    print("model  fmi inputs  difference, tirefmu  program inside")
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        fmu, program, other = folder / "tire.fmu", folder / "check_proof.py", folder / "changed.fmu"
        for model, tire in tires().items():
            assert model in MODELS
            for fmi, inputs in ((2, "slip"), (2, "hub"), (3, "slip"), (3, "hub")):
                add_proof(export(tire, fmu, fmi=fmi, inputs=inputs), recording(tire, rng))
                with zipfile.ZipFile(fmu) as archive:
                    files = {entry: archive.read(entry) for entry in archive.namelist()}
                program.write_bytes(files["documentation/check_proof.py"])
                run = subprocess.run([python, program, fmu], capture_output=True, text=True, cwd=folder, check=False)
                result = repeat_proof(fmu)
                total += 1
                repeated += result.ok and run.returncode == 0
                said = (run.stdout + run.stderr).strip().splitlines()[-1].partition(";")[0]
                print(f"{model:<6} {fmi}   {inputs:<6} {result.difference:<20.1e} {said}", flush=True)
                for variant in changed(files, rng).values():
                    with zipfile.ZipFile(other, "w") as archive:
                        for entry, content in variant.items():
                            archive.writestr(entry, content)
                    run = subprocess.run([python, program, other], capture_output=True, cwd=folder, check=False)
                    changes += 1
                    detected += run.returncode == 1 and not repeat_proof(other).ok
    print(f"{repeated} of {total} proofs repeated by both programs; {detected} of {changes} changes detected by both")
    return 0 if (repeated, detected) == (total, changes) else 1


if __name__ == "__main__":
    sys.exit(main())
