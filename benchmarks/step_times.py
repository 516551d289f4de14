"""Times of single steps of FMUs with hub inputs: median and 99.99th percentile, as real-time hosts need them.

    python benchmarks/step_times.py [--steps 1000000] [--tires trento_hoosier,my.tir]

Each step has a random motion of the wheel carrier: speeds from reverse to 60 m/s, in the air to deep deflection, every
friction. A step is 1 ms, with setting of inputs and reading of forces. A C program measures; it needs a C compiler.
"""

from __future__ import annotations

import argparse
import sys
import tempfile
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parents[1] / "tests" / "fmu"))
from programs import random_steps

from tirefmu.fmu.packaging.binaries import FLAGS
from tirefmu.tires import tire_from
from tirefmu.tires.code.compiler import find_compiler


def main() -> None:
    """Print a line for each tire and kind of inputs."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("--steps", type=int, default=1_000_000)
    parser.add_argument("--tires", default="trento_hoosier", help="published tires or .tir files, separated by commas")
    given = parser.parse_args()
    print("tire, inputs: median, 99.99 % and longest step (us), ratio of the first two")
    for name in given.tires.split(","):
        tire = tire_from(name).in_signs("iso")
        for inputs in ("hub", "hub-torque"):
            with tempfile.TemporaryDirectory() as folder:
                times = random_steps(find_compiler(), Path(folder), tire, inputs, given.steps, "-O2", *FLAGS)
            median, high, longest = (times[key] for key in ("median", "high", "longest"))
            print(f"{name}, {inputs}: {median:.1f} {high:.1f} {longest:.1f}, {high / median:.1f}")


if __name__ == "__main__":
    main()
