"""Where a drive and its tires disagree, in words: the axle, the phase of the drive, and the input that goes with it."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from ...numerics.ties import graded
from .estimate import Estimate
from .inputs.car import Car
from .inputs.grid import Grid
from .inputs.unknowns import AXLES
from .interval import OUTPUTS

FloatArray = npt.NDArray[np.float64]

#: Name and unit of an input, and what its value is multiplied by.
INPUTS = {
    "alpha": ("slip angle", " deg", 180.0 / np.pi), "kappa": ("longitudinal slip", "", 1.0), "Fz": ("load", " N", 1.0),
    "V": ("speed", " m/s", 1.0), "t": ("time in the log", " s", 1.0),
}  # fmt: skip
#: Groups of equal size into which an input is divided; length of a phase, s; acceleration that is one, m/s^2.
GROUPS, PHASE, ACCELERATING = 8, 2.0, 1.0


def disagreement(grid: Grid, estimate: Estimate, lacking: FloatArray, car: Car) -> str:
    """Return a sentence. `lacking`, shape (n, 2): side force that the motion requires beyond the tires, N."""
    shares = lacking / np.array(car.axle_loads)
    axle = int(np.argmax(graded(np.mean(shares**2, axis=0))))
    values = {
        name: estimate.outputs.values[:, OUTPUTS.index(f"{name}_{AXLES[axle]}")]
        for name in ("alpha", "kappa", "V", "Fz")
    }
    size = shares[:, axle]
    along = size * np.sign(values["alpha"])
    groups = {name: _groups(np.abs(values.get(name, grid.t))) for name in INPUTS}
    explained = {name: sum(len(rows) * np.mean(along[rows]) ** 2 for rows in groups[name]) for name in INPUTS}
    name = max(explained, key=lambda name: graded(explained[name]))
    strongest = max(groups[name], key=lambda rows: graded(float(np.mean(size[rows] ** 2))))
    meaning, unit, scale = INPUTS[name]
    low, high = scale * np.quantile(np.abs(values.get(name, grid.t))[strongest], [0.0, 1.0])
    number = (grid.t // PHASE).astype(np.intp) - int(grid.t[0] // PHASE)
    phase = np.flatnonzero(number == np.argmax(graded(np.bincount(number, size**2).astype(np.float64))))
    first, last = grid.t[phase[[0, -1]]]
    return (
        f"{AXLES[axle]} axle: the drive disagrees most with its tire file, by {100 * np.sqrt(np.mean(size**2)):.2g} % "
        f"of the load (rms); most from {first:.0f} to {last:.0f} s ({_motion(grid, estimate, phase)}), and at a "
        f"{meaning} of {low:.3g} to {high:.3g}{unit}: it explains {100 * explained[name] / np.sum(size**2):.0f} % of it"
    )


def _groups(values: FloatArray) -> list[npt.NDArray[np.intp]]:
    return np.array_split(np.argsort(values, kind="stable"), GROUPS)


def _motion(grid: Grid, estimate: Estimate, rows: npt.NDArray[np.intp]) -> str:
    """Return what the car does in some intervals."""
    ends = estimate.states[grid.left[rows]], estimate.states[grid.right[rows]]
    along = float(np.mean(ends[1][:, 0] - ends[0][:, 0])) / grid.step
    across = (ends[0][:, 0] + ends[1][:, 0]) * (ends[0][:, 2] + ends[1][:, 2]) / 4
    turn = "straight"
    if np.abs(across).max() > ACCELERATING:
        both = across.min() < -ACCELERATING and across.max() > ACCELERATING
        turn = "a change of direction" if both else f"a {'left' if across.mean() > 0.0 else 'right'} turn"
    pace = "braking in " if along < -ACCELERATING else "accelerating in " if along > ACCELERATING else ""
    return f"{pace}{turn}".replace("in straight", "straight ahead")
