"""FMUs in fmpy: `output_interval`, because simulate_fmu widens the declared step (16 ms for 10 s)."""

import json
import sys

from fmpy import extract, instantiate_fmu, read_model_description, simulate_fmu

tires, kind, outputs = json.loads(sys.argv[1]), sys.argv[2], sys.argv[3].split(",")
instances = {}  # of all tires, before the first of them is simulated
for name, (path, _) in tires.items():
    instances[name] = instantiate_fmu(extract(path), read_model_description(path), fmi_type=kind)
found = {}
for name, (path, inputs) in tires.items():
    given = {"fmi_type": kind, "fmu_instance": instances[name], "start_values": inputs, "output": outputs}
    rows = simulate_fmu(path, stop_time=1.0, output_interval=0.001, **given)
    found[name] = {output: float(rows[output][-1]) for output in outputs}
print(json.dumps(found))
