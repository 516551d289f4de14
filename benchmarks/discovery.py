"""How often the diagnosis is right: every effect hidden in made recordings, several at once, unknowns, and nothing.

The tires are other than those of any sample, their noise has several kinds, and their formulas are bent; the
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
from diagnosis.kinds import WHOLE, case_of
from discovery_score import Outcome, judged
from discovery_table import put_table, split_page, table_of

from tirefmu.diagnosis import diagnose

#: How many cases of each kind a quick run has.
QUICK = 3


def answered(task: tuple[str, int]) -> Outcome:
    """Diagnose one case."""
    kind, i = task
    case = case_of(kind, i)
    before = os.times()
    result = diagnose(case.table, signs=case.signs, effects=case.effects, nominal=case.nominal)
    after = os.times()
    return judged(kind, i, case, result, after.user - before.user + after.system - before.system)


def outcomes(tasks: list[tuple[str, int]], jobs: int) -> Iterator[Outcome]:
    """Yield what became of each case, in order."""
    if jobs == 1:
        yield from map(answered, tasks)
        return
    with ProcessPoolExecutor(jobs) as pool:
        yield from pool.map(answered, tasks)


def made_by() -> str:
    """Return which state of the project is measured."""
    asked = subprocess.run(
        ["git", "describe", "--always", "--dirty"], cwd=Path(__file__).parent, capture_output=True, text=True
    )
    state = asked.stdout.strip() if asked.returncode == 0 else "no repository"
    return f"tirefmu {version('tirefmu')} ({state})"


def main() -> None:
    """Run the kinds that were asked for, print a line a case and the table."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument(
        "--only", default=",".join(WHOLE), help=f"kinds, of {', '.join(WHOLE)}; kind:NUMBER is one case"
    )
    parser.add_argument("--quick", action="store_true", help=f"the first {QUICK} cases of each kind")
    parser.add_argument("--jobs", type=int, default=2, help="processes")
    parser.add_argument("--table", type=Path, help="a Markdown file whose measured part is replaced by the table")
    parser.add_argument("--json", type=Path, help="a file for what became of each case, a line each")
    asked = parser.parse_args()
    if asked.table:
        split_page(asked.table)  # said before the long run, not after it
    tasks: list[tuple[str, int]] = []
    for word in asked.only.split(","):
        kind, _, number = word.partition(":")
        if kind not in WHOLE:
            parser.error(f"--only {kind}: not one of {', '.join(WHOLE)}")
        if number and not (number.isdigit() and int(number) < WHOLE[kind]):
            parser.error(f"--only {word}: {kind} has the cases 0 to {WHOLE[kind] - 1}")
        count = min(WHOLE[kind], QUICK) if asked.quick else WHOLE[kind]
        tasks += [(kind, int(number))] if number else [(kind, i) for i in range(count)]
    told = []
    for outcome in outcomes(tasks, asked.jobs):
        told.append(outcome)
        print(outcome.line, flush=True)
        if asked.json:
            with asked.json.open("a", encoding="utf-8") as file:
                file.write(json.dumps(asdict(outcome)) + "\n")
    asked_for = (f" --only {asked.only}" if asked.only != ",".join(WHOLE) else "") + (" --quick" if asked.quick else "")
    table = table_of(told, f"`python benchmarks/discovery.py{asked_for}`, {made_by()}")
    print("\n" + table)
    if asked.table:
        put_table(asked.table, table)


if __name__ == "__main__":
    main()
