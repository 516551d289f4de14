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
from dataclasses import replace
from pathlib import Path

import pytest

from tirefmu.tires import published

from .exports.conftest import wet_grip
from .rooms import ROOT
from .test_wheel import PROJECT, copy_of_the_sources

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


@pytest.fixture(scope="module")
def environment(tmp_path_factory):
    """Return the folder of the programs of an environment with the wheel, which the sdist also gives."""
    if not TARGET:
        pytest.skip("make release")
    target, folder = Path(TARGET), tmp_path_factory.mktemp("release")
    source = folder / "source"
    target.mkdir(parents=True, exist_ok=True)
    copy_of_the_sources(source)
    wheel, sdist = built(source, "wheel", target), built(source, "sdist", target)
    with tarfile.open(sdist) as archive:
        archive.extractall(folder / "unpacked", filter="data")
        assert not [name for name in archive.getnames() if "/tests" in name]
    (unpacked,) = (folder / "unpacked").iterdir()
    (folder / "again").mkdir()
    assert names(built(unpacked, "wheel", folder / "again")) == names(wheel)

    # The new environment has the dependencies of this one, but tirefmu from the wheel only: no network is needed.
    venv.create(folder / "environment", with_pip=False)
    programs = folder / "environment" / ("Scripts" if os.name == "nt" else "bin")
    python = programs / "python"
    run(sys.executable, "-m", "pip", "--python", python, "install", "--no-index", "--no-deps", wheel, cwd=folder)
    installed = Path(run(python, "-c", "import sysconfig; print(sysconfig.get_path('purelib'))", cwd=folder).strip())
    (installed / "dependencies.pth").write_text("\n".join(path for path in sys.path if "site-packages" in path))
    imported = run(python, "-c", "import tirefmu; print(tirefmu.__file__)", cwd=folder).strip()
    assert Path(imported).is_relative_to(installed)
    return programs


def test_the_demo_runs_in_a_clean_environment(environment, tmp_path):
    run(environment / "tirefmu", "demo", "-o", "demo", cwd=tmp_path)
    assert "All checks passed" in (tmp_path / "demo" / "index.html").read_text(encoding="utf-8")


def test_a_tire_with_a_users_effect_is_printed_outside_the_checkout(environment, tmp_path):
    """The texts of the tire file would end comments and strings of the printed code; a self-test compares all rows."""
    trento, effect = published("trento_hoosier"), wet_grip()
    tire = replace(trento, effects={*trento.has, effect.name}, added=(effect,), values={**trento.values, "GRIPT": 0.1})
    tire.save(tmp_path / "wet.tir")
    for language in ("numpy", "c", "cpp", "javascript", "matlab", "latex"):
        command = ["generate", "wet.tir", "--language", language, "-o", language, "--values", "struct", "--quiet"]
        run(environment / "tirefmu", *command, cwd=tmp_path, TIREFMU_CACHE=str(tmp_path / "cache"))
        assert any("GRIPT" in path.read_text() for path in (tmp_path / language).iterdir()), language
    # A self-test fails by its exit code.
    assert "forces" in run(environment / "python", "wet_selftest.py", cwd=tmp_path / "numpy")
    if shutil.which("cc"):
        run("cc", "-std=c99", "-O0", "wet_selftest.c", "-lm", "-o", "selftest", cwd=tmp_path / "c")
        assert "forces" in run("./selftest", cwd=tmp_path / "c")
    assert not list(tmp_path.rglob("ran"))
