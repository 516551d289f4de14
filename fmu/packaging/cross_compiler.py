"""The cross compiler for other platforms: ziglang, the package's extra `cross`."""

from __future__ import annotations

import importlib.metadata
import importlib.util
import struct
import sys
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from ...boundary.errors import FmuError
from ...tires.code.compiler import CrossCompiler


@dataclass(frozen=True)
class Platform:
    """A platform with an FMI name.

    - `target`: target name of zig. On Linux it has the C library of 2012, so that every later distribution loads the
      binary.
    - `system`: as in sys.platform.
    """

    target: str
    system: str


#: Platforms by FMI 3 name.
PLATFORMS = {
    "x86_64-linux": Platform("x86_64-linux-gnu.2.17", "linux"),
    "aarch64-linux": Platform("aarch64-linux-gnu.2.17", "linux"),
    "x86_64-windows": Platform("x86_64-windows-gnu", "win32"),
    "x86_64-darwin": Platform("x86_64-macos", "darwin"),
    "aarch64-darwin": Platform("aarch64-macos", "darwin"),
}
#: FMI 2's own names; other platforms have the names of FMI 3.
FOLDERS_2 = {"x86_64-linux": "linux64", "x86_64-windows": "win64", "x86_64-darwin": "darwin64"}


def has_ziglang() -> bool:
    """Return whether the extra is installed.

    >>> has_ziglang() in (True, False)
    True
    """
    return importlib.util.find_spec("ziglang") is not None


def ziglang(platform: str) -> CrossCompiler:
    """Return the compiler for a platform.

    `platform`: a name of `PLATFORMS`. Raises `FmuError` if the extra is not installed.
    """
    spec = importlib.util.find_spec("ziglang")
    if spec is None or spec.origin is None:
        raise FmuError(f"binaries for {platform} need the package's extra cross: pip install 'tirefmu[cross]'")
    zig = Path(spec.origin).with_name("zig.exe" if sys.platform == "win32" else "zig")
    there = PLATFORMS[platform]
    return CrossCompiler(
        # Without zig's traps for undefined behaviour: the same code as from other compilers.
        (str(zig), "cc", "-target", there.target, "-fno-sanitize=undefined"),
        there.system,
        importlib.metadata.version("ziglang"),
    )


#: Slices of a universal binary start at multiples of 2^14 bytes, the larger page size of both processors.
_ALIGNMENT = 14


def universal(binaries: Sequence[bytes]) -> bytes:
    """Return binaries for several macOS processors as one file.

    `binaries`: 64-bit Mach-O files for different processors. Raises `FmuError` if one is not such a file.

    Source: Apple's header mach-o/fat.h: big-endian, a header of magic and count, then type, subtype, offset, size and
    alignment of each.

    >>> universal([bytes.fromhex("cffaedfe 07000001 03000000"), bytes.fromhex("cffaedfe 0c000001 00000000")])[:8].hex()
    'cafebabe00000002'
    """
    page = 1 << _ALIGNMENT
    header = [struct.pack(">II", 0xCAFEBABE, len(binaries))]
    body = b""
    for content in binaries:
        magic, processor, subtype = struct.unpack("<III", content[:12])
        if magic != 0xFEEDFACF:
            raise FmuError("a binary for macOS is not a 64-bit Mach-O file")
        body += bytes(-len(body) % page)
        header.append(struct.pack(">IIIII", processor, subtype, page + len(body), len(content), _ALIGNMENT))
        body += content
    return b"".join(header).ljust(page, b"\0") + body
