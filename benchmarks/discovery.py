"""Success rate of the diagnosis on simulated recordings: single effects, several effects, unknown and no effects.

The tires differ from all published ones, the noise is of several kinds, and some tires have other formulas. The
recordings are those of `tests/diagnosis/kinds.py`.

    python benchmarks/discovery.py [--only single,null] [--quick] [--jobs 2] [--table docs/discovery.md]
"""

from __future__ import annotations

import argparse
import json
import os
import subprocess
import sys
from collections.abc import Iterator
from concurrent.futures import ProcessPoolExecutor
from dataclasses import asdict
from importlib.metadata import version
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parents[1] / "tests"))
from diagnosis.kinds import NUMBER_OF_CASES, case_of
from discovery_score import Outcome, score
from discovery_table import put_table, split_page, table_of

from tirefmu.diagnosis import diagnose

#: Cases of each kind in a quick run.
QUICK = 3


def diagnosed(task: tuple[str, int]) -> Outcome:
    """Diagnose one case."""
    kind, i = task
    case = case_of(kind, i)
    before = os.times()
    result = diagnose(case.table, signs=case.signs, effects=case.effects, nominal=case.nominal)
    after = os.times()
    return score(kind, i, case, result, after.user - before.user + after.system - before.system)


def outcomes(tasks: list[tuple[str, int]], jobs: int) -> Iterator[Outcome]:
    """Yield the outcome of each case, in order."""
    if jobs == 1:
        yield from map(diagnosed, tasks)
        return
    with ProcessPoolExecutor(jobs) as pool:
        yield from pool.map(diagnosed, tasks)


def version_text() -> str:
    """Return version and commit of the project."""
    described = subprocess.run(
        ["git", "describe", "--always", "--dirty"], cwd=Path(__file__).parent, capture_output=True, text=True
    )
    state = described.stdout.strip() if described.returncode == 0 else "no repository"
    return f"tirefmu {version('tirefmu')} ({state})"


def main() -> None:
    """Run the requested kinds, print a line per case and the table."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument(
        "--only",
        default=",".join(NUMBER_OF_CASES),
        help=f"kinds, of {', '.join(NUMBER_OF_CASES)}; kind:NUMBER is one case",
    )
    parser.add_argument("--quick", action="store_true", help=f"the first {QUICK} cases of each kind")
    parser.add_argument("--jobs", type=int, default=2, help="processes")
    parser.add_argument("--table", type=Path, help="a Markdown file in which the table is replaced")
    parser.add_argument("--json", type=Path, help="a file for the outcomes, one line per case")
    options = parser.parse_args()
    if options.table:
        split_page(options.table)  # errors are reported before the long run
    tasks: list[tuple[str, int]] = []
    for word in options.only.split(","):
        kind, _, number = word.partition(":")
        if kind not in NUMBER_OF_CASES:
            parser.error(f"--only {kind}: not one of {', '.join(NUMBER_OF_CASES)}")
        if number and not (number.isdigit() and int(number) < NUMBER_OF_CASES[kind]):
            parser.error(f"--only {word}: {kind} has the cases 0 to {NUMBER_OF_CASES[kind] - 1}")
        count = min(NUMBER_OF_CASES[kind], QUICK) if options.quick else NUMBER_OF_CASES[kind]
        tasks += [(kind, int(number))] if number else [(kind, i) for i in range(count)]
    results = []
    for outcome in outcomes(tasks, options.jobs):
        results.append(outcome)
        print(outcome.line, flush=True)
        if options.json:
            with options.json.open("a", encoding="utf-8") as file:
                file.write(json.dumps(asdict(outcome)) + "\n")
    arguments = (f" --only {options.only}" if options.only != ",".join(NUMBER_OF_CASES) else "") + (
        " --quick" if options.quick else ""
    )
    table = table_of(results, f"`python benchmarks/discovery.py{arguments}`, {version_text()}")
    print("\n" + table)
    if options.table:
        put_table(options.table, table)


if __name__ == "__main__":
    main()
