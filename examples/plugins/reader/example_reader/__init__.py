"""A reader for tirefmu: a file with one JSON object per line, whose keys are the columns of tables in SI units."""

import json

import pandas as pd

from tirefmu import Recording, TirefmuError


def read(path, signs):
    """Return the recording of a file."""
    rows = []
    for number, line in enumerate(path.read_text(encoding="utf-8").splitlines(), 1):
        try:
            rows.append({str(name): float(value) for name, value in json.loads(line).items()})
        except (ValueError, TypeError, AttributeError) as error:
            raise TirefmuError(f"{path}: line {number}: not an object of numbers") from error
    return Recording(pd.DataFrame(rows), signs, path.name)
