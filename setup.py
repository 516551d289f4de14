"""The packages of the wheel: every folder with an __init__.py below the root folders of pyproject.toml."""

import tomllib
from pathlib import Path

from setuptools import setup

ROOT = Path(__file__).parent
PACKAGES = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["tool"]["setuptools"]["package-dir"]

setup(
    packages=sorted(
        ".".join([package, *found.parent.relative_to(ROOT / folder).parts])
        for package, folder in PACKAGES.items()
        for found in (ROOT / folder).rglob("__init__.py")
    )
)
