"""An FMU in a container of fmu-manipulation-toolbox, which fmpy runs: parameters of a tire are not on the container."""

import json
import shutil
import subprocess
import sys
from pathlib import Path
from tempfile import TemporaryDirectory

from fmpy import read_model_description, simulate_fmu

path, inputs, outputs = sys.argv[1], json.loads(sys.argv[3]), sys.argv[4].split(",")
with TemporaryDirectory() as name:
    shutil.copy(path, Path(name, "tire.fmu"))
    Path(name, "box.csv").write_text("rule;from_fmu;from_port;to_fmu;to_port\nFMU;tire.fmu;;;\n")
    version = read_model_description(path).fmiVersion[0]
    program = Path(sys.executable).with_name("fmucontainer")
    command = [program, "-fmi", version, "-fmu-directory", name, "-container", "box.csv:0.001"]
    subprocess.run(command, check=True, capture_output=True)
    box = str(Path(name, "box.fmu"))
    rows = simulate_fmu(box, stop_time=1.0, output_interval=0.001, start_values=inputs, output=outputs)
print(json.dumps({name: float(rows[name][-1]) for name in outputs}))
