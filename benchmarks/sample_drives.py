"""Drives of an independent program with their truth: what `tirefmu drive` names, and how often its intervals are right.

    python benchmarks/sample_drives.py FOLDER [NAMES...]

FOLDER has a folder per drive: log.csv, car.json (what the user believes, with standard deviations), tire.json and
truth.json. A line is printed for each drive, then a table row: drives with a name that is none of the truth,
factors that changed and were found, intervals of determined factors that contain the truth, effects named.
"""

from __future__ import annotations

import json
import sys
import time
from pathlib import Path
from typing import Any

import numpy as np

import tirefmu
from tirefmu.applications.driving.inputs.car import Car
from tirefmu.boundary.errors import DataError

AXLES, NAMES = ("front", "rear"), ("LMUY", "LKY")
#: kg/m^3, of air.
DENSITY = 1.2
#: Of the car file: section, entry, name in car.json.
ENTRIES = (
    ("body", "wheelbase", "wheelbase"), ("body", "mass", "mass"), ("body", "cg_to_front", "cg_to_front_axle"),
    ("body", "cg_height", "cg_height"), ("body", "track_front", "track_front"), ("body", "track_rear", "track_rear"),
    ("body", "yaw_inertia", "yaw_inertia"), ("body", "front_roll_share", "roll_stiffness_share_front"),
    ("wheels", "radius_front", "wheel_radius"), ("wheels", "radius_rear", "wheel_radius"),
    ("wheels", "brake_front", "brake_share_front"), ("steering", "ratio", "steering_ratio"),
)  # fmt: skip


def entry(value: float, sd: float) -> dict[str, float]:
    """Return an entry of a car file."""
    return {"value": value, "uncertainty": sd}


def believed_car(given: dict[str, Any], header: str) -> Car:
    """Return the car that the user believes. `header`: first line of the log."""
    content: dict[str, dict[str, Any]] = {"body": {}, "steering": {}, "wheels": {}, "sensors": {}}
    for section, name, key in ENTRIES:
        content[section][name] = entry(given[key]["value"], given[key]["sd"])
    at_wheels = "road_wheel" in header
    if at_wheels:
        content["steering"]["ratio"] = entry(1.0, 0.002)
    drag = given["drag_area"]
    content["body"]["drag"] = entry(DENSITY / 2 * drag["value"], DENSITY / 2 * drag["sd"])
    imu, sensors = given["sensors"]["imu"], given["sensors"]
    ahead = imu["ahead_of_rear_axle"]
    rear = given["wheelbase"]["value"] - given["cg_to_front_axle"]["value"]
    content["sensors"]["x"] = entry(ahead["value"] - rear, ahead["sd"])
    content["sensors"]["y"] = entry(imu["left_of_center_line"]["value"], imu["left_of_center_line"]["sd"])
    if not imu["levelled"]:
        content["sensors"]["roll_gradient"] = entry(given["roll_gradient"]["value"], given["roll_gradient"]["sd"])
    content["sensors"]["misalignment"] = entry(imu["yaw_misalignment"]["value"], imu["yaw_misalignment"]["sd"])
    gain = sensors["scale_sd"]
    content["sensors"] |= {f"{name}_gain": entry(1.0, gain[name]) for name in ("ay", "yaw_rate")}
    for axle in AXLES:  # the mean of two wheel speeds
        radius = content["wheels"][f"radius_{axle}"]
        radius["uncertainty"] = float(np.hypot(radius["uncertainty"], radius["value"] * gain["wheel_speed"] / 2**0.5))
    offset = {name: float(text.split()[0]) for name, text in sensors["offset_sd"].items()}
    content["sensors"]["yaw_rate_offset"] = entry(0.0, float(np.radians(offset["yaw_rate"])))
    content["steering"]["offset"] = entry(0.0, float(np.radians(offset["road_wheel"])))
    for name in ("ax", "ay"):
        content["sensors"][f"{name}_offset"] = entry(0.0, offset[name])
    share = given["drive_share_front"]["value"]
    content["wheels"]["driven"] = "front" if share > 0.9 else "rear" if share < 0.1 else "all"
    columns = {f"omega_{corner}": f"wheel_speed_{corner}" for corner in ("fl", "fr", "rl", "rr")}
    content["columns"] = {"steer": "road_wheel" if at_wheels else "steering_wheel", **columns}
    return Car.from_content(content, "car.json")


def believed_tire(given: dict[str, Any]) -> tirefmu.Tire:
    """Return a tire of the file, with its relaxation."""
    tire = tirefmu.Tire("mf61", {name: value for name, value in given.items() if isinstance(value, (int, float))})
    return tirefmu.Tire("mf61", tire.values, effects=(*sorted(tire.has), "relax_mf")).with_values(SIGK=1.0)


def main() -> None:
    """Print the answers and the table row."""
    folder = Path(sys.argv[1])
    names = sys.argv[2:] or sorted(path.name for path in folder.iterdir() if path.is_dir())
    counts = dict.fromkeys(("drives", "unchanged", "named", "changed", "found", "determined", "inside", "effects"), 0)
    for name in names:
        case = folder / name
        truth, given, tires = (json.loads((case / f"{file}.json").read_text()) for file in ("truth", "car", "tire"))
        with (case / "log.csv").open() as log:
            car = believed_car(given, log.readline())
        start = time.process_time()
        front, rear = (believed_tire(tires[axle]) for axle in AXLES)
        try:
            answer = tirefmu.drive(case / "log.csv", vehicle=car, tire=front, rear=rear)
        except DataError as refusal:
            print(f"{name} [{truth['group']}] {truth['hidden']}: refused: {refusal}", flush=True)
            continue
        found = {(finding.axle, finding.name) for finding in answer.verdict.tires}
        true = {(axle, key): truth["factors"][f"{key}_{axle}"] for axle in AXLES for key in NAMES}
        different = {pair for pair, value in true.items() if value != 1.0}
        counts["drives"] += 1
        counts["unchanged"] += not different and not truth["effects"]
        counts["named"] += bool(found - different) or bool(answer.verdict.effect and not truth["effects"])
        counts["changed"] += len(different)
        counts["found"] += len(found & different)
        counts["effects"] += bool(answer.verdict.effect)
        for axle, key in () if truth["effects"] else true:
            factor = answer.factors[axle][key]
            numbers = f"{factor.value:.3f} ({factor.low:.3f} to {factor.high:.3f}), truth {true[axle, key]:g}"
            print(f"    {axle} {key} {numbers}{'' if factor.determined else ', ' + factor.reason}")
            counts["determined"] += factor.determined
            counts["inside"] += factor.determined and factor.low <= true[axle, key] <= factor.high
        print(
            f"{name} [{truth['group']}] {truth['hidden']}: {sorted(found)}, effect {answer.verdict.effect}, lacking "
            f"{answer.verdict.lacking:.2f} {[one.effect for one in answer.verdict.effects]}, car "
            f"{[one.name for one in answer.verdict.car]}, contradiction p {answer.verdict.contradiction.p:.2g}, "
            f"written {answer.written}, {time.process_time() - start:.0f} CPU s",
            flush=True,
        )  # fmt: skip
    print(json.dumps(counts))


if __name__ == "__main__":
    main()
