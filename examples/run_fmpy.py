"""Four tires in fmpy: python run_fmpy.py [2|3]."""

from __future__ import annotations

import shutil
import sys
import tempfile
from pathlib import Path

import fmpy
import four_tires as four
import numpy as np
from fmpy.fmi2 import FMU2Slave
from fmpy.fmi3 import FMU3Slave


def run(path: Path) -> four.FloatArray:
    """Return the forces at the end of each step, shape (steps, corners, outputs)."""
    description = fmpy.read_model_description(str(path))
    references = {variable.name: variable.valueReference for variable in description.modelVariables}
    inputs, outputs = ([references[name] for name in names] for names in (four.INPUTS, four.OUTPUTS))
    kind = FMU3Slave if description.fmiVersion.startswith("3") else FMU2Slave
    folder = fmpy.extract(str(path))
    identifier = description.coSimulation.modelIdentifier
    tires = [
        kind(guid=description.guid, unzipDirectory=folder, modelIdentifier=identifier, instanceName=corner)
        for corner in four.CORNERS
    ]
    rows = np.stack([four.manoeuvre(i)[list(four.INPUTS)].to_numpy() for i in range(len(tires))], axis=1)
    forces = np.empty((four.STEPS, len(tires), len(outputs)))
    for tire, first in zip(tires, rows[0], strict=True):
        tire.instantiate()
        if kind is FMU2Slave:
            tire.setupExperiment(startTime=0.0)
        tire.enterInitializationMode()
        _set(tire, inputs, first)
        tire.exitInitializationMode()
    for step in range(four.STEPS):
        for corner, tire in enumerate(tires):
            _set(tire, inputs, rows[step, corner])
            tire.doStep(step * four.STEP, four.STEP)
            forces[step, corner] = (tire.getFloat64 if kind is FMU3Slave else tire.getReal)(outputs)
    for tire in tires:
        tire.terminate()
        tire.freeInstance()
    shutil.rmtree(folder, ignore_errors=True)
    return forces


def _set(tire: FMU2Slave | FMU3Slave, references: list[int], values: four.FloatArray) -> None:
    (tire.setFloat64 if isinstance(tire, FMU3Slave) else tire.setReal)(references, values.tolist())


if __name__ == "__main__":
    with tempfile.TemporaryDirectory() as name:
        fmi = four.requested_version()
        sys.exit(four.report(f"fmpy, FMI {fmi}", run(four.export(Path(name), fmi))))
