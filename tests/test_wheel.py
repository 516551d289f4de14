"""The wheel contains what is on disk, and all printed code.

In a clone, a folder that setup.py misses or a data file that pyproject.toml misses has no effect; an installed wheel
fails.
"""

from __future__ import annotations

import hashlib
import json
import shutil
import subprocess
import sys
import tomllib
import zipfile
from pathlib import Path

from tirefmu.symbolic.printers.generate import files_on_demand

ROOT = Path(__file__).parents[1]
PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))
#: Package name -> root folder.
PACKAGES = PROJECT["tool"]["setuptools"]["package-dir"]


def on_disk(folder: Path) -> set[Path]:
    """Return the files below a folder, relative to it, without files of Python and editors."""
    found = {path.relative_to(folder) for path in folder.rglob("*") if path.is_file()}
    return {path for path in found if not any(part == "__pycache__" or part.startswith(".") for part in path.parts)}


def test_wheel_contains_the_packages(tmp_path):
    # Built from a copy: a build folder in the clone could contain outdated files.
    source = tmp_path / "source"
    for folder in PACKAGES.values():
        shutil.copytree(ROOT / folder, source / folder, ignore=shutil.ignore_patterns("__pycache__"))
    for name in ("pyproject.toml", "setup.py", PROJECT["project"]["readme"], *PROJECT["project"]["license-files"]):
        shutil.copy(ROOT / name, source / name)
    command = [sys.executable, "-m", "pip", "wheel", "--no-deps", "--no-build-isolation", "--no-index"]
    built = subprocess.run([*command, "--wheel-dir", tmp_path, source], capture_output=True, text=True, check=False)
    assert built.returncode == 0, built.stdout + built.stderr

    (path,) = tmp_path.glob("*.whl")
    wheel = zipfile.ZipFile(path)
    packed = {name for name in wheel.namelist() if ".dist-info/" not in name}
    expected = {
        "/".join([*package.split("."), *path.parts])
        for package, folder in PACKAGES.items()
        for path in on_disk(ROOT / folder)
    }
    manifest = json.loads(wheel.read("tirefmu/generated/MANIFEST.json"))
    printed = {f"tirefmu/generated/{name}": digest for name, digest in manifest["files"].items()}
    assert {
        f"tirefmu/generated/{name}" for file in files_on_demand("mf61") for name in (file, f"with_effects/{file}")
    } < printed.keys()
    assert all(hashlib.sha256(wheel.read(name)).hexdigest() == digest for name, digest in printed.items())
    expected |= printed.keys()
    assert sorted(expected - packed) == [], "is in a package, but not in the wheel: see package-data in pyproject.toml"
    assert sorted(packed - expected) == [], "is in the wheel, but in no package"
