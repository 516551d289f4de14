"""Co-simulation of four tires and a vehicle, compared with a monolithic simulation of the same equations.

    python vehicle.py [step-steer|brake-in-turn]

The tires are native FMUs, the vehicle is an FMU by pythonfmu, and fmpy is the co-simulation master. Forces and slips
are exchanged at the communication points and constant in between, so that the error is of first order in the step.
"""

from __future__ import annotations

import shutil
import subprocess
import sys
import tempfile
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from importlib.util import module_from_spec, spec_from_file_location
from pathlib import Path
from types import ModuleType

import fmpy
import numpy as np
import numpy.typing as npt
import vehicle_equations as equations
from fmpy.fmi2 import FMU2Slave
from scipy.integrate import solve_ivp

import tirefmu
from tirefmu.tires import Tire, published

FloatArray = npt.NDArray[np.float64]
Controls = Callable[[float], tuple[float, float, float]]

SPEED = 15.0
END = 1.5
#: s, start and end of the steering ramp and of the braking ramp.
RAMPS = (0.1, 0.2, 0.7, 0.9)


def _ramp(t: float, start: float, end: float) -> float:
    return min(max((t - start) / (end - start), 0.0), 1.0)


def step_steer(t: float) -> tuple[float, float, float]:
    """Return the controls of a step steer, as fast as a driver can turn the wheel."""
    return 0.05 * _ramp(t, RAMPS[0], RAMPS[1]), 0.0, 0.0


def brake_in_turn(t: float) -> tuple[float, float, float]:
    """Return the controls of braking in a turn."""
    pressed = _ramp(t, RAMPS[2], RAMPS[3])
    return 0.04 * _ramp(t, RAMPS[0], RAMPS[1]), 110.0 * pressed, 60.0 * pressed


MANOEUVRES: dict[str, Controls] = {"step-steer": step_steer, "brake-in-turn": brake_in_turn}


def tire() -> Tire:
    """Return the tire at all four corners."""
    return published("trento_hoosier").in_signs("iso")


def write_equations(folder: Path) -> Path:
    """Print the vehicle's equations as a Python module into a folder."""
    path = folder / "printed_vehicle.py"
    path.write_text(equations.printed(), encoding="ascii")
    return path


def export(folder: Path) -> tuple[Path, Path]:
    """Write the FMUs of the tire and of the vehicle into a folder."""
    script = shutil.copy(Path(__file__).with_name("vehicle_slave.py"), folder)
    # In a separate process: pythonfmu runs the script to find its variables, and adds its folder to the path.
    build = [sys.executable, "-m", "pythonfmu", "build", "-f", script, "-d", folder, write_equations(folder)]
    subprocess.run(build, check=True)
    vehicle = folder / "Vehicle.fmu"
    return tirefmu.export(tire(), folder / "tire.fmu", fmi=2), vehicle


# ------------------------------------------------------------------ co-simulation


class Instance:
    """An instance of an FMU with access to its variables by name."""

    def __init__(self, description: fmpy.model_description.ModelDescription, folder: str, name: str) -> None:
        self.references = {variable.name: variable.valueReference for variable in description.modelVariables}
        identifier = description.coSimulation.modelIdentifier
        self.fmu = FMU2Slave(
            guid=description.guid, unzipDirectory=folder, modelIdentifier=identifier, instanceName=name
        )
        self.fmu.instantiate()
        self.fmu.setupExperiment(startTime=0.0)
        self.fmu.enterInitializationMode()

    def set(self, names: Sequence[str], values: Sequence[float]) -> None:
        """Set variables."""
        self.fmu.setReal([self.references[name] for name in names], list(values))

    def get(self, names: Sequence[str]) -> list[float]:
        """Return the values of variables."""
        return list(self.fmu.getReal([self.references[name] for name in names]))


@contextmanager
def instances(path: Path, names: Sequence[str]) -> Iterator[list[Instance]]:
    """Unpack an FMU, create instances with the given names, and free them afterwards."""
    description = fmpy.read_model_description(str(path))
    with tempfile.TemporaryDirectory() as folder:
        fmpy.extract(str(path), folder)
        created = [Instance(description, folder, name) for name in names]
        try:
            yield created
        finally:
            for instance in created:
                instance.fmu.freeInstance()


def cosimulate(tire_fmu: Path, vehicle_fmu: Path, controls: Controls, step: float) -> tuple[FloatArray, FloatArray]:
    """Return communication times, shape (n,), and the vehicle's states there, shape (n, n_states)."""
    n = round(END / step)
    states = np.empty((n + 1, len(equations.STATES)))
    tire_inputs, tire_outputs = ("kappa", "alpha", "gamma", "Fz"), ("Fx", "Fy", "Mz")
    with instances(vehicle_fmu, ["vehicle"]) as (vehicle,), instances(tire_fmu, equations.CORNERS) as tires:
        vehicle.set(["v_start"], [SPEED])
        for instance in (vehicle, *tires):
            instance.fmu.exitInitializationMode()
        for i in range(n + 1):
            t = i * step
            vehicle.set(equations.CONTROLS, controls(t))
            slips, forces = vehicle.get(equations.SLIPS), []
            for corner, instance in enumerate(tires):
                instance.set(tire_inputs, slips[4 * corner : 4 * corner + 4])
                forces += instance.get(tire_outputs)
            vehicle.set(equations.FORCES, forces)
            states[i] = vehicle.get(equations.STATES)
            if i < n:
                for instance in (vehicle, *tires):
                    instance.fmu.doStep(t, step)
    return step * np.arange(n + 1), states


# ------------------------------------------------------------------ monolithic simulation


def load(path: Path) -> ModuleType:
    """Return a module from a file."""
    spec = spec_from_file_location("printed_vehicle_alone", path)
    if spec is None or spec.loader is None:
        raise ImportError(str(path))
    module = module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def monolithic(controls: Controls, times: FloatArray) -> FloatArray:
    """Return the states at given times, with tires and vehicle in one right-hand side."""
    with tempfile.TemporaryDirectory() as folder:
        vehicle = load(write_equations(Path(folder)))
    model = tire()

    def slope(t: float, state: FloatArray) -> FloatArray:
        drive = controls(t)
        kappa, alpha, gamma, Fz = np.reshape(vehicle.slips(state, drive), (4, 4)).T
        forces = model.forces(kappa=kappa, alpha=alpha, gamma=gamma, Fz=Fz)
        per_corner = np.stack([forces["Fx"], forces["Fy"], forces["Mz"]], axis=1)
        return np.array(vehicle.derivatives(state, drive, per_corner.ravel()))

    state = np.array([SPEED, *[0.0] * 6, *[SPEED / vehicle.RADIUS] * 4])
    states = np.empty((len(times), len(state)))
    # Between the corners of the ramps, where the right-hand side is smooth.
    for start, end in zip((0.0, *RAMPS), (*RAMPS, END), strict=True):
        inside = (times >= start - 1e-9) & (times < end - 1e-9)
        requested = np.maximum(times[inside], start)
        run = solve_ivp(slope, (start, end), state, t_eval=[*requested, end], rtol=1e-8, atol=1e-9)
        if not run.success:
            raise RuntimeError(run.message)
        states[inside], state = run.y[:, :-1].T, run.y[:, -1]
    states[times >= END - 1e-9] = state
    return states


def errors(computed: FloatArray, exact: FloatArray) -> FloatArray:
    """Return the largest error of each state relative to its largest value, shape (n_states,)."""
    return np.asarray(np.abs(computed - exact).max(axis=0) / np.abs(exact).max(axis=0))


def main() -> int:
    """Compare one manoeuvre at several communication steps. Return 0 if the error is below 1 % at 1 ms."""
    name = sys.argv[1] if len(sys.argv) > 1 else "step-steer"
    if name not in MANOEUVRES:
        print(f"unknown manoeuvre {name}: known are {', '.join(MANOEUVRES)}", file=sys.stderr)
        return 2
    with tempfile.TemporaryDirectory() as folder:
        tire_fmu, vehicle_fmu = export(Path(folder))
        steps = (0.004, 0.002, 0.001)
        worst = []
        for step in steps:
            times, computed = cosimulate(tire_fmu, vehicle_fmu, MANOEUVRES[name], step)
            deviations = errors(computed, monolithic(MANOEUVRES[name], times))
            worst.append(float(deviations.max()))
            print(f"{name}, {1e3 * step:g} ms: {deviations.max():.3%} of {equations.STATES[int(deviations.argmax())]}")
    return 0 if worst[-1] < 0.01 else 1


if __name__ == "__main__":
    sys.exit(main())
