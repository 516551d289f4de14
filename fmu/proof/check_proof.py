"""Repeat the proof of an FMU with FMPy and NumPy only: python check_proof.py my.fmu."""

import csv
import hashlib
import json
import sys
from pathlib import Path
from typing import Any

import fmpy
import numpy as np

PROOF = "extra/org.fmi-standard.fmi-ls-ref/proof.json"


def main(fmu: str) -> str:  # noqa: D103
    folder = Path(fmpy.extract(fmu))
    files = {f.relative_to(folder).as_posix(): f.read_bytes() for f in folder.rglob("*") if f.is_file()}
    digests = {name: hashlib.sha256(content).hexdigest() for name, content in files.items()}
    proof, digest = json.loads(files[PROOF]), digests.pop(PROOF)
    if changed := {name for name, _ in digests.items() ^ proof["files"].items()}:
        sys.exit(f"proof failed: changed files: {', '.join(sorted(changed))}")
    tables = [list(csv.reader((folder / PROOF).with_name(f"{n}.csv").open())) for n in ("stimuli", "reference")]
    (time, *stimuli), (_, *reference) = (np.array(rows[1:], dtype=float).T for rows in tables)
    worst = np.abs((simulated(folder, time, stimuli, tables, proof) - reference) / (1 + np.abs(reference))).max()
    if not worst <= proof["tolerance"]:
        sys.exit(f"proof failed: difference {worst:.1e}")
    return f"proof passed: {len(time)} rows, difference {worst:.1e}; digest of the proof {digest}"


def simulated(folder: Path, time: Any, stimuli: Any, tables: Any, proof: Any) -> Any:  # noqa: D103
    description = fmpy.read_model_description(str(folder))
    references = {v.name: v.valueReference for v in description.modelVariables}
    inputs, outputs = ([references[name] for name in rows[0][1:]] for rows in tables)
    fmu, old = fmpy.instantiate_fmu(str(folder), description, "CoSimulation"), description.fmiVersion.startswith("2")
    write, read, results = *((fmu.setReal, fmu.getReal) if old else (fmu.setFloat64, fmu.getFloat64)), []
    for i, (now, *values) in enumerate(zip(time, *stimuli, strict=True)):
        if i in proof["segments"]:
            fmu.reset()
            begin = fmu.setupExperiment if old else fmu.enterInitializationMode
            begin(startTime=now)
            if old:
                fmu.enterInitializationMode()
        elif now > time[i - 1]:
            fmu.doStep(currentCommunicationPoint=time[i - 1], communicationStepSize=now - time[i - 1])
        write(inputs, values)
        if i in proof["segments"]:
            fmu.exitInitializationMode()
        results.append(read(outputs))
    return np.array(results).T


if __name__ == "__main__":
    print(main(sys.argv[1]))
