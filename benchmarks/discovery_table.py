"""The tables of a discovery run in Markdown."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np
from discovery_calibration import calibration
from discovery_delivered import TOLERANCE
from discovery_score import Outcome
from doc_tables import table

#: Upper limits of the rows in the table of CPU times.
ROWS = (1000, 3000, 6000, 10000, 1_000_000)


def table_of(outcomes: Sequence[Outcome], source: str) -> str:
    """Return the results by criterion, kind and effect, and the wrong cases.

    `source`: the command and the version.
    """
    kinds = list(dict.fromkeys(one.case.kind for one in outcomes))
    parts = [f"Computed by {source}: {len(outcomes)} recordings.", _levels(outcomes), _delivered(outcomes)]
    head = ("probability", "effects", "mean probability", "share missing")
    parts.append("### Calibration\n\n" + table(head, calibration(outcomes)))
    parts.append(_kinds(outcomes, kinds))
    singles = [one for one in outcomes if one.case.kind == "single"]
    if singles:
        parts.append(_effects(singles))
    parts.append(_times(outcomes))
    wrong = [one for one in outcomes if not one.right]
    lines = [f"- {one.line} ({one.case.name})" for one in wrong]
    parts.append("### Wrong cases\n\n" + ("\n".join(lines) or "None."))
    return "\n\n".join(parts)


def _levels(outcomes: Sequence[Outcome]) -> str:
    """Return the criteria of the project and the results."""

    def of(*kinds: str) -> list[Outcome]:
        return [one for one in outcomes if one.case.kind in kinds]

    def count(cases: list[Outcome], satisfied: Callable[[Outcome], bool]) -> str:
        return f"{sum(map(satisfied, cases))} of {len(cases)}" if cases else "-"

    single, null, several, unknown = of("single"), of("null"), of("double", "triple"), of("unknown")
    confounded, bent = of("confounded"), of("bent")
    closed = np.array([one.closed for one in single if one.first])
    inside, intervals = sum(one.covered for one in outcomes), sum(one.intervals for one in outcomes)
    seconds = np.array([one.seconds for one in outcomes])
    rows = [
        ("single effects, right effect first", "94 %", count(single, lambda one: one.first)),
        ("the same with wrong additional effects", "at most 12 %", count(single, lambda one: bool(one.extra))),
        ("none missing, effect reported", "at most 3 %", count(null, lambda one: bool(set(one.found) - {"UNKNOWN"}))),
        ("none missing, UNKNOWN reported", "at most 6 %", count(null, lambda one: "UNKNOWN" in one.found)),
        ("reduction of the squared error, median", "0.95", f"{np.median(closed):.3f}" if len(closed) else "-"),
        ("the same, share of cases at least 0.8", "95 %", f"{np.mean(closed >= 0.8):.0%}" if len(closed) else "-"),
        ("two and three effects, exact set", "60 %", count(several, lambda one: one.exact)),
        ("unknown, reported", "all", count(unknown, lambda one: one.exact)),
        ("unknown, variables right", "all", count(unknown, lambda one: one.unknown.right)),
        ("unknown, reduction at least 0.9", "better: all", count(unknown, lambda one: one.closed >= 0.9)),
        ("unknown, error larger than before", "0", count(unknown, lambda one: one.closed < -0.001)),
        ("confounded, reported", "all", count(confounded, lambda one: one.first and one.others.reported)),
        ("confounded, right next test", "better: all", count(confounded, lambda one: one.others.next_test)),
        ("95 % intervals that contain the true value", "88-98 %",
         f"{inside} of {intervals} ({inside / intervals:.0%})" if intervals else "-"),
        ("CPU seconds per case, median and largest", "60", f"{np.median(seconds):.1f}, {seconds.max():.1f}"),
    ]  # fmt: skip
    if bent:
        rows += [
            ("baseline formula of another form, right effect first", "90 %", count(bent, lambda one: one.first)),
            ("the same with wrong effects", "better: 0", count(bent, lambda one: bool(one.extra))),
        ]
    return table(("criterion", "required", "measured"), rows)


def _delivered(outcomes: Sequence[Outcome]) -> str:
    """Return how the delivered tire compares with the start tire and with what the diagnosis reports."""
    compared = [one.delivered for one in outcomes if one.delivered]
    rows = []
    for what, required, ratios in (
        ("on its recording, training rows, all channels", "0", [one.recording_together for one in compared]),
        ("on its recording, hold-out rows, all channels", "0", [one.holdout_together for one in compared]),
        ("on its recording, training rows", "0", [one.recording for one in compared]),
        ("on its recording, hold-out rows", "0", [one.holdout for one in compared]),
        ("on its training rows, noise-free", "-", [one.true_recording for one in compared]),
        ("on its hold-out rows, noise-free", "-", [one.true_holdout for one in compared]),
        ("on other manoeuvres, noise-free", "-", [one.manoeuvres for one in compared]),
        ("over the operating range, noise-free", "-", [one.operating for one in compared]),
    ):
        count = sum(ratio > 1.0 + TOLERANCE for ratio in ratios)
        rows.append((f"worse than the start tire {what}", required, *_count_and_largest(count, ratios)))
    increases = [one.increase for one in compared]
    if increases:
        rows.append(("largest increase of the error over the operating range, share of the force", "-", "-",
                     f"{max(increases):.1%}"))  # fmt: skip
        spreads = [one.spreads for one in compared]
        rows.append(("the same, larger than the spread of the identified effects among tires", "0",
                     *_count_and_largest(sum(ratio > 1.0 for ratio in spreads), spreads)))  # fmt: skip
    ratios = [ratio for one in compared for ratio in one.reported]
    apart = sum(not one.consistent for one in compared)
    extremes = f"{min(ratios):.3f}, {max(ratios):.3f}" if ratios else "-"
    rows.append(("reported and recomputed residual differ by more than 2 %", "0", f"{apart} of {len(compared)}",
                 extremes))  # fmt: skip
    reasons = [one.failed.partition(":")[0] for one in outcomes if one.failed]
    counts = ", ".join(f"{reasons.count(name)} {name}" for name in dict.fromkeys(reasons)) or "-"
    rows.append(("no diagnosis", "-", f"{len(reasons)} of {len(outcomes)}", counts))
    title = "### Delivered tire\n\nThe worst channel counts where not all together do. Worse is by more than 2 %.\n\n"
    return title + table(("criterion", "required", "cases", "largest ratio or extremes"), rows)


def _count_and_largest(count: int, ratios: Sequence[float]) -> tuple[str, str]:
    return f"{count} of {len(ratios)}", f"{max(ratios):.3f}" if ratios else "-"


def _times(outcomes: Sequence[Outcome]) -> str:
    """Return CPU seconds by the number of rows."""
    rows, least = [], 0
    for most in ROWS:
        seconds = [one.seconds for one in outcomes if least < one.case.rows <= most]
        if seconds:
            rows.append(
                (f"{least + 1} to {most}", str(len(seconds)), f"{np.median(seconds):.1f}", f"{max(seconds):.1f}")
            )
        least = most
    return "### CPU seconds by rows\n\n" + table(("rows", "cases", "median", "largest"), rows)


def _kinds(outcomes: Sequence[Outcome], kinds: Sequence[str]) -> str:
    rows = []
    for kind in kinds:
        cases = [one for one in outcomes if one.case.kind == kind]
        shares = [one.closed for one in cases]
        closed = ("-", "-") if kind == "null" else (f"{np.median(shares):.3f}", f"{min(shares):.3f}")
        counts = (sum(one.right for one in cases), sum(one.first for one in cases), sum(map(_extra, cases)))
        seconds = f"{np.median([one.seconds for one in cases]):.1f}"
        rows.append((kind, str(len(cases)), *map(str, counts), *closed, seconds))
    head = ("kind", "cases", "right", "right first", "wrong additional effects",
            "closed: median", "least", "seconds")  # fmt: skip
    return "### By kind\n\n" + table(head, rows)


def _extra(outcome: Outcome) -> bool:
    return bool(outcome.extra)


def _effects(singles: Sequence[Outcome]) -> str:
    rows = []
    for effect in dict.fromkeys(one.case.hidden[0] for one in singles):
        cases = [one for one in singles if one.case.hidden[0] == effect]
        inside, intervals = sum(one.covered for one in cases), sum(one.intervals for one in cases)
        reported = "; ".join("+".join(one.found) or "nothing" for one in cases if not one.right)
        rows.append((effect, f"{sum(one.right for one in cases)} of {len(cases)}",
                     " ".join(f"{one.closed:.3f}" for one in cases),
                     f"{inside} of {intervals}" if intervals else "-", reported))  # fmt: skip
    return "### By effect\n\n" + table(("effect", "right", "closed", "intervals", "reported instead"), rows)
