"""What is read of the files of other programs that `foreign_files.toml` lists, as the table of docs/files.md.

    TIREFMU_FOREIGN=FOLDER python benchmarks/foreign_files.py

A file is looked for in the folder by its name. A file with another digest is another version, and counts as absent.
"""

from __future__ import annotations

import hashlib
import os
import sys
import tomllib
from pathlib import Path

from tirefmu.applications.driving.inputs.survey import survey
from tirefmu.boundary.errors import TirefmuError
from tirefmu.measurements.files.reading import read_content

LIST = Path(__file__).with_suffix(".toml")


def outcome(path: Path) -> str:
    """Return what is read of a file, or why it is refused."""
    try:
        content = read_content(path)
        found = survey(content, path.name)
    except TirefmuError as error:
        return f"refused: {str(error).removeprefix(f'{path}: ')}"
    groups = len({column.group for column in content.columns})
    proposed = ", ".join(name for name in found.proposal if name != "t") or "none"
    return f"read: {len(found.columns)} columns of numbers in {groups} group{'s' * (groups != 1)}; channels: {proposed}"


def main() -> int:
    """Print the table."""
    folder = Path(os.environ.get("TIREFMU_FOREIGN", ""))
    if not os.environ.get("TIREFMU_FOREIGN") or not folder.is_dir():
        print("TIREFMU_FOREIGN is not set, or is no folder: the files are not part of the project")
        return 0
    print("| file | of | outcome |\n|---|---|---|")
    absent = 0
    for entry in tomllib.loads(LIST.read_text(encoding="utf-8"))["file"]:
        path = folder / entry["path"].rpartition("/")[2]
        if not path.is_file() or hashlib.sha256(path.read_bytes()).hexdigest() != entry["sha256"]:
            absent += 1
            continue
        print(f"| {path.name} | {entry['source'].removeprefix('https://github.com/')} | {outcome(path)} |", flush=True)
    print(f"\n{absent} listed files are absent or of another version" if absent else "")
    return 0


if __name__ == "__main__":
    sys.exit(main())
