"""Four tires in ecos: python run_ecospy.py [2|3]."""

from __future__ import annotations

import ctypes
import sys
import tempfile
from pathlib import Path

import four_tires as four
import numpy as np

# The library needs TBB, which pip installs outside of the search path of the system's loader.
for library in sorted(Path(sys.prefix, "lib").glob("libtbb.so.*")):
    ctypes.CDLL(str(library), mode=ctypes.RTLD_GLOBAL)
from ecospy import EcosSimulation, EcosSimulationStructure  # noqa: E402


def run(path: Path) -> four.FloatArray:
    """Return the forces at the end of each step, shape (steps, corners, outputs)."""
    rows = np.stack([four.manoeuvre(i)[list(four.INPUTS)].to_numpy() for i in range(len(four.CORNERS))], axis=1)
    forces = np.empty((four.STEPS, len(four.CORNERS), len(four.OUTPUTS)))
    with EcosSimulationStructure() as structure:
        for corner in four.CORNERS:
            structure.add_model(corner, path)
        # The initial slips are in steady state with the inputs at the end of initialization.
        names = [f"{corner}::{name}" for corner in four.CORNERS for name in four.INPUTS]
        structure.add_parameter_set("start", dict(zip(names, rows[0].ravel().tolist(), strict=True)))
        with EcosSimulation(structure=structure, step_size=four.STEP) as simulation:
            simulation.init(parameter_set="start")
            for step in range(four.STEPS):
                for name, value in zip(names, rows[step].ravel().tolist(), strict=True):
                    simulation.set_real(name, value)
                simulation.step()
                for i, corner in enumerate(four.CORNERS):
                    forces[step, i] = [simulation.get_real(f"{corner}::{name}") for name in four.OUTPUTS]
            simulation.terminate()
    return forces


if __name__ == "__main__":
    with tempfile.TemporaryDirectory() as name:
        fmi = four.requested_version()
        sys.exit(four.report(f"ecospy, FMI {fmi}", run(four.export(Path(name), fmi))))
