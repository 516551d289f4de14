"""The results of benchmarks/recovery.py: stored as they finish, and as the table of docs/recovery.md."""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass, field
from pathlib import Path

import numpy as np

PAGE = Path(__file__).parents[1] / "docs" / "recovery.md"
#: Marks of the tables in the page: of fits, and of fits with a bootstrap.
MARKS = ("<!-- table of make recovery -->\n", "<!-- table of make recovery with bootstrap -->\n")
END = "<!-- end of the table -->\n"
#: Quantities whose intervals are compared with the true tire.
PREDICTED = ("Fx", "Fy", "Mz", "K_xkappa", "K_yalpha", "mu_x", "mu_y")
TITLES = {"mf96": "MF96", "mf52": "MF5.2", "mf61": "MF6.1"}


@dataclass(frozen=True)
class Task:
    """A fit to new noise: model, kind of noise, rows of the bench, seed, replicates of a bootstrap."""

    model: str
    noise: str
    rows: int
    seed: int
    replicates: int = 0


@dataclass(frozen=True)
class Refit:
    """The result of a task.

    Attributes
    ----------
    ok : bool
    missed : float
        The largest difference of a channel from the exact forces, relative to the noise.
    covered, intervals : int
        Of the coefficients: finite intervals that contain the true value, and all finite ones.
    seconds : float
    conditions : int
    predictions_covered : mapping of str to int
        Of each quantity, over the operating conditions.
    bootstrap_covered, bootstrap_intervals : int
        The same of the intervals of a bootstrap.
    """

    task: Task
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
            yield Refit(**{**found, "task": Task(**found["task"])})


def store(path: Path | None, refit: Refit) -> None:
    """Append a result to a file."""
    if path is not None:
        with path.open("a", encoding="utf-8") as file:
            file.write(json.dumps(asdict(refit)) + "\n")


def share(counts: Sequence[int], of: Sequence[int]) -> tuple[float, float]:
    """Return the share of all and its standard error, both in %, from the scatter between the fits.

    Examples
    --------
    >>> share([9, 10], [10, 10])
    (95.0, 5.0)
    """
    shares = 100.0 * np.array(counts) / np.array(of)
    error = float(shares.std(ddof=1) / len(shares) ** 0.5) if len(shares) > 1 else float("nan")
    return 100.0 * sum(counts) / sum(of), error


def table(refits: Sequence[Refit]) -> str:
    """Return the lines of the table of coverages: one for each model, kind of noise and number of rows."""
    rows = []
    for own in _by_kind(refits):
        parts = [([r.predictions_covered[q] for r in own], [r.conditions for r in own]) for q in PREDICTED]
        parts.append(_of_coefficients(own))
        rows.append([_bench(own[0].task), str(len(own)), *(_share_text(*part) for part in parts)])
    return _lines(["", "benches", *PREDICTED, "coefficients"], rows)


def bootstrap_table(refits: Sequence[Refit]) -> str:
    """Return the lines of the table of bootstraps, with the linear analysis of the same fits."""
    rows = []
    for own in _by_kind(refits):
        part = [r.bootstrap_covered for r in own], [r.bootstrap_intervals for r in own]
        single = [100.0 * covered / of for covered, of in zip(*part, strict=True)]
        counts = [str(own[0].task.replicates), str(len(own)), str(sum(part[1]))]
        texts = [_share_text(*part), f"{min(single):.0f} .. {max(single):.0f} %", _share_text(*_of_coefficients(own))]
        rows.append([_bench(own[0].task), *counts, *texts])
    head = ["", "replicates", "benches", "intervals", "bootstrap", "single benches", "linear analysis"]
    return _lines(head, rows)


def _by_kind(refits: Sequence[Refit]) -> list[list[Refit]]:
    """Return the fits of equal model, noise, rows and replicates together, in the order of the first of each."""
    found: dict[tuple[str, str, int, int], list[Refit]] = {}
    for refit in refits:
        task = refit.task
        found.setdefault((task.model, task.noise, task.rows, task.replicates), []).append(refit)
    return list(found.values())


def _of_coefficients(own: Sequence[Refit]) -> tuple[list[int], list[int]]:
    return [r.covered for r in own], [r.intervals for r in own]


def _bench(task: Task) -> str:
    return f"{TITLES[task.model]}, {task.noise}, {task.rows:,} rows"


def _share_text(counts: Sequence[int], of: Sequence[int]) -> str:
    return "{:.1f} +- {:.1f} %".format(*share(counts, of)) if sum(of) else "-"


def _lines(head: Sequence[str], rows: Sequence[Sequence[str]]) -> str:
    lines = [f"| {' | '.join(row)} |\n" for row in (head, *rows)]
    return "".join([lines[0], f"|{'---|' * len(head)}\n", *lines[1:]])


def write(refits: Sequence[Refit]) -> None:
    """Write the tables of which there are fits into the page."""
    plain, resampled = ([r for r in refits if bool(r.task.replicates) is chosen] for chosen in (False, True))
    page = PAGE.read_text(encoding="utf-8")
    for mark, own, lines in zip(MARKS, (plain, resampled), (table, bootstrap_table), strict=True):
        if own:
            before, rest = page.split(mark)
            page = f"{before}{mark}{lines(own)}{END}{rest.split(END, 1)[1]}"
    PAGE.write_text(page, encoding="utf-8")
