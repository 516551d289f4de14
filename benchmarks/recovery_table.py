"""The results of benchmarks/recovery.py: stored as they finish, and as the table of docs/recovery.md."""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass, field
from pathlib import Path

import numpy as np

PAGE = Path(__file__).parents[1] / "docs" / "recovery.md"
BEGIN, END = "<!-- table of make recovery -->\n", "<!-- end of the table -->\n"
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


def table(refits: Sequence[Refit]) -> str:
    """Return the table of coverages between its marks: a line for each model, kind of noise and number of rows."""
    head = ["", "benches", *PREDICTED, "coefficients", "percentiles of a bootstrap"]
    rows = []
    for key in dict.fromkeys((r.task.model, r.task.noise, r.task.rows, r.task.replicates) for r in refits):
        own = [r for r in refits if (r.task.model, r.task.noise, r.task.rows, r.task.replicates) == key]
        parts = [([r.predictions_covered[q] for r in own], [r.conditions for r in own]) for q in PREDICTED]
        parts.append(([r.covered for r in own], [r.intervals for r in own]))
        parts.append(([r.bootstrap_covered for r in own], [r.bootstrap_intervals for r in own]))
        cells = ["{:.1f} +- {:.1f} %".format(*share(counts, of)) if sum(of) else "-" for counts, of in parts]
        rows.append([f"{TITLES[key[0]]}, {key[1]}, {key[2]:,} rows", str(len(own)), *cells])
    lines = [f"| {' | '.join(row)} |\n" for row in (head, *rows)]
    return "".join([BEGIN, lines[0], f"|{'---|' * len(head)}\n", *lines[1:], END])


def write(refits: Sequence[Refit]) -> None:
    """Write the table into the page; lines of other models, noise or rows, with or without a bootstrap, stay."""
    page = PAGE.read_text(encoding="utf-8")
    before, rest = page.split(BEGIN)
    old, after = rest.split(END)
    head, rule, *written = old.splitlines(keepends=True)
    lines = {_kind(line): line for line in (*written, *table(refits).splitlines(keepends=True)[3:-1])}
    PAGE.write_text("".join([before, BEGIN, head, rule, *lines.values(), END, after]), encoding="utf-8")


def _kind(line: str) -> tuple[str, bool]:
    """Return the name of a line, and whether it is without a bootstrap."""
    cells = [cell.strip() for cell in line.split("|")[1:-1]]
    return cells[0], cells[-1] == "-"
