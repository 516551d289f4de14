"""Binaries for other platforms: selection, paths and formats."""

from __future__ import annotations

import shutil
import struct
import subprocess
import sys

import pytest

from tirefmu.boundary.errors import FmuError
from tirefmu.fmu import export
from tirefmu.fmu.packaging import binaries, cross_compiler
from tirefmu.fmu.packaging.binaries import binary_path, chosen_platforms
from tirefmu.fmu.packaging.cross_compiler import PLATFORMS, universal

from .programs import unzipped

#: The first bytes of a binary: its format, and the offset of the processor type.
FORMATS = {
    "x86_64-linux": (b"\x7fELF", 18, 62),
    "aarch64-linux": (b"\x7fELF", 18, 183),
    "x86_64-darwin": (b"\xcf\xfa\xed\xfe", 4, 0x0007),
    "aarch64-darwin": (b"\xcf\xfa\xed\xfe", 4, 0x000C),
}
#: Windows is excluded, because its first build takes zig a minute; `make wine` runs it.
QUICK = tuple(FORMATS)


@pytest.fixture(scope="module")
def ziglang():
    if not cross_compiler.has_ziglang():
        pytest.skip("needs the extra cross")


def packed(path):
    return {name: content for name, content in unzipped(path).items() if name.startswith("binaries/")}


@pytest.mark.parametrize(
    ("requested", "platforms"),
    [
        ("host", ("host",)),
        ("all", tuple(PLATFORMS)),
        ("host,all", tuple(PLATFORMS)),
        (" x86_64-windows , host,x86_64-windows", ("x86_64-windows", "host")),
        (["aarch64-linux", "host"], ("aarch64-linux", "host")),
    ],
)
def test_requested_platforms(requested, platforms):
    assert chosen_platforms(requested) == platforms


@pytest.mark.parametrize(
    ("requested", "message"), [("x86_64-macos", "x86_64-darwin"), ("", "known platforms are host"), ([], "no")]
)
def test_unknown_platforms_are_errors(requested, message):
    with pytest.raises(FmuError, match=message) as caught:
        chosen_platforms(requested)
    assert "\n" not in str(caught.value)


def test_every_platform_has_its_own_folder(fmi):
    positions = {binary_path(fmi, "tire", platform) for platform in PLATFORMS}
    assert len(positions) == len(PLATFORMS)
    assert binary_path(fmi, "tire") in positions | {"binaries/aarch64-windows/tire.dll"}


def test_without_the_extra_it_is_named(tires, tmp_path, monkeypatch):
    monkeypatch.setattr(cross_compiler.importlib.util, "find_spec", lambda name: None)
    with pytest.raises(FmuError, match=r"pip install 'tirefmu\[cross\]'"):
        cross_compiler.ziglang("x86_64-windows")


def test_without_any_compiler_the_extra_is_named(tires, tmp_path, monkeypatch):
    monkeypatch.setattr(binaries, "has_ziglang", lambda: False)
    monkeypatch.delenv("CC", raising=False)
    monkeypatch.setenv("PATH", str(tmp_path))
    monkeypatch.setenv("TIREFMU_CACHE", str(tmp_path / "cache"))
    with pytest.raises(FmuError, match=r"no C compiler.*pip install 'tirefmu\[cross\]'"):
        export(tires["first"], tmp_path / "tire.fmu")


def test_a_compiler_that_fails_is_not_replaced(tires, tmp_path, monkeypatch):
    monkeypatch.setattr(binaries, "has_ziglang", lambda: True)
    monkeypatch.setenv("CC", "no-such-compiler")
    with pytest.raises(FmuError, match="no-such-compiler"):
        export(tires["first"], tmp_path / "tire.fmu")


def test_a_universal_binary_has_its_slices_at_the_stated_offsets():
    slices = [
        struct.pack("<III", 0xFEEDFACF, cpu, 3) + bytes([cpu % 251]) * size for cpu, size in [(7, 10), (12, 40000)]
    ]
    made = universal(slices)
    magic, count = struct.unpack(">II", made[:8])
    assert (magic, count) == (0xCAFEBABE, 2)
    for i, content in enumerate(slices):
        cpu, subtype, offset, size, alignment = struct.unpack(">IIIII", made[8 + 20 * i : 28 + 20 * i])
        assert struct.pack("<II", cpu, subtype) == content[4:12]
        assert offset % (1 << alignment) == 0
        assert made[offset : offset + size] == content


def test_a_universal_binary_accepts_macos_only():
    with pytest.raises(FmuError, match="Mach-O"):
        universal([b"\x7fELF" + bytes(20)])


def test_binaries_are_for_the_requested_machines(ziglang, tires, fmi, tmp_path):
    found = packed(export(tires["first"], tmp_path / "tire.fmu", fmi=fmi, platforms=QUICK))
    positions = {platform: binary_path(fmi, "tire", platform) for platform in QUICK}
    if fmi == 2:
        del positions["aarch64-darwin"]  # it is in the single folder for macOS
    assert set(found) == set(positions.values())
    for platform, (magic, at, processor) in FORMATS.items():
        if platform not in positions:
            continue
        content = found[positions[platform]]
        if fmi == 2 and platform == "x86_64-darwin":
            assert content[:8] == struct.pack(">II", 0xCAFEBABE, 2)
            continue
        assert content.startswith(magic)
        assert struct.unpack_from("<H", content, at)[0] == processor
        assert f"fmi{fmi}DoStep".encode() in content
        assert b"mf96_forces" not in content


@pytest.mark.skipif(not sys.platform.startswith("linux"), reason="loads a Linux binary")
def test_the_linux_binary_computes_what_the_hosts_does(ziglang, fmus, hosts, tires, fmi, tmp_path):
    platform = binaries.host_platform()
    fmus["crossed", fmi] = export(tires["first"], tmp_path / f"first_{fmi}.fmu", fmi=fmi, platforms=[platform])
    ours, crossed = (hosts(name, fmi).start() for name in ("first", "crossed"))
    for alpha in (-0.3, 0.0, 0.02, 0.9):
        given = {"alpha": alpha, "kappa": 0.1 - alpha, "gamma": 0.03, "Fz": 700.0}
        assert crossed.forces(**given) == pytest.approx(ours.forces(**given), rel=1e-13, abs=1e-9)


@pytest.mark.skipif(not sys.platform.startswith("linux"), reason="reads a Linux binary")
def test_the_linux_binary_requires_an_old_c_library_only(ziglang, tires, tmp_path):
    if not shutil.which("objdump"):
        pytest.skip("needs objdump")
    (content,) = packed(export(tires["first"], tmp_path / "tire.fmu", platforms="x86_64-linux")).values()
    (tmp_path / "tire.so").write_bytes(content)
    command = ["objdump", "-T", tmp_path / "tire.so"]
    symbols = subprocess.run(command, capture_output=True, text=True, check=True).stdout
    versions = {
        tuple(map(int, word.split("_")[1].strip("()").split("."))) for word in symbols.split() if "GLIBC_" in word
    }
    assert versions
    assert max(versions) <= (2, 17)


def test_equal_tires_give_equal_bytes_for_every_machine(ziglang, tires, tmp_path, monkeypatch):
    platforms = ["aarch64-linux", "aarch64-darwin"]
    first = export(tires["first"], tmp_path / "tire.fmu", platforms=platforms).read_bytes()
    monkeypatch.setenv("TIREFMU_CACHE", str(tmp_path / "fresh cache"))
    assert export(tires["first"], tmp_path / "tire.fmu", platforms=platforms).read_bytes() == first
