"""Proofs of FMUs of every model, version and kind of inputs: repeated by FMPy alone, and what a change does to them.

    python benchmarks/proofs.py [--python PYTHON]

`--python`: an interpreter with FMPy and NumPy, which runs the program inside each FMU; by default this one. Each FMU is
changed in four ways: a bit of the binary at a random place, a coefficient of the tire file, a start value of the model
description, and a number of the stimuli. The table of docs/proof.md has the result.
"""

from __future__ import annotations

import argparse
import json
import re
import subprocess
import sys
import tempfile
import zipfile
from pathlib import Path

import numpy as np
import pandas as pd
from languages import tires_of_models

from tirefmu.fmu import add_proof, export, repeat_proof
from tirefmu.fmu.comparison.compared import EVALUATION_TOLERANCE as TOLERANCE
from tirefmu.fmu.simulation.archive import unpacked
from tirefmu.fmu.simulation.simulate import simulate
from tirefmu.symbolic.wheel.quantities import CARRIER, CONTACT_FORCES, ROAD, SPIN
from tirefmu.tires import Tire
from tirefmu.tires.hub import hub_wrench, wheel_motion

FOLDER = "extra/org.fmi-standard.fmi-ls-ref/"
STIMULI, REFERENCE, PROOF = (FOLDER + name for name in ("stimuli.csv", "reference.csv", "proof.json"))
LAGGED, CONTACT = ("kappa_lagged", "alpha_lagged"), tuple(quantity.name for quantity in CONTACT_FORCES)
MOVED = tuple(quantity.name for quantity in (*CARRIER, *ROAD, SPIN))
#: A file of an FMU, and the number in it that is changed.
NUMBERS = {
    "resources/tire.tir": rb"(?m)^P[A-Z0-9]+ *= *-?(\d)|^(?:CALPHA|CSLIP) *= *-?(\d)",
    "modelDescription.xml": rb'start="-?(\d)',
    STIMULI: rb"\n-?(\d)",
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


def direct_difference(fmu: Path, tire: Tire) -> float:
    """Return how far the reference of a proof with hub inputs is from NumPy, as a share of 1 + |value|.

    NumPy computes the motion of the wheel from the stimuli, the forces of the tire at the load and the lagged slips of
    the FMU, and the forces at the hub. Its functions are printed from the same equations by another printer.
    """
    with zipfile.ZipFile(fmu) as archive:
        driven, reference = (pd.read_csv(archive.open(name)) for name in (STIMULI, REFERENCE))
        first = json.loads(archive.read(PROOF))["segments"]
    time, given = driven.pop("time").to_numpy(), driven.to_dict("series")
    runs = [slice(begin, end) for begin, end in zip(first, [*first[1:], len(time)], strict=True)]
    with unpacked(fmu) as folder:
        lagged = simulate(fmu, folder, time, driven.to_numpy(), list(driven), list(LAGGED), runs).outputs.T
    motion = wheel_motion(**{name: values for name, values in given.items() if name in MOVED})
    slips = dict(zip(("kappa", "alpha"), lagged, strict=True))
    at = {**given, **slips, "V": reference["V_x"], "gamma": reference["gamma"], "Fz": reference["Fz"]}
    forces = tire.in_signs("iso").forces(**{name: at[name] for name in tire.inputs if name in at})
    turned = {name: values for name, values in given.items() if name.startswith("R_")}
    contact = {name: reference[name] for name in CONTACT if name in reference}
    wrench = hub_wrench(**contact, **turned, R_l=reference["R_l"])
    computed = {name: values for name, values in {**motion, **forces, **wrench}.items() if name in reference}
    return max(float(np.max(np.abs(v - reference[n]) / (1.0 + np.abs(reference[n])))) for n, v in computed.items())


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
    repeated = agreeing = detected = changes = total = 0
    print("model  fmi inputs  difference, tirefmu  from NumPy  program inside")
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        fmu, program, other = folder / "tire.fmu", folder / "check_proof.py", folder / "changed.fmu"
        for model, tire in tires_of_models().items():
            for fmi, inputs in ((2, "slip"), (2, "hub"), (3, "slip"), (3, "hub")):
                add_proof(export(tire, fmu, fmi=fmi, inputs=inputs), recording(tire, rng))
                with zipfile.ZipFile(fmu) as archive:
                    files = {entry: archive.read(entry) for entry in archive.namelist()}
                program.write_bytes(files["documentation/check_proof.py"])
                run = subprocess.run([python, program, fmu], capture_output=True, text=True, cwd=folder, check=False)
                result = repeat_proof(fmu)
                total += 1
                repeated += result.ok and run.returncode == 0
                printed = (run.stdout + run.stderr).strip().splitlines()[-1].partition(";")[0]
                direct = direct_difference(fmu, tire) if inputs == "hub" else result.difference
                agreeing += direct <= TOLERANCE
                print(
                    f"{model:<6} {fmi}   {inputs:<6} {result.difference:<20.1e} {direct:<11.1e} {printed}", flush=True
                )
                for variant in changed(files, rng).values():
                    with zipfile.ZipFile(other, "w") as archive:
                        for entry, content in variant.items():
                            archive.writestr(entry, content)
                    run = subprocess.run([python, program, other], capture_output=True, cwd=folder, check=False)
                    changes += 1
                    detected += run.returncode == 1 and not repeat_proof(other).ok
    print(f"{repeated} of {total} proofs repeated by both programs; {detected} of {changes} changes detected by both")
    print(f"{agreeing} of {total} references within {TOLERANCE:g} of direct evaluation by NumPy")
    return 0 if (repeated, agreeing, detected) == (total, total, changes) else 1


if __name__ == "__main__":
    sys.exit(main())
