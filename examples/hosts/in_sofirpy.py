"""FMUs in sofirpy, which reads FMI 2."""

import json
import sys
from pathlib import Path

from sofirpy import simulate

tires, outputs = json.loads(sys.argv[1]), sys.argv[3].split(",")
rows = simulate(
    stop_time=1.0,
    step_size=0.001,
    fmu_paths={name: Path(path) for name, (path, _) in tires.items()},
    start_values={name: inputs for name, (_, inputs) in tires.items()},
    parameters_to_log=dict.fromkeys(tires, outputs),
)
print(json.dumps({name: {key: float(rows[f"{name}.{key}"].iloc[-1]) for key in outputs} for name in tires}))
