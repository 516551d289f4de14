"""FMUs in SysSimX, which reads FMI 2: a port that is not set is 0, so that every input is set."""

import json
import sys

from fmpy import read_model_description
from syssimx import FMUComponent, System

tires, outputs = json.loads(sys.argv[1]), sys.argv[3].split(",")
system = System("car")
parts = {name: FMUComponent(name, path) for name, (path, _) in tires.items()}
for name, (path, inputs) in tires.items():
    system.add_component(parts[name])
    for variable in read_model_description(path).modelVariables:
        if variable.causality == "input":
            parts[name].inputs[variable.name].set(inputs.get(variable.name, float(variable.start)), 0.0)
system.initialize(t0=0.0)
system.run(t0=0.0, tf=1.0, dt=0.001)
values = {name: {key: parts[name].outputs[key].value for key in outputs} for name in tires}
print(json.dumps({t: {key: float(getattr(v, "magnitude", v)) for key, v in values[t].items()} for t in tires}))
