"""Times of single steps of FMUs with hub inputs: median and 99.99th percentile, as real-time hosts need them.

    python benchmarks/step_times.py [--steps 1000000] [--tires trento_hoosier,my.tir]

Each step has a random motion of the wheel carrier: speeds from reverse to 60 m/s, in the air to deep deflection, every
friction. A step is 1 ms, with setting of inputs and reading of forces. A C program measures; it needs a C compiler.
"""

from __future__ import annotations

import argparse
import re
import subprocess
import sys
import tempfile
from pathlib import Path

from tirefmu.fmu.description.interface import interface
from tirefmu.fmu.packaging.binaries import FLAGS
from tirefmu.fmu.packaging.export import contents, fmi_headers
from tirefmu.tires import Tire, tire_from
from tirefmu.tires.code.compiler import find_compiler

SOURCE = Path(__file__).with_suffix(".c")
#: Limits of the inputs; the height is relative to the free radius.
LIMITS = {
    "r_z": (0.85, 1.02), "R_32": (-0.1, 0.1), "v_x": (-10.0, 60.0), "v_y": (-3.0, 3.0), "v_z": (-0.5, 0.5),
    "w_z": (-1.0, 1.0), "omega": (-40.0, 200.0), "T_drive": (-300.0, 300.0), "T_brake": (0.0, 500.0),
    "road_mu": (0.1, 1.2),
}  # fmt: skip


def step_times(tire: Tire, inputs: str, steps: int, folder: Path) -> tuple[float, float, float]:
    """Return the median, the 99.99th percentile and the longest time of a step, microseconds."""
    files = contents(tire, 3, "tire", inputs=inputs)
    sources = {name.removeprefix("sources/"): text for name, text in files.items() if name.startswith("sources/")}
    for name, text in sources.items():
        (folder / name).write_bytes(text)
    program = folder / "step_times"
    compiled = [str(SOURCE), *(str(folder / name) for name in sources if name.endswith(".c"))]
    includes = [f"-I{folder}", f"-I{fmi_headers()}"]
    subprocess.run(
        [*find_compiler(), "-std=c99", "-O2", *FLAGS, *includes, *compiled, "-o", program, "-lm"], check=True
    )
    (token,) = re.findall(rb'instantiationToken="([^"]+)"', files["modelDescription.xml"])
    listed = {v.name: (i, v) for i, v in enumerate(interface(tire, inputs=inputs).variables)}
    size = {"r_z": tire.values["UNLOADED_RADIUS"]}
    moved = [
        f"{listed[name][0]}:{low * size.get(name, 1.0)!r}:{high * size.get(name, 1.0)!r}"
        for name, (low, high) in LIMITS.items()
        if name in listed and listed[name][1].causality == "input"
    ]
    command = [str(program), token.decode(), str(steps), str(listed["F_x"][0]), "6", *moved]
    done = subprocess.run(command, capture_output=True, text=True, check=True)
    median, high, longest = map(float, done.stdout.split())
    return median, high, longest


def main() -> int:
    """Print a line for each model and kind of inputs."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("--steps", type=int, default=1_000_000)
    parser.add_argument("--tires", default="trento_hoosier", help="published tires or .tir files, separated by commas")
    given = parser.parse_args()
    print("tire, inputs: median, 99.99 % and longest step (us), ratio of the first two")
    for name in given.tires.split(","):
        tire = tire_from(name).in_signs("iso")
        for inputs in ("hub", "hub-torque"):
            with tempfile.TemporaryDirectory() as folder:
                median, high, longest = step_times(tire, inputs, given.steps, Path(folder))
            print(f"{name}, {inputs}: {median:.1f} {high:.1f} {longest:.1f}, {high / median:.1f}")
    return 0


if __name__ == "__main__":
    sys.exit(main())
