"""Runs all entries of the benchmark of missing effects and writes the tables of docs/missing_effects.md.

python benchmarks/missing_effects_table.py [--seed 1] [--entries diagnosis,stepwise] [-o build/missing_effects]
"""

from __future__ import annotations

import argparse
import json
import subprocess
import sys
from importlib.metadata import version
from pathlib import Path

from tirefmu.cli import main as tirefmu
from tirefmu.missing_effects.entries import ENTRIES
from tirefmu.missing_effects.score import HEAD, row

PAGE = Path(__file__).parents[1] / "docs" / "missing_effects.md"
BEGIN, END = "<!-- measured: begin -->", "<!-- measured: end -->"
TITLES = {"tires": "Tires", "systems": "Systems that are not tires"}


def main() -> None:
    """Run the entries and write the tables."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--entries", default=",".join(ENTRIES))
    parser.add_argument("-o", "--output", type=Path, default=Path("build/missing_effects"))
    options = parser.parse_args()
    options.output.mkdir(parents=True, exist_ok=True)
    recordings = ["benchmark", "-o", str(options.output)]
    if tirefmu([*recordings, "--seed", str(options.seed)]):
        sys.exit(1)
    scores = {}
    for entry in options.entries.split(","):
        path = options.output / f"{entry}.json"
        if tirefmu([*recordings, "--entry", entry, "--json", str(path)]):
            sys.exit(1)
        scores[entry] = json.loads(path.read_text(encoding="utf-8"))["scores"]
    described = subprocess.run(
        ["git", "describe", "--always"], cwd=PAGE.parent, capture_output=True, text=True, check=True
    )
    program = f"tirefmu {version('tirefmu')} ({described.stdout.strip()})"
    arguments = f" --seed {options.seed}" * (options.seed != 1)
    parts = [f"Computed by `python benchmarks/missing_effects_table.py{arguments}`, {program}."]
    for tier, title in TITLES.items():
        lines = [[entry, *row(found[tier])] for entry, found in scores.items()]
        rows = ["| " + " | ".join(line) + " |" for line in (["entry", *HEAD], ["---"] * (len(HEAD) + 1), *lines)]
        parts += [f"### {title}", "\n".join(rows)]
    table = "\n\n".join(parts)
    print("\n" + table)
    if options.entries == ",".join(ENTRIES):
        page = PAGE.read_text(encoding="utf-8")
        PAGE.write_text(f"{page.split(BEGIN)[0]}{BEGIN}\n\n{table}\n\n{END}{page.split(END)[1]}", encoding="utf-8")


if __name__ == "__main__":
    main()
