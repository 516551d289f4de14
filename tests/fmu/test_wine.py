"""The Windows binary under wine: `make wine` runs this; the main suite does not, because zig's first build is slow."""

from __future__ import annotations

import os
import shutil
import subprocess
import zipfile
from pathlib import Path

import pytest
from fmpy import read_model_description

from tirefmu.fmu import export
from tirefmu.fmu.packaging import cross_compiler, prebuilding, prebuilt
from tirefmu.fmu.packaging.binaries import binary_path
from tirefmu.fmu.packaging.export import fmi_headers

pytestmark = pytest.mark.skipif("TIREFMU_WINE" not in os.environ, reason="runs by make wine")

PLATFORMS = ("x86_64-linux", "x86_64-windows")


@pytest.fixture(scope="module")
def wine():
    wine = shutil.which("wine64") or shutil.which("wine") or shutil.which("wine64", path="/usr/lib/wine")
    assert wine, "wine64 is not installed"
    assert cross_compiler.has_ziglang(), "the extra cross is not installed"
    return wine


def host(folder, platform, fmi):
    """Return the program of the host, compiled for a platform."""
    program = folder / f"host-{platform}.exe"
    source = Path(__file__).with_name("host.c")
    libraries = ["-ldl"] if platform.endswith("linux") else []
    # The same optimization as for the FMU, so that zig builds the Windows libraries once for both.
    command = [*cross_compiler.ziglang(platform).command, "-O2", f"-DFMI={fmi}", f"-I{fmi_headers()}"]
    subprocess.run([*command, str(source), "-o", str(program), *libraries], check=True, capture_output=True)
    return program


@pytest.mark.parametrize("packed", [False, True], ids=["compiled", "packed"])
@pytest.mark.parametrize("name", ["first", "mf61"])
def test_windows_computes_the_same_digits(wine, tires, fmi, name, packed, tmp_path, monkeypatch):
    if packed:
        monkeypatch.setattr(prebuilt, "FOLDER", tmp_path / "prebuilt")
        prebuilding.build([prebuilt.generic(tires[name])], PLATFORMS)
        monkeypatch.setenv("CC", "no-such-compiler")
    fmu = export(tires[name], tmp_path / "tire.fmu", fmi=fmi, platforms=PLATFORMS)
    printed = {}
    for platform in PLATFORMS:
        windows, unpacked = platform.endswith("windows"), tmp_path / "100 %, é"
        with zipfile.ZipFile(fmu) as archive:
            library = archive.extract(binary_path(fmi, "tire", platform), tmp_path)
            archive.extractall(unpacked)
        # A path in the environment has the code page of Windows: the URI tests UTF-8, the path ASCII.
        if fmi == 3:
            shutil.copytree(unpacked / "resources", tmp_path / "resources", dirs_exist_ok=True)
            resources = f"{'Z:' if windows else ''}{tmp_path}/resources/"
        else:
            resources = (unpacked / "resources").as_uri().replace("file://", "file:///Z:" if windows else "file://")
        runner = [wine] if windows else []
        command = [*runner, str(host(tmp_path, platform, fmi)), str(library), read_model_description(str(fmu)).guid]
        environment = {**os.environ, "WINEDEBUG": "-all", "WINEPREFIX": str(tmp_path / "wine"), "RESOURCES": resources}
        done = subprocess.run(command, capture_output=True, text=True, check=False, env=environment)
        assert done.returncode == 0, done.stdout + done.stderr
        printed[platform] = [[float(word) for word in line.split()] for line in done.stdout.splitlines()]
    linux, windows = printed["x86_64-linux"], printed["x86_64-windows"]
    assert len(linux) == 3
    # The systems' libraries may round sin and atan differently in the last digit.
    for ours, theirs in zip(linux, windows, strict=True):
        assert theirs == pytest.approx(ours, rel=1e-12, abs=1e-9)


@pytest.mark.parametrize("inputs", ["slip", "wheel"])
def test_the_largest_model_fits_for_every_platform(wine, tires, fmi, inputs, tmp_path):
    fmu = export(tires["mf62"], tmp_path / "tire.fmu", fmi=fmi, inputs=inputs, platforms="all")
    assert fmu.stat().st_size <= 400_000
