"""How often the diagnosis is right: every effect hidden in made recordings, pairs, unknowns, and nothing hidden.

The tires are other than those of any sample, their noise has several kinds, and their formulas are bent; the
recordings are those of `tests/diagnosis/suite.py`.

    python benchmarks/discovery.py [--groups single,double,null,unknown] [--cases 4] [--processes 2]
"""

from __future__ import annotations

import argparse
import sys
from collections import Counter
from concurrent.futures import ProcessPoolExecutor
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).parents[1] / "tests" / "diagnosis"))
from suite import SIZES, USUAL, Case, make_case

from tirefmu.diagnosis import diagnose

TROUBLES = ("ripple", "outliers", "cross_talk", "drift")
#: How many cases make the whole of a group: every effect twice, thirty recordings with nothing missing.
WHOLE = {"single": 2 * len(SIZES), "double": 12, "null": 30, "unknown": 6}


def case_of(group: str, i: int) -> Case:
    """Return a case of a group, the same for the same number."""
    rng = np.random.default_rng(1000 + i)
    trouble = tuple(rng.choice(TROUBLES, rng.integers(0, 2), replace=False))
    names = [name for name in SIZES if name not in USUAL and name != "wear_drift"]
    noise = float(rng.choice([0.6, 1.0, 2.0]))
    known = tuple(rng.choice([name for name in names if name != "relax_load"], rng.integers(0, 4), replace=False))
    if group == "null":
        return make_case(i, (), noise=noise, extra=known, trouble=trouble)
    if group == "double":
        pair = tuple(rng.choice(names, 2, replace=False))
        return make_case(400 + i, pair, noise=noise, strength=1.0, trouble=trouble)
    if group == "unknown":
        kind = ("power", "hysteresis")[i % 2]
        return make_case(300 + i, (), noise=noise, extra=known[:1], trouble=trouble, unknown=kind)
    hidden = list(SIZES)[i % len(SIZES)]
    rest = tuple(n for n in known if n != hidden and not (n.startswith("relax") and hidden.startswith("relax")))
    strength = float(rng.choice([0.6, 1.0, 1.5]))
    return make_case(100 + i, (hidden,), noise=noise, extra=rest, trouble=trouble, strength=strength)


def judged(task: tuple[str, int]) -> tuple[str, str, str, float, float]:
    """Diagnose one case; return group, outcome, what it was, the share of the gap closed on other data, seconds."""
    group, i = task
    case = case_of(group, i)
    result = diagnose(case.table, signs=case.signs, effects=case.effects, nominal=case.nominal)
    found = tuple(one.effect for one in result.found)
    right = found == ("UNKNOWN",) if group == "unknown" else set(found) == set(case.hidden)
    first = bool(found) and found[0] in case.hidden
    inputs = case.test.drop(columns=["Fx", "Fy", "Mz"])
    floor = result.gap["train"]
    left = [
        sum(float(((tire.evaluate(inputs, signs=case.signs)[c] - case.test[c]) ** 2).mean()) / floor[c]["floor"] ** 2
            for c in floor)
        for tire in (result.base_tire, result.tire)
    ]  # fmt: skip
    outcome = "exact" if right else "right first" if first else "wrong"
    told = f"{'+'.join(case.hidden) or group} -> {'+'.join(found) or 'nothing'}"
    return group, outcome, told, 1 - left[1] / left[0], result.seconds


def main() -> None:
    """Run the groups that were asked for and print a line a case and a table."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--groups", default=",".join(WHOLE), help="of single, double, null, unknown")
    parser.add_argument("--cases", type=int, help="of each group (default: the whole)")
    parser.add_argument("--processes", type=int, default=2)
    asked = parser.parse_args()
    tasks = [(group, i) for group in asked.groups.split(",") for i in range(asked.cases or WHOLE[group])]
    outcomes: Counter[tuple[str, str]] = Counter()
    closed: dict[str, list[float]] = {}
    with ProcessPoolExecutor(asked.processes) as pool:
        for group, outcome, told, share, seconds in pool.map(judged, tasks):
            print(f"{group:8} {outcome:12} {told:60} closed {share:6.3f}  {seconds:5.1f} s", flush=True)
            outcomes[group, outcome] += 1
            closed.setdefault(group, []).append(share)
    print(f"\n{'group':8} {'exact':>6} {'first':>6} {'wrong':>6}  median share of the gap closed")
    for group, shares in closed.items():
        counts = [outcomes[group, outcome] for outcome in ("exact", "right first", "wrong")]
        median = "" if group == "null" else f"{np.median(shares):.3f}"
        print(f"{group:8} {counts[0]:6} {counts[1]:6} {counts[2]:6}  {median}")


if __name__ == "__main__":
    main()
