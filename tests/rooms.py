"""The packages of the product (root folders with Python files, without the tests), and what make accepts."""

from __future__ import annotations

import re
import tomllib
from pathlib import Path

ROOT = Path(__file__).parents[1]
ROOMS = sorted(path.parent.name for path in ROOT.glob("*/__init__.py") if path.parent.name != "tests")
MAKEFILE = (ROOT / "Makefile").read_text(encoding="utf-8")
#: Targets with a rule; `make` accepts a name that is only listed as .PHONY and does nothing.
RULES = set(re.findall(r"^([a-z-]+):", MAKEFILE, flags=re.MULTILINE))
STUDIES = tomllib.loads((ROOT / "benchmarks" / "studies.toml").read_text(encoding="utf-8"))
TARGETS = RULES | set(STUDIES)
