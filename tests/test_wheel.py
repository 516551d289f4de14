"""The wheel holds what lies in the rooms.

A folder that setup.py forgets, or a data file that pyproject.toml forgets, is missed by nobody who works in a clone,
and by everybody who installs.
"""

from __future__ import annotations

import shutil
import subprocess
import sys
import tomllib
import zipfile
from pathlib import Path

ROOT = Path(__file__).parents[1]
PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))
#: Package name -> root folder.
ROOMS = PROJECT["tool"]["setuptools"]["package-dir"]


def on_disk(folder: Path) -> set[Path]:
    """Return the files below a folder, relative to it, without what running and editing leave behind."""
    found = {path.relative_to(folder) for path in folder.rglob("*") if path.is_file()}
    return {path for path in found if not any(part == "__pycache__" or part.startswith(".") for part in path.parts)}


def test_wheel_is_what_lies_in_the_rooms(tmp_path):
    # Built from a copy: a build folder left in the clone would hand its old files on.
    source = tmp_path / "source"
    for folder in ROOMS.values():
        shutil.copytree(ROOT / folder, source / folder, ignore=shutil.ignore_patterns("__pycache__"))
    for name in ("pyproject.toml", "setup.py", PROJECT["project"]["readme"], *PROJECT["project"]["license-files"]):
        shutil.copy(ROOT / name, source / name)
    command = [sys.executable, "-m", "pip", "wheel", "--no-deps", "--no-build-isolation", "--no-index"]
    built = subprocess.run([*command, "--wheel-dir", tmp_path, source], capture_output=True, text=True, check=False)
    assert built.returncode == 0, built.stdout + built.stderr

    (wheel,) = tmp_path.glob("*.whl")
    packed = {name for name in zipfile.ZipFile(wheel).namelist() if ".dist-info/" not in name}
    expected = {
        "/".join([*package.split("."), *path.parts])
        for package, folder in ROOMS.items()
        for path in on_disk(ROOT / folder)
    }
    assert sorted(expected - packed) == [], (
        "lies in a room, but is not in the wheel: see package-data in pyproject.toml"
    )
    assert sorted(packed - expected) == [], "is in the wheel, but lies in no room"
