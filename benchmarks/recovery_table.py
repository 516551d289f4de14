"""The results of benchmarks/recovery.py: stored as they finish, and as the table of docs/recovery.md."""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass, field
from pathlib import Path

import numpy as np
from doc_tables import DOCS, cells_of, put, split, table

PAGE, PART = DOCS / "recovery.md", "make recovery"
#: Quantities whose intervals are compared with the true tire.
PREDICTED = ("Fx", "Fy", "Mz", "K_xkappa", "K_yalpha", "mu_x", "mu_y")
TITLES = {"mf96": "MF96", "mf52": "MF5.2", "mf61": "MF6.1"}


@dataclass(frozen=True)
class RecoveryTask:
    """A fit to new noise: model, kind of noise, rows of the bench, seed, replicates of a bootstrap."""

    model: str
    noise: str
    rows: int
    seed: int
    replicates: int = 0


@dataclass(frozen=True)
class Refit:
    """The result of a task.

    - `missed`: the largest difference of a channel from the exact forces, relative to the noise.
    - `covered`, `intervals`: of the coefficients: finite intervals that contain the true value, and all finite ones.
    - `predictions_covered`: of each quantity, over the operating conditions.
    - `bootstrap_covered`, `bootstrap_intervals`: the same of the percentile intervals.
    """

    task: RecoveryTask
    ok: bool
    missed: float
    covered: int
    intervals: int
    seconds: float
    conditions: int
    predictions_covered: Mapping[str, int] = field(default_factory=dict)
    bootstrap_covered: int = 0
    bootstrap_intervals: int = 0


def stored(path: Path | None) -> Iterator[Refit]:
    """Yield the results of a file, one a line."""
    if path is not None and path.exists():
        for line in path.read_text(encoding="utf-8").splitlines():
            found = json.loads(line)
            yield Refit(**{**found, "task": RecoveryTask(**found["task"])})


def store(path: Path | None, refit: Refit) -> None:
    """Append a result to a file."""
    if path is not None:
        with path.open("a", encoding="utf-8") as file:
            file.write(json.dumps(asdict(refit)) + "\n")


def share(counts: Sequence[int], of: Sequence[int]) -> tuple[float, float]:
    """Return the share of all and its standard error, both in %, from the scatter between the fits.

    >>> share([9, 10], [10, 10])
    (95.0, 5.0)
    """
    shares = 100.0 * np.array(counts) / np.array(of)
    error = float(shares.std(ddof=1) / len(shares) ** 0.5) if len(shares) > 1 else float("nan")
    return 100.0 * sum(counts) / sum(of), error


def write(refits: Sequence[Refit]) -> None:
    """Write the coverages into the page: a line for each model, kind of noise and number of rows.

    Lines of other models, noise or rows, with or without a bootstrap, stay.
    """
    head = ["", "benches", *PREDICTED, "coefficients", "percentiles of a bootstrap"]
    lines = {(cells[0], cells[-1] == "-"): cells for cells in cells_of(split(PAGE, PART)[1])}
    for key in dict.fromkeys((r.task.model, r.task.noise, r.task.rows, r.task.replicates) for r in refits):
        chosen = [r for r in refits if (r.task.model, r.task.noise, r.task.rows, r.task.replicates) == key]
        parts = [([r.predictions_covered[q] for r in chosen], [r.conditions for r in chosen]) for q in PREDICTED]
        parts.append(([r.covered for r in chosen], [r.intervals for r in chosen]))
        parts.append(([r.bootstrap_covered for r in chosen], [r.bootstrap_intervals for r in chosen]))
        shares = ["{:.1f} +- {:.1f} %".format(*share(counts, of)) if sum(of) else "-" for counts, of in parts]
        cells = [f"{TITLES[key[0]]}, {key[1]}, {key[2]:,} rows", str(len(chosen)), *shares]
        lines[cells[0], cells[-1] == "-"] = cells
    put(PAGE, {PART: table(head, list(lines.values()))})
