"""Rate of false names in recordings without a missing effect: identified effects, and effects with a large probability.

The recordings are others than those of `benchmarks/discovery.py`.

    python benchmarks/false_names.py [--suite first|second] [--recordings 100] [--jobs 2]
"""

from __future__ import annotations

import argparse
import sys
from concurrent.futures import ProcessPoolExecutor
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parents[1] / "tests"))
from discovery_suites import SUITES

from tirefmu.diagnosis import diagnose

#: Number of the first recording: beyond those of the benchmark, and beyond others that were looked at.
FIRST = 3000
#: Probabilities that are tabulated.
THRESHOLDS = (0.1, 0.5, 0.9, 0.99)


def named(task: tuple[str, int]) -> tuple[int, tuple[str, ...], str, float]:
    """Return number, identified effects, and the candidate with the largest probability."""
    suite, number = task
    case = SUITES[suite].case_of("null", number)
    result = diagnose(case.table, signs=case.signs, effects=case.effects, nominal=case.nominal)
    name, probability = max(result.answer.probabilities.items(), key=lambda pair: pair[1])
    return number, tuple(one.effect for one in result.found), name, probability


def main() -> None:
    """Print a line per recording and the rates."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--suite", choices=tuple(SUITES), default="first")
    parser.add_argument("--recordings", type=int, default=100)
    parser.add_argument("--jobs", type=int, default=2, help="processes")
    options = parser.parse_args()
    tasks = [(options.suite, number) for number in range(FIRST, FIRST + options.recordings)]
    identified, largest = 0, []
    with ProcessPoolExecutor(options.jobs) as pool:
        for number, found, name, probability in pool.map(named, tasks):
            identified += bool(found)
            largest.append(probability)
            print(f"{options.suite} null:{number} {'+'.join(found) or '-'}; {name} {probability:.3f}", flush=True)
    print(f"\n| of {len(largest)} recordings | number |\n|---|---|\n| an effect or UNKNOWN identified | {identified} |")
    for threshold in THRESHOLDS:
        print(f"| largest probability above {threshold:g} | {sum(one > threshold for one in largest)} |")


if __name__ == "__main__":
    main()
