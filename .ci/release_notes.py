"""The notes of a release, from CHANGELOG.md: python .ci/release_notes.py VERSION prints the section of a version."""

from __future__ import annotations

import re
import sys
from pathlib import Path

CHANGELOG = Path(__file__).parents[1] / "CHANGELOG.md"


def release_notes(version: str, changelog: str) -> str:
    """Return the section of a version without its heading.

    Raises `SystemExit` if it is missing or empty; the message lists the versions that the changelog has.
    """
    sections = re.split(r"^## +(.+)\n", changelog, flags=re.MULTILINE)[1:]
    notes = {title.split()[0]: text.strip() for title, text in zip(sections[::2], sections[1::2], strict=True)}
    if not notes.get(version):
        raise SystemExit(f"CHANGELOG.md has no notes of {version}: it has {', '.join(notes)}")
    return notes[version]


if __name__ == "__main__":
    print(release_notes(sys.argv[1].removeprefix("v"), CHANGELOG.read_text(encoding="utf-8")))
