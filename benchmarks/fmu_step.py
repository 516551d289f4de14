"""CPU time of a step of a tire FMU in a C host, relative to the model functions alone: medians of one run.

python benchmarks/fmu_step.py [--model mf61]
"""

from __future__ import annotations

import argparse
import re
import subprocess
import tempfile
from pathlib import Path

from tirefmu.fmu.packaging.binaries import FLAGS
from tirefmu.fmu.packaging.export import contents, fmi_headers
from tirefmu.symbolic.models import model as book_of
from tirefmu.tires import Tire
from tirefmu.tires.code.compiler import FLAGS as COMPILER_FLAGS
from tirefmu.tires.code.compiler import find_compiler


def generic(model: str, effects: set[str]) -> Tire:
    """Return a plausible tire of a model without turn slip, with all coefficients different from 0."""
    book = book_of(model)
    values = {name: declared.generic or 0.01 for name, declared in book.coefficients.items()}
    values |= {"FNOMIN": 4000.0, "UNLOADED_RADIUS": 0.3}
    return Tire(model, values, effects=(book.default_effects - {"turn_slip"}) | effects)


def measure(tire: Tire) -> tuple[float, float]:
    """Return the CPU time of the model alone and of a complete step, ns."""
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        for path, text in contents(tire, 3, "tire").items():
            if re.fullmatch(r"sources/.*\.[ch]", path):
                (folder / Path(path).name).write_bytes(text)
        host = Path(__file__).with_name("fmu_step.c")
        flags = [*COMPILER_FLAGS, *FLAGS, f"-I{folder}", f"-I{fmi_headers()}"]
        program = folder / "step"
        command = [*find_compiler(), *flags, str(host), *map(str, folder.glob("*.c")), "-o", str(program), "-lm"]
        subprocess.run(command, check=True)
        done = subprocess.run([str(program)], check=True, capture_output=True, text=True)
    model_time, step_time = map(float, done.stdout.split())
    return model_time, step_time


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--model", default="mf61")
    model = parser.parse_args().model
    kinds: dict[str, set[str]] = {"steady state": set()}
    if "relax_lat" in book_of(model).effects:
        kinds["lagging slips"] = {"relax_lat", "relax_lon"}
    for kind, effects in kinds.items():
        model_time, step_time = measure(generic(model, effects))
        print(
            f"{model}, {kind}: model {model_time:.0f} ns, set + step + get {step_time:.0f} ns, "
            f"ratio {step_time / model_time:.2f}"
        )


if __name__ == "__main__":
    main()
