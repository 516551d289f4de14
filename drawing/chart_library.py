"""The chart library uPlot, as the package uplot-python installs it, for pages that contain it."""

from __future__ import annotations

from base64 import b64encode
from hashlib import sha256
from importlib.util import find_spec
from pathlib import Path

from ..boundary.errors import TirefmuError

LIBRARY, LIBRARY_SCRIPT, LIBRARY_STYLE = "uplot", "uPlot.iife.js", "uPlot.min.css"


def library_file(name: str) -> str:
    """Return the text of a file of the chart library, without importing its package.

    `name`: `LIBRARY_SCRIPT` or `LIBRARY_STYLE`. Raises `TirefmuError` if the package is not installed.
    """
    spec = find_spec(LIBRARY)
    for folder in (spec.submodule_search_locations or []) if spec else []:
        path = Path(folder, "static", name)
        if path.is_file():
            return path.read_text(encoding="utf-8")
    raise TirefmuError(f"{name} of the chart library is missing: pip install uplot-python")


def allowed(script: str) -> str:
    """Return the source of a content security policy that allows this script only.

    >>> allowed("")
    "'sha256-47DEQpj8HBSa+/TImW+5JCeuQeRkm5NMpJWZG3hSuFU='"
    """
    return f"'sha256-{b64encode(sha256(script.encode()).digest()).decode('ascii')}'"
