"""Drives of a small car: a tire of the laboratory floor on a slippery one, with the published logs of DART.

    python benchmarks/dart.py FOLDER [--out FOLDER]

FOLDER has the logs of the repository Lorenzo-Lyons/DART (System_identification/Data). The car is `dart.toml`, its tires
are those of the authors, fitted on the laboratory floor. Drives are estimated: a ramp of the speed on that floor,
whose factors correct the tires; a ramp with the steering to the other side, over which the vehicle is simulated on both
pairs of tires; racing on the slippery floor on the corrected tires.
"""

from __future__ import annotations

import argparse
import json
import sys
import time
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

import tirefmu
from tirefmu import Tire
from tirefmu.applications.driving.inputs.car import read_car
from tirefmu.applications.driving.interval import OUTPUTS
from tirefmu.applications.driving.result import Drive
from tirefmu.applications.driving.simulation import horizon, simulated

CAR = Path(__file__).with_name("dart.toml")
#: D, C and B of the authors: Fy = -Fz D sin(C atan(B alpha)).
AUTHORS = {"front": (0.841, 0.841, 8.60), "rear": (0.855, 0.959, 11.5)}
FIRST, OTHER = "ramp_steer_pos02.csv", "ramp_steer_neg02.csv"
#: File and first second: the racing part of the first drive, which begins with slow turns, and the whole second one.
SLIPPERY = (("slippery_1.csv", 85.0), ("slippery_2.csv", 0.0))


def authors_tire(axle: str) -> Tire:
    """Return the tire of the authors of an axle; its longitudinal stiffness, which they do not state, is a guess."""
    D, C, B = AUTHORS[axle]
    values = {
        "FNOMIN": 4.0,
        "UNLOADED_RADIUS": 0.03,
        "PCX1": 1.5,
        "PDX1": D,
        "PKX1": 10.0,
        "PCY1": C,
        "PDY1": D,
        "PEY1": 0.0,
    }
    # PKY2 and PKY4 such that the cornering stiffness is proportional to the load.
    return Tire("mf61", {**values, "PKY1": -B * C * D * 50.0, "PKY2": 50.0, "PKY4": 1.0}, effects=("load_stiffness",))


def residual(answer: Drive, axle: str) -> float:
    """Return the rms of the side force that the motion requires beyond the tires, over 0.3 s, per axle load."""
    whole, of_tire = (answer.estimate.outputs[:, OUTPUTS.index(f"{name}_{axle}")] for name in ("Fy", "Fy_tire"))
    width = round(0.3 / answer.grid.step)
    smooth = np.convolve(whole - of_tire, np.full(width, 1 / width), "valid")
    return float(np.sqrt(np.mean(smooth**2))) * 2.0 / answer.car.axle_loads[list(AUTHORS).index(axle)]


def recorded(path: Path, first: float = 0.0) -> pd.DataFrame:
    """Return a log from a time on, s."""
    log = pd.read_csv(path)
    return log[log["vicon time"] >= log["vicon time"].iloc[0] + first]


def answered(folder: Path, name: str, tires: dict[str, Tire], out: Path | None, first: float = 0.0) -> Drive:
    """Return the answer to a drive, and print it."""
    start = time.process_time()
    log = recorded(folder / name, first)
    answer = tirefmu.drive(log, vehicle=read_car(CAR), tire=tires["front"], rear=tires["rear"])
    content: dict[str, Any] = answer.to_json()
    if out:
        answer.save(out / Path(name).stem)
        (out / Path(name).stem / "drive.json").write_text(json.dumps(content, indent=2), encoding="utf-8")
    print(f"{name}: {time.process_time() - start:.0f} CPU s, {'' if answer.ok else 'not '}usable")
    for line in content["verdict"]:
        print(f"  {line}")
    for axle, factors in content["factors"].items():
        texts = [f"{key} {factors[key]['value']:.3f} ({factors[key]['low']:.3f} to {factors[key]['high']:.3f})"
                 for key in ("LMUY", "LKY")]  # fmt: skip
        print(f"  {axle}: {', '.join(texts)}; residual {100 * residual(answer, axle):.1f} % of the load")
    print(
        f"  simulated over {horizon(answer.car):.2g} s: before {answer.before.rms}, after {answer.after.rms}",
        flush=True,
    )
    return answer


def main() -> int:
    """Print the answers; return 0 if both drives on the slippery floor converge and have a lower friction."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("folder", type=Path)
    parser.add_argument("--out", type=Path, help="folder for wheels.csv, tires and drive.json of each drive")
    options = parser.parse_args()
    given = {axle: authors_tire(axle) for axle in AUTHORS}
    fitted = answered(options.folder, FIRST, given, options.out)
    unused = answered(options.folder, OTHER, given, options.out)
    for text, tires in (("authors' tires", given), (f"tires of {FIRST}", fitted.scaled)):
        for known, car in ((0.0, "of the file"), (1.0, "as estimated")):
            z = known * unused.estimate.z
            drive = simulated(unused.grid, unused.estimate, unused.unknowns, unused.car, tires, z=z)
            print(f"{OTHER} simulated on {text}, car {car}: {drive.rms}")
    lower = True
    for name, first in SLIPPERY:
        answer = answered(options.folder, name, dict(fitted.scaled), options.out, first)
        lower &= answer.ok and any(finding.effect == "friction is lower" for finding in answer.verdict.tires)
    return 0 if lower else 1


if __name__ == "__main__":
    sys.exit(main())
