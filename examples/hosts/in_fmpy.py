"""An FMU in fmpy: `output_interval`, because simulate_fmu widens the declared step (16 ms for 10 s)."""

import json
import sys

from fmpy import simulate_fmu

path, kind, inputs, outputs = sys.argv[1], sys.argv[2], json.loads(sys.argv[3]), sys.argv[4].split(",")
rows = simulate_fmu(path, fmi_type=kind, stop_time=1.0, output_interval=0.001, start_values=inputs, output=outputs)
print(json.dumps({name: float(rows[name][-1]) for name in outputs}))
