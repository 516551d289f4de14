"""Four tires at the corners of a vehicle: the test case of the clients and its expected results."""

from __future__ import annotations

import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import numpy.typing as npt
import pandas as pd

import tirefmu
from tirefmu.tires import Tire, published

FloatArray = npt.NDArray[np.float64]

CORNERS = ("front_left", "front_right", "rear_left", "rear_right")
INPUTS = ("kappa", "alpha", "Fz", "V")
OUTPUTS = ("Fx", "Fy", "Mz")
STEP = 0.01
STEPS = 150

#: Tolerance of a client's result against direct evaluation: |difference| <= TOLERANCE (1 + |value|).
TOLERANCE = 1e-9


def relaxing_tire() -> Tire:
    """Return the published tire with relaxation lengths."""
    tire = published("unicamp_small_tire").in_signs("iso")
    lengths = {"SIGX": 0.04, "SIGY": 0.08}
    effects = {*tire.effects, "relax_lon", "relax_lat"}
    return replace(tire, values={**tire.values, **lengths}, effects=effects, name="four tires")


def manoeuvre(corner: int) -> pd.DataFrame:
    """Return the inputs of one corner, constant over each step: a slalom with braking at its end."""
    t = STEP * np.arange(STEPS)
    swing = np.sin(2 * np.pi * t)
    left, front = corner % 2 == 0, corner < 2
    side = 1.0 if left else -1.0
    return pd.DataFrame(
        {
            "t": t,
            "kappa": np.where(t > 1.0, -0.04, 0.0) * (1.0 if front else 0.6),
            "alpha": (0.08 if front else 0.06) * swing,
            "Fz": 95.0 + side * 25.0 * swing + (8.0 if front else -8.0) * (t > 1.0),
            "V": 5.0 - 3.0 * np.maximum(t - 1.0, 0.0),
        }
    )


def expected(tire: Tire) -> FloatArray:
    """Return the forces at the end of each step, shape (STEPS, corners, outputs), by direct evaluation."""
    corners = []
    for corner in range(len(CORNERS)):
        held = manoeuvre(corner)
        # The result after a step has the inputs of the step and the states at its end: one more row for each step.
        ends = held.assign(t=STEP * np.arange(1, STEPS + 1))
        rows = pd.concat([held, ends]).sort_index(kind="stable")
        corners.append(tire.evaluate(rows, hold=True)[list(OUTPUTS)].to_numpy()[1::2])
    return np.stack(corners, axis=1)


def export(folder: Path, fmi: int) -> Path:
    """Write the tire's FMU into a folder."""
    return tirefmu.export(relaxing_tire(), folder / f"tire_fmi{fmi}.fmu", fmi=fmi)


def report(client: str, computed: FloatArray) -> int:
    """Print the error of a client and return the exit code of the process."""
    exact = expected(relaxing_tire())
    difference = np.abs(computed - exact) / (1.0 + np.abs(exact))
    worst = float(difference.max())  # NaN is propagated and counts as a failure
    print(f"{client}: {len(CORNERS)} tires, {STEPS} steps, largest difference from direct evaluation {worst:.1e}")
    return 0 if worst <= TOLERANCE else 1


def requested_version(default: int = 2) -> int:
    """Return the FMI version of the command line."""
    return int(sys.argv[1]) if len(sys.argv) > 1 else default
