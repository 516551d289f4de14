"""FMUs in ecos: steps are counted, because its times are sums."""

import ctypes
import json
import sys
from pathlib import Path

for library in Path(sys.prefix, "lib").glob("libtbb.so.*"):  # pip installs it beside the search path
    ctypes.CDLL(str(library), mode=ctypes.RTLD_GLOBAL)
from ecospy import EcosSimulation, EcosSimulationStructure  # noqa: E402

tires, outputs = json.loads(sys.argv[1]), sys.argv[3].split(",")
with EcosSimulationStructure() as structure:
    for name, (path, _) in tires.items():
        structure.add_model(name, path)
    starts = {f"{tire}::{name}": float(value) for tire in tires for name, value in tires[tire][1].items()}
    structure.add_parameter_set("start", starts)
    with EcosSimulation(structure=structure, step_size=0.001) as simulation:
        simulation.init(parameter_set="start")
        for _ in range(1000):
            simulation.step()
        print(json.dumps({t: {name: simulation.get_real(f"{t}::{name}") for name in outputs} for t in tires}))
