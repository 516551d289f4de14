"""Rate of false names: significance of effects that the search identifies in recordings without a missing effect.

The threshold `CONFIRMED_Z` of the diagnosis is derived from the first generator of recordings and confirmed on the
second one. The recordings are others than those of `benchmarks/discovery.py`.

    python benchmarks/false_names.py [--suite first|second] [--recordings 100] [--jobs 2]
"""

from __future__ import annotations

import argparse
import sys
from concurrent.futures import ProcessPoolExecutor
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).parents[1] / "tests"))
from discovery_suites import SUITES

from tirefmu.diagnosis import diagnose
from tirefmu.diagnosis.search.refits import REFINEMENT
from tirefmu.diagnosis.thresholds import CONFIRMED_STRETCHES, MIN_HOLDOUT_GAIN

#: Number of the first recording: beyond those of the benchmark, and beyond 1000 to 1099, which were looked at.
FIRST = 2000
#: Thresholds of the joint significance that are tabulated, in standard deviations.
THRESHOLDS = (2.0, 3.0, 4.0, 5.0, 6.0, 8.0, 10.0)


def largest(task: tuple[str, int]) -> tuple[int, float, str]:
    """Return number, largest significance of an effect that passes all other criteria (0: none), and its name."""
    suite, number = task
    case = SUITES[suite].case_of("null", number)
    result = diagnose(case.table, signs=case.signs, effects=case.effects, nominal=case.nominal)
    passing = [
        (one.z, name)
        for name, one in {**result.confirmed, **result.rejected}.items()
        if not name.startswith(REFINEMENT)
        and one.stretches >= CONFIRMED_STRETCHES
        and one.holdout_gain > MIN_HOLDOUT_GAIN
    ]
    z, name = max(passing, default=(0.0, "-"))
    return number, z, name


def main() -> None:
    """Print a line per recording and the rate of false names by threshold."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--suite", choices=tuple(SUITES), default="first")
    parser.add_argument("--recordings", type=int, default=100)
    parser.add_argument("--jobs", type=int, default=2, help="processes")
    options = parser.parse_args()
    tasks = [(options.suite, number) for number in range(FIRST, FIRST + options.recordings)]
    found = []
    with ProcessPoolExecutor(options.jobs) as pool:
        for number, z, name in pool.map(largest, tasks):
            found.append(z)
            print(f"{options.suite} null:{number} {name} z {z:.1f}", flush=True)
    sizes = np.array(found)
    print(f"\n| z above | recordings of {len(sizes)} with a false name |\n|---|---|")
    for threshold in THRESHOLDS:
        print(f"| {threshold:g} | {int((sizes > threshold).sum())} |")


if __name__ == "__main__":
    main()
