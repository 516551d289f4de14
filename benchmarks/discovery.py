"""Success rate of the diagnosis on simulated recordings: single effects, several effects, unknown and no effects.

The tires differ from all published ones, the noise is of several kinds, and some tires have other formulas. The
recordings are those of `tests/diagnosis/kinds.py` (first suite) and `tests/diagnosis/independent` (second suite).

    python benchmarks/discovery.py [--suite second] [--only single,null] [--quick] [--jobs 2] [--table FILE]
"""

from __future__ import annotations

import argparse
import json
import os
import sys
from collections.abc import Iterator
from concurrent.futures import ProcessPoolExecutor
from dataclasses import asdict
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parents[1] / "tests"))
from discovery_score import Outcome, Posed, score
from discovery_suites import SUITES
from discovery_table import table_of
from doc_tables import put, split, version_text

from tirefmu.diagnosis import diagnose

#: Cases of each kind in a quick run.
QUICK = 3


def diagnosed(task: tuple[str, str, int]) -> Outcome:
    """Diagnose one case; an exception is an outcome."""
    name, kind, i = task
    suite = SUITES[name]
    case = suite.case_of(kind, i)
    before = os.times()
    try:
        result = diagnose(case.table, signs=case.signs, effects=case.effects, nominal=case.nominal)
    except Exception as error:
        return Outcome(Posed.of(kind, i, case), _since(before), failed=f"{type(error).__name__}: {error}")
    return score(suite, kind, i, case, result, _since(before))


def _since(before: os.times_result) -> float:
    """Return the CPU time of this process, s."""
    now = os.times()
    return now.user - before.user + now.system - before.system


def outcomes(tasks: list[tuple[str, str, int]], jobs: int) -> Iterator[Outcome]:
    """Yield the outcome of each case, in order."""
    if jobs == 1:
        yield from map(diagnosed, tasks)
        return
    with ProcessPoolExecutor(jobs) as pool:
        yield from pool.map(diagnosed, tasks)


def main() -> None:
    """Run the requested kinds, print a line per case and the table."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--suite", choices=tuple(SUITES), default="first")
    parser.add_argument("--only", help="kinds, such as single,null; kind:NUMBER is one case")
    parser.add_argument("--quick", action="store_true", help=f"the first {QUICK} cases of each kind")
    parser.add_argument("--jobs", type=int, default=2, help="processes")
    parser.add_argument("--table", type=Path, help="a Markdown file in which the table is replaced")
    parser.add_argument("--json", type=Path, help="a file for the outcomes, one line per case")
    options = parser.parse_args()
    cases = SUITES[options.suite].number_of_cases
    if options.table:
        split(options.table, f"{options.suite} suite")  # errors are reported before the long run
    tasks: list[tuple[str, str, int]] = []
    for word in (options.only or ",".join(cases)).split(","):
        kind, _, number = word.partition(":")
        if kind not in cases:
            parser.error(f"--only {kind}: not one of {', '.join(cases)}")
        if number and not (number.isdigit() and int(number) < cases[kind]):
            parser.error(f"--only {word}: {kind} has the cases 0 to {cases[kind] - 1}")
        count = min(cases[kind], QUICK) if options.quick else cases[kind]
        tasks += [(options.suite, kind, i) for i in ([int(number)] if number else range(count))]
    results = []
    for outcome in outcomes(tasks, options.jobs):
        results.append(outcome)
        print(outcome.line, flush=True)
        if options.json:
            with options.json.open("a", encoding="utf-8") as file:
                file.write(json.dumps(asdict(outcome)) + "\n")
    arguments = (f" --suite {options.suite}" if options.suite != "first" else "") + (
        (f" --only {options.only}" if options.only else "") + (" --quick" if options.quick else "")
    )
    table = table_of(results, f"`python benchmarks/discovery.py{arguments}`, {version_text()}")
    print("\n" + table)
    if options.table:
        put(options.table, {f"{options.suite} suite": table})


if __name__ == "__main__":
    main()
