"""FMUs in PathSim: every input is a port, and one that is not connected is 0, so that all get constants."""

import json
import sys

from fmpy import read_model_description
from pathsim import Connection, Simulation
from pathsim.blocks import Constant
from pathsim_fmi import CoSimulationFMU, ModelExchangeFMU

tires, kind, outputs = json.loads(sys.argv[1]), sys.argv[2], sys.argv[3].split(",")
blocks, constants, wires, shown = {}, [], [], {}
for tire, (path, inputs) in tires.items():
    variables = read_model_description(path).modelVariables
    blocks[tire] = ModelExchangeFMU(path) if kind == "ModelExchange" else CoSimulationFMU(path, dt=0.001)
    shown[tire] = [v.name for v in variables if v.causality == "output"]
    for name, start in ((v.name, float(v.start)) for v in variables if v.causality == "input"):
        constants.append(Constant(inputs.get(name, start)))
        wires.append(Connection(constants[-1], blocks[tire][name]))
Simulation([*constants, *blocks.values()], wires, dt=0.001, log=False).run(1.0)
print(json.dumps({t: {name: float(blocks[t].outputs[shown[t].index(name)]) for name in outputs} for t in tires}))
