"""Runs all entries of the benchmark of missing effects on seed 1 and writes the tables of docs/missing_effects.md."""

from __future__ import annotations

import json
import subprocess
import sys
from importlib.metadata import version
from pathlib import Path

from tirefmu.cli import main as tirefmu
from tirefmu.missing_effects.entries import ENTRIES
from tirefmu.missing_effects.score import HEAD, row

ROOT = Path(__file__).parents[1]
PAGE, OUTPUT = ROOT / "docs" / "missing_effects.md", ROOT / "build" / "missing_effects"
BEGIN, END = "<!-- measured: begin -->", "<!-- measured: end -->"
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
    described = subprocess.run(["git", "describe", "--always"], cwd=ROOT, capture_output=True, text=True, check=True)
    parts = [f"Computed by `make missing-effects`, tirefmu {version('tirefmu')} ({described.stdout.strip()})."]
    for tier, title in TITLES.items():
        lines = [[entry, *row(found[tier])] for entry, found in scores.items()]
        rows = ["| " + " | ".join(line) + " |" for line in (["entry", *HEAD], ["---"] * (len(HEAD) + 1), *lines)]
        parts += [f"### {title}", "\n".join(rows)]
    page, table = PAGE.read_text(encoding="utf-8"), "\n\n".join([BEGIN, *parts, END])
    PAGE.write_text(page.split(BEGIN)[0] + table + page.split(END)[1], encoding="utf-8")


if __name__ == "__main__":
    main()
