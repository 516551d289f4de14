"""Forces of the four tires of a simulated vehicle: from the generated code, or from an FMU at each wheel."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from contextlib import ExitStack, contextmanager
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
import numpy.typing as npt

from tirefmu.fmu.packaging.export import export
from tirefmu.fmu.simulation.coupled import Coupled
from tirefmu.fmu.simulation.simulate import instances
from tirefmu.tires import Tire

from .unknowns import AXLES

FloatArray = npt.NDArray[np.float64]

#: kappa, alpha, Fz and V, shape (4, n) each, and the length of the step that follows with these inputs, s (0: none);
#: the answer is Fx and Fy, shape (2, 4, n).
TireForces = Callable[[Mapping[str, FloatArray], float], FloatArray]


def steady_forces(tires: Mapping[str, Tire]) -> TireForces:
    """Return the forces of the tires in steady state, from their generated code."""

    def forces(inputs: Mapping[str, FloatArray], step: float) -> FloatArray:
        parts = []
        for i, axle in enumerate(AXLES):
            found = tires[axle].forces(code="numpy", **{name: rows[2 * i : 2 * i + 2] for name, rows in inputs.items()})
            parts.append([found["Fx"], found["Fy"]])
        return np.concatenate(parts, axis=1)

    return forces


@contextmanager
def fmu_forces(tires: Mapping[str, Tire], n: int) -> Iterator[TireForces]:
    """Export the tires, and yield the forces of an FMU at each wheel of `n` vehicles."""
    with TemporaryDirectory(prefix="tirefmu-", ignore_cleanup_errors=True) as folder, ExitStack() as stack:
        axles = []
        for axle in AXLES:
            path = export(tires[axle], Path(folder) / f"{axle}.fmu")
            slaves = stack.enter_context(instances(path, 2 * n))
            read = [name for name in ("kappa", "alpha", "Fz", "V") if name in tires[axle].inputs]
            axles.append(Coupled(slaves, read, ("Fx", "Fy")))

        def forces(inputs: Mapping[str, FloatArray], step: float) -> FloatArray:
            parts = []
            for i, coupled in enumerate(axles):
                rows = [inputs[name][2 * i : 2 * i + 2].ravel() for name in coupled.inputs]
                parts.append(coupled.exchange(np.stack(rows, axis=1), step).T.reshape(2, 2, n))
            return np.concatenate(parts, axis=1)

        yield forces
