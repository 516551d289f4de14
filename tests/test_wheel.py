"""The wheel contains what is on disk, and all printed code, which takes long to print (make release).

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

import pytest

from tirefmu.symbolic.printers.generate import files_on_demand

from .rooms import ROOMS, ROOT

PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))
#: Files of the root that are in the wheel.
PUBLIC = ("__init__.py", "__main__.py", "py.typed")


def on_disk(folder: Path) -> set[Path]:
    """Return the files below a folder, relative to it, without files of Python and editors."""
    found = {path.relative_to(folder) for path in folder.rglob("*") if path.is_file()}
    return {path for path in found if not any(part == "__pycache__" or part.startswith(".") for part in path.parts)}


def copy_of_the_sources(target: Path) -> None:
    """Copy what wheel and sdist are built from, and the tests, which they must not contain."""
    for room in (*ROOMS, "tests"):
        shutil.copytree(ROOT / room, target / room, ignore=shutil.ignore_patterns("__pycache__"))
    built = ("pyproject.toml", "setup.py", "MANIFEST.in", PROJECT["project"]["readme"])
    for name in (*PUBLIC, *built, *PROJECT["project"]["license-files"]):
        shutil.copy(ROOT / name, target / name)


def expected_files() -> set[str]:
    """Return the names of the files of the packages and of the root, as installed."""
    rooms = (f"{room}/{path.as_posix()}" for room in ROOMS for path in on_disk(ROOT / room))
    return {f"tirefmu/{name}" for name in (*PUBLIC, *rooms)}


def test_what_is_copied_into_a_wheel_are_the_packages():
    program = "import setuptools, distutils.core as core; " \
        "made = core.run_setup('setup.py', ['build_py'], stop_after='commandline').get_command_obj('build_py'); " \
        "made.ensure_finalized(); made.set_undefined_options('build', ('build_lib', 'build_lib')); " \
        "print(made.build_lib, *made.get_outputs(include_bytecode=False), sep=chr(10))"  # fmt: skip
    done = subprocess.run([sys.executable, "-c", program], cwd=ROOT, capture_output=True, text=True, check=True)
    folder, *copied = done.stdout.splitlines()
    assert {Path(name).relative_to(folder).as_posix() for name in copied} == expected_files()


@pytest.mark.slow
def test_wheel_contains_the_packages(tmp_path):
    # Built from a copy: a build folder in the clone could contain outdated files.
    source = tmp_path / "source"
    copy_of_the_sources(source)
    command = [sys.executable, "-m", "pip", "wheel", "--no-deps", "--no-build-isolation", "--no-index"]
    built = subprocess.run([*command, "--wheel-dir", tmp_path, source], capture_output=True, text=True, check=False)
    assert built.returncode == 0, built.stdout + built.stderr

    (path,) = tmp_path.glob("*.whl")
    wheel = zipfile.ZipFile(path)
    packed = {name for name in wheel.namelist() if ".dist-info/" not in name}
    expected = expected_files()
    manifest = json.loads(wheel.read("tirefmu/generated/MANIFEST.json"))
    printed = {f"tirefmu/generated/{name}": digest for name, digest in manifest["files"].items()}
    assert {
        f"tirefmu/generated/{name}" for file in files_on_demand("mf61") for name in (file, f"with_effects/{file}")
    } < printed.keys()
    assert all(hashlib.sha256(wheel.read(name)).hexdigest() == digest for name, digest in printed.items())
    expected |= printed.keys()
    assert sorted(expected - packed) == [], "is in a package, but not in the wheel: see package-data in pyproject.toml"
    assert sorted(packed - expected) == [], "is in the wheel, but in no package"
