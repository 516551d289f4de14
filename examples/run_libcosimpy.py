"""Four tires in libcosim, the Open Simulation Platform's library, which reads FMI 2: python run_libcosimpy.py."""

from __future__ import annotations

import sys
import tempfile
from pathlib import Path

import four_tires as four
import numpy as np
from libcosimpy.CosimExecution import CosimExecution
from libcosimpy.CosimManipulator import CosimManipulator
from libcosimpy.CosimObserver import CosimObserver
from libcosimpy.CosimSlave import CosimLocalSlave


def run(path: Path) -> four.FloatArray:
    """Return the forces at the end of each step, shape (steps, corners, outputs)."""
    execution = CosimExecution.from_step_size(round(1e9 * four.STEP))
    setter, observer = CosimManipulator.create_override(), CosimObserver.create_last_value()
    execution.add_manipulator(setter)
    execution.add_observer(observer)
    tires = [execution.add_local_slave(CosimLocalSlave(str(path), corner)) for corner in four.CORNERS]
    references = {variable.name.decode(): variable.reference for variable in execution.slave_variables(tires[0])}
    inputs, outputs = ([references[name] for name in names] for names in (four.INPUTS, four.OUTPUTS))
    rows = np.stack([four.manoeuvre(i)[list(four.INPUTS)].to_numpy() for i in range(len(tires))], axis=1)
    for corner, tire in enumerate(tires):
        # The initial slips are in steady state with the inputs at the end of initialization.
        for reference, value in zip(inputs, rows[0, corner], strict=True):
            execution.real_initial_value(tire, reference, value)
    forces = np.empty((four.STEPS, len(tires), len(outputs)))
    for step in range(four.STEPS):
        for corner, tire in enumerate(tires):
            setter.slave_real_values(tire, inputs, rows[step, corner].tolist())
        if not execution.step():
            raise RuntimeError(f"libcosim failed at step {step}")
        for corner, tire in enumerate(tires):
            forces[step, corner] = observer.last_real_values(tire, outputs)
    return forces


if __name__ == "__main__":
    with tempfile.TemporaryDirectory() as name:
        sys.exit(four.report("libcosimpy, FMI 2", run(four.export(Path(name), 2))))
