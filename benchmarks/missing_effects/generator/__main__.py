"""Writes the recordings of a seed without tirefmu: ``python -m generator --seed 1 -o recordings``."""

from __future__ import annotations

import argparse
from pathlib import Path

from .files import write_recordings

if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--seed", type=int, required=True)
    parser.add_argument("-o", "--output", type=Path, required=True)
    options = parser.parse_args()
    print(write_recordings(options.seed, options.output))
