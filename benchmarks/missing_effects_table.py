"""Runs all entries of the benchmark of missing effects on seed 1 and writes the tables of docs/missing_effects.md."""

from __future__ import annotations

import json
import sys
from pathlib import Path

from doc_tables import DOCS, put, table, version_text
from missing_effects.entries import ENTRIES
from missing_effects.score import HEAD, row

from tirefmu.commands.cli import main as tirefmu

OUTPUT = Path(__file__).parents[1] / "build" / "missing_effects"
TITLES = {"tires": "Tires", "systems": "Systems that are not tires"}


def scores_of(entry: str) -> dict[str, dict[str, float | int | None]]:
    """Run an entry and return its score by tier."""
    path = OUTPUT / f"{entry}.json"
    if tirefmu(["benchmark", "-o", str(OUTPUT), "--seed", "1", "--entry", entry, "--json", str(path)]):
        sys.exit(1)
    return dict(json.loads(path.read_text(encoding="utf-8"))["scores"])


def main() -> None:
    """Run the entries and write the tables."""
    OUTPUT.mkdir(parents=True, exist_ok=True)
    scores = {entry: scores_of(entry) for entry in ENTRIES}
    parts = [f"Computed by `make missing-effects`, {version_text()}."]
    for tier, title in TITLES.items():
        rows = [[entry, *row(found[tier])] for entry, found in scores.items()]
        parts += [f"### {title}", table(["entry", *HEAD], rows)]
    put(DOCS / "missing_effects.md", {"measured": "\n\n".join(parts)})


if __name__ == "__main__":
    main()
