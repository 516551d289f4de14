"""FMUs in CoSim Toolkit (cosimtlk), which reads FMI 2: steps are counted, because `advance` compares sums of steps."""

import json
import sys

from cosimtlk import FMU

tires, outputs = json.loads(sys.argv[1]), sys.argv[3].split(",")
instances = {}
for name, (path, inputs) in tires.items():
    instances[name] = FMU(path).instantiate(start_time=0.0, step_size=0.001, start_values=inputs)
for _ in range(1000):
    rows = {name: instance.step() for name, instance in instances.items()}
print(json.dumps({name: {key: rows[name][key] for key in outputs} for name in tires}))
