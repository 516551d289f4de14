"""The kart and its four tires as one system (SSP 1.0) in libcosim or ecos: python kart_system.py [libcosimpy|ecospy].

The body of the kart is an FMU by pythonfmu, the tires are native FMUs with hub inputs, and `tirefmu export --ssp` with
`--vehicle` connects them. All exchange their outputs at the communication points; fmpy must give the same result.
"""

from __future__ import annotations

import shutil
import subprocess
import sys
import tempfile
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import numpy.typing as npt
from kart import PARAMETERS, tire
from kart_body import MOTION, WRENCH
from kart_slave import BODY, NAMES
from vehicle import instances

from tirefmu.fmu import export, export_system

FloatArray = npt.NDArray[np.float64]

STEP, STEPS = 0.001, 1000
#: What the comparison reads: motion of the body, spin of each wheel.
SHOWN = (*(("vehicle", name) for name in BODY), *((corner, "omega") for corner in NAMES))
TOLERANCE = 1e-9


def build(folder: Path) -> tuple[Path, Path, Path]:
    """Write the system, the FMU of its body and the FMU of its tires into a folder."""
    here, entries = Path(__file__).parent, tuple(("VERTICAL", name, str(value)) for name, value in PARAMETERS.items())
    script, *resources = (shutil.copy(here / f"kart_{part}.py", folder) for part in ("slave", "body", "manoeuvres"))
    # In a separate process: pythonfmu runs the script to find its variables.
    subprocess.run([sys.executable, "-m", "pythonfmu", "build", "-f", script, "-d", folder, *resources], check=True)
    wheel, body = replace(tire(), other_entries=entries), folder / "Kart.fmu"
    # Not mirrored, as in kart.py: the same tire at each corner.
    system = export_system([wheel] * 4, folder / "kart.ssp", inputs="hub-torque", vehicle=body, mirror=False)
    return system, body, export(wheel, folder / "tire.fmu", fmi=2, inputs="hub-torque")


def by_fmpy(body: Path, wheel: Path) -> FloatArray:
    """Return the last values of `SHOWN`; all FMUs exchange their outputs, then all make a step."""
    names = (*MOTION, "T_drive", "T_brake")
    with instances(body, ["vehicle"]) as (vehicle,), instances(wheel, NAMES) as tires:

        def exchange() -> None:
            motions = [vehicle.get([f"{corner}_{name}" for name in names]) for corner in NAMES]
            wrenches = [tire.get(WRENCH) for tire in tires]
            for corner, tire, motion, wrench in zip(NAMES, tires, motions, wrenches, strict=True):
                tire.set(names, motion)
                vehicle.set([f"{corner}_{name}" for name in WRENCH], wrench)

        exchange()
        for component in (vehicle, *tires):
            component.fmu.exitInitializationMode()
        for i in range(STEPS):
            exchange()
            for component in (vehicle, *tires):
                component.fmu.doStep(i * STEP, STEP)
        by_name = dict(zip(("vehicle", *NAMES), (vehicle, *tires), strict=True))
        return np.array([by_name[element].get([name])[0] for element, name in SHOWN])


def by_libcosimpy(system: Path) -> FloatArray:
    """Return the same from libcosim."""
    from libcosimpy.CosimExecution import CosimExecution
    from libcosimpy.CosimObserver import CosimObserver

    execution, observer = (
        CosimExecution.from_ssp_file(str(system), round(1e9 * STEP)),
        CosimObserver.create_last_value(),
    )
    execution.add_observer(observer)
    for _ in range(STEPS):
        if not execution.step():
            raise RuntimeError("libcosim failed")
    values = []
    for element, name in SHOWN:
        index = execution.slave_index_from_instance_name(element)
        references = {v.name.decode(): v.reference for v in execution.slave_variables(index)}
        values += observer.last_real_values(index, [references[name]])
    return np.array(values)


def by_ecospy(system: Path) -> FloatArray:
    """Return the same from ecos."""
    import run_ecospy  # loads the library that ecospy needs

    with run_ecospy.EcosSimulation(ssp_path=str(system), step_size=STEP) as simulation:
        simulation.init()
        for _ in range(STEPS):
            simulation.step()
        values = np.array([simulation.get_real(f"{element}::{name}") for element, name in SHOWN])
        simulation.terminate()
    return values


TOOLS: dict[str, Callable[[Path], FloatArray]] = {"libcosimpy": by_libcosimpy, "ecospy": by_ecospy}


def main() -> int:
    """Compare a tool with fmpy. Return 0 if they agree."""
    name = sys.argv[1] if len(sys.argv) > 1 else "libcosimpy"
    with tempfile.TemporaryDirectory() as folder:
        system, body, wheel = build(Path(folder))
        computed, expected = TOOLS[name](system), by_fmpy(body, wheel)
    worst = float(np.max(np.abs(computed - expected) / (1.0 + np.abs(expected))))  # NaN is a failure
    path = float(np.linalg.norm(expected[:3]))
    print(f"{name}: kart at {path:.3f} m after {STEP * STEPS:g} s, largest difference from fmpy {worst:.1e}")
    return 0 if worst <= TOLERANCE else 1


if __name__ == "__main__":
    sys.exit(main())
