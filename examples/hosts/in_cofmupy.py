"""FMUs in CoFMuPy (CoFMPy until 2025): inputs without a value in the configuration are 0."""

import json
import sys
import tempfile
from pathlib import Path

from cofmupy import Coordinator
from fmpy import read_model_description

tires, outputs = json.loads(sys.argv[1]), sys.argv[3].split(",")
fmus = []
for name, (path, inputs) in tires.items():
    starts = {v.name: float(v.start) for v in read_model_description(path).modelVariables if v.causality == "input"}
    fmus.append({"id": name, "name": name, "path": path, "initialization": starts | inputs})
with tempfile.TemporaryDirectory() as folder:
    configuration = Path(folder) / "configuration.json"
    configuration.write_text(json.dumps({"fmus": fmus, "connections": [], "root": folder}))
    coordinator = Coordinator()
    coordinator.start(str(configuration))
    for _ in range(1000):  # run_simulation compares sums of steps with the end
        coordinator.do_step(0.001)
print(json.dumps({t: {n: float(coordinator.get_variable((t, n))[-1]) for n in outputs} for t in tires}))
