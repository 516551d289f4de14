"""FMUs in a container of fmu-manipulation-toolbox, which fmpy runs: parameters of a tire are not on the container.

Names of the first FMU stay as they are, those of each other one begin with its file name.
"""

import json
import shutil
import subprocess
import sys
from pathlib import Path
from tempfile import TemporaryDirectory

from fmpy import read_model_description, simulate_fmu

tires, outputs = json.loads(sys.argv[1]), sys.argv[3].split(",")
prefixes = {tire: "" if tire == next(iter(tires)) else f"{tire.lower()}." for tire in tires}
with TemporaryDirectory() as name:
    for tire, (path, _) in tires.items():
        shutil.copy(path, Path(name, f"{tire}.fmu"))
        version = read_model_description(path).fmiVersion[0]
    lines = ["rule;from_fmu;from_port;to_fmu;to_port", *(f"FMU;{tire}.fmu;;;" for tire in tires)]
    Path(name, "box.csv").write_text("\n".join(lines) + "\n")
    program = Path(sys.executable).with_name("fmucontainer")
    command = [program, "-fmi", version, "-fmu-directory", name, "-container", "box.csv:0.001"]
    subprocess.run(command, check=True, capture_output=True)
    starts = {f"{prefixes[tire]}{key}": value for tire in tires for key, value in tires[tire][1].items()}
    shown = [f"{prefixes[tire]}{key}" for tire in tires for key in outputs]
    box = str(Path(name, "box.fmu"))
    rows = simulate_fmu(box, stop_time=1.0, output_interval=0.001, start_values=starts, output=shown)
print(json.dumps({t: {key: float(rows[f"{prefixes[t]}{key}"][-1]) for key in outputs} for t in tires}))
