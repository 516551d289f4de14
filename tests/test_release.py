"""A release: the sdist gives the same wheel as the tree, and the wheel runs the demo in an environment of its own."""

from __future__ import annotations

import os
import re
import shutil
import subprocess
import sys
import tarfile
import venv
import zipfile
from pathlib import Path

import pytest

from .test_wheel import PACKAGES, PROJECT, ROOT

#: Folder for the built files; without it the test is skipped, because the demo takes a minute.
TARGET = os.environ.get("TIREFMU_RELEASE")


def run(*command, cwd, **environment):
    done = subprocess.run(
        [str(part) for part in command], cwd=cwd, env={**os.environ, **environment}, capture_output=True, text=True,
        check=False,
    )  # fmt: skip
    assert done.returncode == 0, done.stdout + done.stderr
    return done.stdout


def names(wheel):
    return sorted(name for name in zipfile.ZipFile(wheel).namelist() if ".dist-info/" not in name)


def built(source, kind, target):
    """Build with the backend of pyproject.toml, as `python -m build --no-isolation` does; return the file."""
    code = f"import sys, setuptools.build_meta as backend; print(backend.build_{kind}(sys.argv[1]))"
    return target / run(sys.executable, "-c", code, target, cwd=source).splitlines()[-1]


def test_the_version_is_the_same_everywhere():
    version = PROJECT["project"]["version"]
    assert f"\nversion: {version}\n" in (ROOT / "CITATION.cff").read_text(encoding="utf-8")
    assert re.search(rf"^## {re.escape(version)}", (ROOT / "CHANGELOG.md").read_text(encoding="utf-8"), re.MULTILINE)


@pytest.mark.skipif(not TARGET, reason="make release")
def test_a_release_works_in_a_clean_environment(tmp_path):
    target, source = Path(TARGET), tmp_path / "source"
    target.mkdir(parents=True, exist_ok=True)
    for folder in PACKAGES.values():
        shutil.copytree(ROOT / folder, source / folder, ignore=shutil.ignore_patterns("__pycache__"))
    for name in ("pyproject.toml", "setup.py", PROJECT["project"]["readme"], *PROJECT["project"]["license-files"]):
        shutil.copy(ROOT / name, source / name)
    wheel, sdist = built(source, "wheel", target), built(source, "sdist", target)
    with tarfile.open(sdist) as archive:
        archive.extractall(tmp_path / "unpacked", filter="data")
    (unpacked,) = (tmp_path / "unpacked").iterdir()
    (tmp_path / "again").mkdir()
    assert names(built(unpacked, "wheel", tmp_path / "again")) == names(wheel)

    # The new environment has the dependencies of this one, but tirefmu from the wheel only: no network is needed.
    environment = tmp_path / "environment"
    venv.create(environment, with_pip=False)
    folder = environment / ("Scripts" if os.name == "nt" else "bin")
    python = folder / ("python.exe" if os.name == "nt" else "python")
    run(sys.executable, "-m", "pip", "--python", python, "install", "--no-index", "--no-deps", wheel, cwd=tmp_path)
    installed = Path(run(python, "-c", "import sysconfig; print(sysconfig.get_path('purelib'))", cwd=tmp_path).strip())
    (installed / "dependencies.pth").write_text("\n".join(path for path in sys.path if "site-packages" in path))
    assert Path(run(python, "-c", "import tirefmu; print(tirefmu.__file__)", cwd=tmp_path).strip()).is_relative_to(
        installed
    )
    run(folder / "tirefmu", "demo", "-o", "demo", cwd=tmp_path)
    assert "All checks passed" in (tmp_path / "demo" / "index.html").read_text(encoding="utf-8")
