"""Whether a diagnosis names the same effects after changes of a recording that change nothing of the tire.

    python benchmarks/discovery_invariance.py [--recordings 10] [--first 36] [--jobs 2]

The recordings have one missing effect and are drawn by the generator of the second suite; the first 36 are those of the
suite. Effects that depend on the past are left out where blocks of time change their places.
"""

from __future__ import annotations

import argparse
import sys
from collections import defaultdict
from collections.abc import Callable, Mapping
from concurrent.futures import ProcessPoolExecutor
from dataclasses import replace
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).parents[1] / "tests"))
from diagnosis.case import Case
from diagnosis.independent.effects import LAGS
from diagnosis.independent.kinds import REVERSED, case_of

from tirefmu.diagnosis import diagnose

#: Effects that depend on the past.
OF_THE_PAST = {*LAGS, "wear_drift", "turn_slip"}
#: Number of stretches of which three are removed, and length of a block, s.
STRETCHES, BLOCK = 20, 10.0


def reversed_signs(case: Case) -> Case:
    """Return a case in another sign convention."""
    signs = "iso" if case.signs == "sae" else "sae"
    turned = set(REVERSED[case.signs]) ^ set(REVERSED[signs])
    turned_table = case.table.assign(**{name: -case.table[name] for name in turned & set(case.table)})
    return replace(case, table=turned_table, signs=signs)


def other_order(case: Case) -> Case:
    """Return a case with its columns in reverse order."""
    return replace(case, table=case.table[list(case.table)[::-1]])


def stretches_removed(case: Case) -> Case:
    """Return a case without 15 % of its stretches."""
    removed = np.random.default_rng(1).choice(STRETCHES, 3, replace=False)
    stretch = np.arange(len(case.table)) * STRETCHES // len(case.table)
    return replace(case, table=case.table[~np.isin(stretch, removed)].reset_index(drop=True))


def permuted(case: Case) -> Case:
    """Return a case whose blocks of time are in another order."""
    t = case.table["t"].to_numpy()
    blocks = ((t - t[0]) / BLOCK).astype(int)
    order = np.random.default_rng(2).permutation(blocks.max() + 1)
    rows = np.concatenate([np.flatnonzero(blocks == block) for block in order])
    return replace(case, table=case.table.iloc[rows].reset_index(drop=True).assign(t=t))


def noisier(case: Case) -> Case:
    """Return a case with all errors of the forces times 1.5."""
    channels = [name for name in ("Fx", "Fy", "Mz") if name in case.table]
    errors = {name: case.table[name] - case.truth[name] for name in channels}
    return replace(case, table=case.table.assign(**{name: case.table[name] + 0.5 * errors[name] for name in channels}))


CHANGES: Mapping[str, Callable[[Case], Case]] = {
    "unchanged": lambda case: case,
    "every second row": lambda case: replace(case, table=case.table.iloc[::2].reset_index(drop=True)),
    "another sign convention": reversed_signs,
    "another order of the columns": other_order,
    "without 15 % of the stretches": stretches_removed,
    "blocks of 10 s permuted": permuted,
    "errors of the forces times 1.5": noisier,
}


def named(task: tuple[int, str]) -> tuple[str, ...] | None:
    """Return the named effects of a recording after a change; nothing if the change is one for its effect."""
    number, change = task
    case = case_of("single", number)
    if change == "blocks of 10 s permuted" and set(case.hidden) & OF_THE_PAST:
        return None
    changed = CHANGES[change](case)
    result = diagnose(changed.table, signs=changed.signs, effects=changed.effects, nominal=changed.nominal)
    return tuple(sorted(finding.effect for finding in result.found))


def main() -> None:
    """Print a line per recording, and the number of equal answers by change."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--recordings", type=int, default=10)
    parser.add_argument("--first", type=int, default=36, help="number of the first recording")
    parser.add_argument("--jobs", type=int, default=2, help="processes")
    options = parser.parse_args()
    numbers = range(options.first, options.first + options.recordings)
    equal, tested = defaultdict[str, int](int), defaultdict[str, int](int)
    with ProcessPoolExecutor(options.jobs) as pool:
        for number in numbers:
            answers = dict(zip(CHANGES, pool.map(named, [(number, change) for change in CHANGES]), strict=True))
            first = answers.pop("unchanged")
            others = {change: answer for change, answer in answers.items() if answer is not None}
            for change, answer in others.items():
                tested[change] += 1
                equal[change] += answer == first
            different = {change: "+".join(answer) or "-" for change, answer in others.items() if answer != first}
            print(f"{number} {'+'.join(first or ()) or '-'} {different or ''}", flush=True)
    print("\n| change | same names |\n|---|---|")
    for change in tested:
        print(f"| {change} | {equal[change]} of {tested[change]} |")
    print(f"| all | {sum(equal.values())} of {sum(tested.values())} |")


if __name__ == "__main__":
    main()
