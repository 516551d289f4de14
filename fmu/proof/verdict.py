"""The verdict on a fit, from the JSON that ``tirefmu fit --json`` writes."""

from __future__ import annotations

import json
from pathlib import Path

from ...boundary.bounded_file import read_bounded
from ...boundary.errors import FmuError
from ...boundary.escaping import excerpt

#: The largest result of a fit, bytes.
LARGEST = 20_000_000


def read_verdict(path: Path) -> tuple[str, ...]:
    """Return the verdict on a fit and its reasons.

    `path`: JSON of `tirefmu fit`. Raises `FmuError` if it is not that.
    """
    try:
        fit = json.loads(read_bounded(path, LARGEST))
        return (excerpt(str(fit["verdict"])), *(excerpt(str(reason)) for reason in fit["reasons"]))
    except OSError as error:
        raise FmuError(f"{path}: cannot be read ({error.strerror or error})") from error
    except (ValueError, KeyError, TypeError, RecursionError) as error:
        raise FmuError(f"{path}: not the JSON of a fit (no verdict with its reasons)") from error
