"""Files of the recordings of a seed, and their digest."""

from __future__ import annotations

import hashlib
import json
from pathlib import Path

from .cases import DECIMALS, OTHER_DECIMALS, Made, Table, made

#: Of the recordings: another number if those of a seed change.
VERSION = 1
#: Seeds whose truth everybody can know; the tables of the documentation are those of the first.
PUBLISHED_SEEDS = (1, 2, 3, 4, 5)


def csv_text(table: Table) -> str:
    """Return a table as CSV with a fixed number of digits."""
    formats = [f"%.{DECIMALS.get(name, OTHER_DECIMALS)}f" for name in table]
    rows = (",".join(form % value for form, value in zip(formats, row, strict=True))
            for row in zip(*table.values(), strict=True))  # fmt: skip
    return "\n".join([",".join(table), *rows]) + "\n"


def texts_of(recording: Made) -> dict[str, str]:
    """Return the files of a recording by name."""
    return {
        "case.json": json.dumps(recording.about, indent=1) + "\n",
        "recording.csv": csv_text(recording.recording),
        "other.csv": csv_text(recording.other),
    }


def commitment(seed: int) -> str:
    """Return a digest that fixes a seed without showing it."""
    return hashlib.sha256(f"benchmark of missing effects {VERSION}, seed {seed}".encode()).hexdigest()


def write_recordings(seed: int, folder: Path) -> str:
    """Write the recordings of a seed into a folder, which is created, and return their digest.

    ``benchmark.json`` has the version, the digest and the commitment to the seed, not the seed.
    """
    digest, names = hashlib.sha256(), []
    for recording in made(seed):
        own = folder / recording.name
        own.mkdir(parents=True, exist_ok=True)
        for name, text in texts_of(recording).items():
            (own / name).write_text(text, encoding="ascii", newline="\n")
            digest.update(f"{recording.name}/{name}\n{text}".encode())
        names.append(recording.name)
    about = {"version": VERSION, "commitment": commitment(seed), "digest": digest.hexdigest(), "cases": names}
    (folder / "benchmark.json").write_text(json.dumps(about, indent=1) + "\n", encoding="ascii", newline="\n")
    return digest.hexdigest()
