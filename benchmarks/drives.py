"""Made drives with a known truth: how close `tirefmu drive` comes, and how often its intervals contain the truth.

    python benchmarks/drives.py [--drives N] [--checks N] [--effects N] [--seconds S] [--seed N]

The drives are those of an independent program (tests/driving/road.py): five kinds, 60 s at 100 Hz, noise and offsets of
a consumer IMU. Errors of the car within its file, lag of the load transfer, compliance, gains, misalignment and delays
are drawn at random for each. Two of three are driven to the peak. Further drives have the tires of the file and such a
car (nothing to find), or the tires of the file and a wrong car (no tire to find). The drives with an effect that the
tire of the file lacks, and as many with changed tires only, are those of tests/driving/hidden.py. With --measured,
steering ratio, position of the sensor, compliance and masses are known better than a workshop knows them.
"""

from __future__ import annotations

import argparse
import json
import resource
import sys
import time
from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

sys.path.insert(0, str(Path(__file__).parents[1] / "tests" / "driving"))
import hidden
import road

import tirefmu
from tirefmu.applications.driving.inputs.car import Car
from tirefmu.applications.driving.inputs.car_entries import ENTRIES
from tirefmu.applications.driving.inputs.unknowns import SAME
from tirefmu.measurements.checks.recordings.coverage import PEAK_SHARE

AXLES, NAMES = ("front", "rear"), ("LMUY", "LKY")
#: Entries that scales, a tape, a turntable and a test rig for compliance measure; a change that a car of a workshop's
#: numbers shows, beyond three standard deviations of LKY.
MEASURED, LARGE = ("mass", "cg_to_front", "ratio", "x", "y", "steer_front", "steer_rear"), 0.1
#: Probabilities above which a wrong effect counts.
WRONG_EFFECTS = 0.5, 0.9
#: What is wrong in the car file of the last drives, relative to the true car or absolute.
WRONG = ({"yaw_inertia": 1.45}, {"cg_to_front": 1.12}, {"ratio": 1.06}, {"wheelbase": 1.02}, {"offset": 0.02})


def answered(log: pd.DataFrame, car: Car, number: int, kind: str, lacks: str = "") -> dict[str, Any]:
    """Return the answer as JSON and its CPU time. `lacks`: the kind of effect that the tire of the file lacks."""
    start = time.process_time()
    answer = tirefmu.drive(log, vehicle=car, tire=hidden.file_tire(lacks)).to_json()
    seconds = time.process_time() - start
    found = (
        [f"{entry['axle']} {entry['name']}" for entry in answer["found"]],
        [entry["name"] for entry in answer["car"]["found"]],
    )
    effects = {entry["effect"]: round(entry["probability"], 2) for entry in answer["effects"]}
    print(
        f"{number} {kind}: {seconds:.1f} s, {'' if answer['ok'] else 'not usable, '}tires {found[0]}, car {found[1]}, "
        f"lacking {answer['lacking']:.3f} {effects}",
        *(
            f"{axle} {name} {factor['low']:.3f} to {factor['high']:.3f}"
            for axle, row in answer["factors"].items() for name, factor in row.items() if factor["determined"]
        ),
        file=sys.stderr, flush=True, sep=", ",
    )  # fmt: skip
    return {**answer, "seconds": seconds, "kind": kind}


def spins(rows: dict[str, Any], i: int) -> bool:
    """Return whether the car spins: that is no drive."""
    return not np.isfinite(rows["vy"][:, i]).all() or bool(np.abs(rows["vy"][:, i]).max() > 6.0)


def recovery(n: int, seconds: float, seed: int, measured: float = 1.0) -> dict[str, Any]:
    """Return names, errors and coverage of the factors over drives with changed tires.

    `measured`: error of the entries in `MEASURED` over that of a workshop's numbers; the car file states it.
    """
    rng = np.random.default_rng(seed)
    truths = [road.drawn_truth(rng) for _ in range(n)]
    truths = [
        replace(truth, car=truth.car | {k: road.CAR[k] + measured * (truth.car[k] - road.CAR[k]) for k in MEASURED})
        for truth in truths
    ]
    hard = [i // 5 % 3 < 2 for i in range(n)]
    return judged(truths, hard, seconds, seed + 1, [{}] * n, measured)


def nothing_to_find(n: int, seconds: float, seed: int, *, wrong_car: bool) -> dict[str, Any]:
    """Return the same over drives with the tires of the file, with a right or with a wrong car."""
    rng = np.random.default_rng(seed + 2)
    same = {axle: dict.fromkeys(("LMUX", "LMUY", "LKX", "LKY"), 1.0) for axle in AXLES}
    truths = [replace(road.drawn_truth(rng), factors=same) for _ in range(n)]
    return judged(
        truths, [True] * n, seconds, seed + 2, [WRONG[(i + i // 5) % 5] if wrong_car else {} for i in range(n)]
    )


def car_file(wrong: Mapping[str, float], measured: float = 1.0) -> Car:
    """Return the car with wrong entries, and with the uncertainties of measured ones; see `recovery`."""
    content = road.car_content()
    for name, factor in wrong.items():
        section = ENTRIES[name].section
        content[section][name] = content[section][name] * factor if name != "offset" else factor
    for name in MEASURED if measured < 1.0 else ():
        entry = {"value": road.CAR[name], "uncertainty": measured * road.SPREAD[name]}
        content[ENTRIES[name].section][name] = entry
    return Car.from_content(content, "car")


class FactorTally:
    """Names, errors and intervals of the factors over drives.

    A name is right if the factor differs from 1 by more than tires of one kind, in the direction of the finding. Within
    reach are changed factors but those of a friction whose peak the drive does not reach; `large`: those of them that
    differ from 1 by more than 10 %.
    """

    def __init__(self) -> None:
        self.counts = dict.fromkeys(
            ("to_name", "within_reach", "large", "large_named", "right_names", "wrong_names",
             "determined_before_the_peak"), 0,
        )  # fmt: skip
        self.errors: dict[str, list[float]] = {name: [] for name in NAMES}
        self.inside: dict[str, list[bool]] = {name: [] for name in NAMES}

    def add(self, answer: Mapping[str, Any], truth: road.Truth, rows: dict[str, Any], i: int) -> None:
        """Count the answer on drive i."""
        counts = self.counts
        found = {(entry["axle"], entry["name"]): entry["factor"]["value"] > 1.0 for entry in answer["found"]}
        for axle in AXLES:
            reached = road.used_share(rows, truth, i, axle)
            for name in NAMES:
                true, factor = truth.factors[axle][name], answer["factors"][axle][name]
                changed = abs(true - 1.0) > SAME
                right = changed and found.get((axle, name)) == (true > 1.0)
                counts["to_name"] += changed
                within_reach = changed and (name == "LKY" or reached > PEAK_SHARE)
                large = within_reach and abs(true - 1.0) > LARGE
                counts["within_reach"] += within_reach
                counts["large"] += large
                counts["large_named"] += large and right
                counts["right_names"] += right
                counts["wrong_names"] += (axle, name) in found and not right
                if not factor["determined"]:
                    continue
                counts["determined_before_the_peak"] += name == "LMUY" and reached < 0.85
                self.errors[name].append(abs(factor["value"] / true - 1.0))
                self.inside[name].append(factor["low"] <= true <= factor["high"])

    def to_json(self) -> dict[str, Any]:
        """Return the counts."""
        return {
            **self.counts,
            "determined": {name: len(values) for name, values in self.inside.items()},
            "inside": {name: sum(values) for name, values in self.inside.items()},
            "median_error": {name: float(np.median(values)) for name, values in self.errors.items() if values},
        }


def judged(
    truths: list[road.Truth], hard: list[bool], seconds: float, seed: int, wrong: Sequence[Mapping[str, float]],
    measured: float = 1.0,
) -> dict[str, Any]:  # fmt: skip
    """Return what is named on drives, errors and coverage of the determined factors. `wrong`: of each car file."""
    kinds = [road.KINDS[i % 5] for i in range(len(truths))]
    logs, rows = road.made_drives(truths, kinds, hard, seed, seconds)
    factors = FactorTally()
    counts = dict.fromkeys(("drives", "spun", "effects", "contradictions", "car_names", "right_car_names"), 0)
    cpu = []
    for i, (truth, log) in enumerate(zip(truths, logs, strict=True)):
        if spins(rows, i):
            counts["spun"] += 1
            continue
        answer = answered(log, car_file(wrong[i], measured), i, kinds[i])
        cpu.append(answer["seconds"])
        counts["drives"] += 1
        counts["effects"] += bool(answer["effect"])
        counts["contradictions"] += not answer["ok"]
        named = {entry["name"] for entry in answer["car"]["found"]}
        counts["car_names"] += len(named)
        counts["right_car_names"] += len(named & wrong[i].keys())
        factors.add(answer, truth, rows, i)
    return {
        **counts, **factors.to_json(),
        "seconds": float(np.median(cpu)), "longest": max(cpu), "peak_memory_MB": peak_memory(),
    }  # fmt: skip


def peak_memory() -> float:
    """Return the largest memory of this process so far, MB."""
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024


def named_effects(n: int, seconds: float, seed: int) -> dict[str, Any]:
    """Return how often the effect that the tires lack is named, of n drives of each kind, and the same without one.

    Factors are counted on the drives without an effect: a friction that changes within a drive has no single truth.
    """
    kinds = [*(kind for kind in hidden.KINDS for _ in range(n)), *[""] * (n * len(hidden.KINDS))]
    logs, rows, truths, _ = hidden.made(kinds, seed + 3, seconds)
    car = Car.from_content(road.car_content(), "car")
    wrong = {f"wrong_above_{limit}": limit for limit in WRONG_EFFECTS}
    counts = dict.fromkeys(("drives", "named", "named_right", "first_right", *wrong, "drives_without"), 0)
    without, factors = dict.fromkeys(wrong, 0), FactorTally()
    for i in sorted(range(len(logs)), key=lambda i: i % n):
        if spins(rows, i):
            continue
        kind = kinds[i]
        answer = answered(logs[i], car, i, kind or "no effect", kind)
        right = hidden.KINDS[kind][0] if kind else ""
        effects = [entry["effect"] for entry in answer["effects"]]
        above = {
            name: any(entry["probability"] > limit for entry in answer["effects"] if entry["effect"] != right)
            for name, limit in wrong.items()
        }
        for name, value in above.items():
            (counts if kind else without)[name] += value
        if not kind:
            counts["drives_without"] += 1
            factors.add(answer, truths[i], rows, i)
            continue
        named = bool(answer["effect"])
        counts["drives"] += 1
        counts["named"] += named
        counts["named_right"] += named and effects[0] == right
        counts["first_right"] += effects[:1] == [right]
    return {**counts, "without": {**without, **factors.to_json()}}


def main() -> None:
    """Print the results as JSON."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--drives", type=int, default=60, help="drives with changed tires")
    parser.add_argument("--checks", type=int, default=10, help="drives with nothing to find, and with a wrong car")
    parser.add_argument("--effects", type=int, default=3, help="drives for each kind of effect")
    parser.add_argument("--seconds", type=float, default=60.0)
    parser.add_argument("--seed", type=int, default=36)
    parser.add_argument("--measured", type=float, default=1.0, help="error of measured entries over a workshop's")
    options = parser.parse_args()
    checks = options.checks, options.seconds, options.seed
    for name, count, part in (
        ("recovery", options.drives, lambda: recovery(options.drives, options.seconds, options.seed, options.measured)),
        ("nothing_to_find", options.checks, lambda: nothing_to_find(*checks, wrong_car=False)),
        ("wrong_car", options.checks, lambda: nothing_to_find(*checks, wrong_car=True)),
        ("effects", options.effects, lambda: named_effects(options.effects, options.seconds, options.seed)),
    ):
        if count:
            print(json.dumps({name: part()}, indent=2), flush=True)


if __name__ == "__main__":
    main()
