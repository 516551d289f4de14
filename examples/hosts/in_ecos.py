"""An FMU in ecos: steps are counted, because its times are sums."""

import ctypes
import json
import sys
from pathlib import Path

for library in Path(sys.prefix, "lib").glob("libtbb.so.*"):  # pip installs it beside the search path
    ctypes.CDLL(str(library), mode=ctypes.RTLD_GLOBAL)
from ecospy import EcosSimulation, EcosSimulationStructure  # noqa: E402

path, inputs, outputs = sys.argv[1], json.loads(sys.argv[3]), sys.argv[4].split(",")
with EcosSimulationStructure() as structure:
    structure.add_model("tire", path)
    structure.add_parameter_set("start", {f"tire::{name}": float(value) for name, value in inputs.items()})
    with EcosSimulation(structure=structure, step_size=0.001) as simulation:
        simulation.init(parameter_set="start")
        for _ in range(1000):
            simulation.step()
        print(json.dumps({name: simulation.get_real(f"tire::{name}") for name in outputs}))
