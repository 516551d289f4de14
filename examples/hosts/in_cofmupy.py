"""An FMU in CoFMuPy (CoFMPy until 2025): inputs without a value in the configuration are 0."""

import json
import sys
import tempfile
from pathlib import Path

from cofmupy import Coordinator
from fmpy import read_model_description

path, inputs, outputs = sys.argv[1], json.loads(sys.argv[3]), sys.argv[4].split(",")
starts = {v.name: float(v.start) for v in read_model_description(path).modelVariables if v.causality == "input"}
tire = {"id": "tire", "name": "tire", "path": path, "initialization": starts | inputs}
with tempfile.TemporaryDirectory() as folder:
    configuration = Path(folder) / "configuration.json"
    configuration.write_text(json.dumps({"fmus": [tire], "connections": [], "root": folder}))
    coordinator = Coordinator()
    coordinator.start(str(configuration))
    for _ in range(1000):  # run_simulation compares sums of steps with the end
        coordinator.do_step(0.001)
print(json.dumps({name: float(coordinator.get_variable(("tire", name))[-1]) for name in outputs}))
