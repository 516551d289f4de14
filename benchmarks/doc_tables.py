"""Tables of benchmarks in pages of the documentation, each between two marks."""

from __future__ import annotations

import subprocess
from collections.abc import Mapping, Sequence
from importlib.metadata import version
from pathlib import Path

DOCS = Path(__file__).parents[1] / "docs"


def table(head: Sequence[str], rows: Sequence[Sequence[str]]) -> str:
    """Return a Markdown table.

    >>> print(table(["a", "b"], [["1", "2"]]))
    | a | b |
    | --- | --- |
    | 1 | 2 |
    """
    return "\n".join(f"| {' | '.join(cells)} |" for cells in (head, ["---"] * len(head), *rows))


def cells_of(text: str) -> list[list[str]]:
    """Return the cells of the rows of a table without its head.

    >>> cells_of(table(["a", "b"], [["1", ""]]))
    [['1', '']]
    """
    rows = [line for line in text.splitlines() if line.startswith("|")]
    return [[cell.strip() for cell in row.split("|")[1:-1]] for row in rows[2:]]


def split(page: Path, part: str) -> tuple[str, str, str]:
    """Return the text of a page before, in and after a part; the marks are in the first and the last.

    Raises `SystemExit` if the page cannot be read or has no marks.
    """
    begin, end = (f"<!-- {part}: {mark} -->" for mark in ("begin", "end"))
    try:
        before, _, rest = page.read_text(encoding="utf-8").partition(begin)
    except OSError as error:
        raise SystemExit(f"{page}: cannot be read ({error.strerror})") from None
    text, mark, after = rest.partition(end)
    if not mark:
        raise SystemExit(f"{page}: the lines {begin} and {end} are missing")
    return before + begin, text, mark + after


def put(page: Path, parts: Mapping[str, str]) -> None:
    """Replace parts of a page."""
    for part, text in parts.items():
        before, _, after = split(page, part)
        page.write_text(f"{before}\n\n{text.strip()}\n\n{after}", encoding="utf-8")


def version_text() -> str:
    """Return version and commit of the project."""
    command = ["git", "describe", "--always", "--dirty"]
    described = subprocess.run(command, cwd=DOCS, capture_output=True, text=True, check=False)
    state = described.stdout.strip() if described.returncode == 0 else "no repository"
    return f"tirefmu {version('tirefmu')} ({state})"
