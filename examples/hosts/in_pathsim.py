"""An FMU in PathSim: every input is a port, and one that is not connected is 0, so that all get constants."""

import json
import sys

from fmpy import read_model_description
from pathsim import Connection, Simulation
from pathsim.blocks import Constant
from pathsim_fmi import CoSimulationFMU, ModelExchangeFMU

path, kind, inputs, outputs = sys.argv[1], sys.argv[2], json.loads(sys.argv[3]), sys.argv[4].split(",")
starts = {v.name: float(v.start) for v in read_model_description(path).modelVariables if v.causality == "input"}
exchanges = kind == "ModelExchange"
tire = ModelExchangeFMU(path) if exchanges else CoSimulationFMU(path, dt=0.001)
constants = [Constant(value) for value in (starts | inputs).values()]
wires = [Connection(constant, tire[name]) for name, constant in zip(starts, constants, strict=True)]
simulation = Simulation([*constants, tire], wires, dt=0.001, log=False)
simulation.run(1.0)
shown = [v.name for v in read_model_description(path).modelVariables if v.causality == "output"]
print(json.dumps({name: float(tire.outputs[shown.index(name)]) for name in outputs}))
