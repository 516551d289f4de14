"""The system's C compiler: search, calls, and storage of its shared libraries by content.

A library is built once for its sources, flags and compiler, and reused from the cache at the next start. Without a
compiler, everything except C code and native FMUs still works.
"""

from __future__ import annotations

import ctypes
import hashlib
import os
import platform
import shlex
import shutil
import subprocess
import sys
from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path
from typing import Any

from ...boundary.errors import TirefmuError, writing
from ...boundary.escaping import visible
from .build_cache import cached

#: Characters of a compiler's line that a message quotes.
LONGEST_LINE = 300
FLAGS = ("-std=c99", "-O2", "-fno-math-errno", "-fvisibility=hidden")


class CompilerError(TirefmuError):
    """There is no C compiler, or it refused a source."""


class NoCompilerError(CompilerError):
    """There is no C compiler."""


def suffix(system: str = sys.platform) -> str:
    """Return the extension of shared libraries on a system named as by sys.platform.

    >>> suffix("linux"), suffix("win32")
    ('.so', '.dll')
    """
    return {"win32": ".dll", "darwin": ".dylib"}.get(system, ".so")


@dataclass(frozen=True)
class CrossCompiler:
    """A C compiler for another machine than this one.

    - `command`: the compiler with the options to build for that machine.
    - `system`: that machine's, named as by sys.platform.
    - `version`: with another version, libraries are built again.
    """

    command: tuple[str, ...]
    system: str
    version: str


def find_compiler() -> list[str]:
    """Return the command of the C compiler: $CC, or cc, gcc or clang on the path.

    Raises `CompilerError` if there is none; the message states what to install.
    """
    named = os.environ.get("CC", "").strip()
    if named:
        try:
            command = shlex.split(named)
        except ValueError:  # a quote that is not closed
            command = [named]
        if shutil.which(command[0]):
            return command
        raise CompilerError(f"CC is {named!r}, which cannot be run")
    for name in ("cc", "gcc", "clang"):
        path = shutil.which(name)
        if path:
            return [path]
    raise NoCompilerError("no C compiler found: install gcc or clang, or set CC")


def instruction_set() -> str:
    """Return which instruction set the kernels use: TIREFMU_MACHINE, as the compiler's -march names it.

    Such as x86-64 (SSE2), x86-64-v3 (AVX2) or x86-64-v4 (AVX-512), to see what another processor would compute;
    this machine's own by default.
    """
    return os.environ.get("TIREFMU_MACHINE", "").strip() or "native"


def shared_library(
    name: str,
    sources: Sequence[Path],
    *,
    headers: Sequence[Path] = (),
    include: Sequence[Path] = (),
    flags: Sequence[str] = (),
    libraries: Sequence[str] = ("-lm",),
    machine: str = "",
    cross: CrossCompiler | None = None,
    rebuild: bool = False,
) -> Path:
    """Return a shared library built from C sources or object files, from the cache if it is there.

    `name`: prefix of the file name. `sources`, `headers`: sources to compile and headers that they include; if their
    content changes, the library is built again. `include`: folders to search for headers. `flags`: further compiler
    flags. `libraries`: libraries to link. `machine`: further dependence of the flags in addition to the compiler, such
    as the processor. `cross`: build for another machine. `rebuild`: build it again although it exists: it cannot be
    loaded. Raises `CompilerError` if there is no compiler, it fails (the message has its errors), or the library cannot
    be written anywhere.
    """
    system = cross.system if cross else sys.platform
    defined = ["-Wl,-z,defs"] if system.startswith("linux") else []
    options = ["-shared", *flags, *defined]
    return _built(name, suffix(system), sources, headers, include, options, libraries, machine, cross, rebuild)


def loaded_library(name: str, sources: Sequence[Path], **options: Any) -> ctypes.CDLL:
    """Load and return a shared library; an existing one that cannot be loaded is built again.

    `name`, `sources`, `**options`: as for `shared_library`. Raises `CompilerError`: as `shared_library`, or if a
    library that was just built cannot be loaded.
    """
    try:
        return ctypes.CDLL(str(shared_library(name, sources, **options)))
    except OSError:  # for instance built on another system that shares the cache
        path = shared_library(name, sources, **options, rebuild=True)
    try:
        return ctypes.CDLL(str(path))
    except OSError as error:
        raise CompilerError(f"{path.name} is built, but cannot be loaded: {error}") from error


def compiled_object(
    name: str,
    source: Path,
    *,
    headers: Sequence[Path] = (),
    include: Sequence[Path] = (),
    flags: Sequence[str] = (),
    cross: CrossCompiler | None = None,
) -> Path:
    """Return the object file of a C source, from the cache if it is there, for `shared_library` to link.

    Sources that take long to compile and are equal in many libraries are compiled once.

    `name`: prefix of the file name. `headers`, `include`, `flags`, `cross`: as for `shared_library`. Raises
    `CompilerError`: as `shared_library`.
    """
    return _built(name, ".o", [source], headers, include, ["-c", *flags], [], cross=cross)


def _built(
    name: str,
    ending: str,
    sources: Sequence[Path],
    headers: Sequence[Path],
    include: Sequence[Path],
    flags: Sequence[str],
    libraries: Sequence[str],
    machine: str = "",
    cross: CrossCompiler | None = None,
    rebuild: bool = False,
) -> Path:
    """Return the file that the compiler makes of all sources, from the cache where it is there."""
    compiler = list(cross.command) if cross else find_compiler()
    system = cross.system if cross else sys.platform
    built_by = cross.version if cross else platform.machine()
    options = [*FLAGS, *([] if system == "win32" else ["-fPIC"]), *flags]
    digest = hashlib.sha256("\0".join([*compiler, *options, *libraries, built_by, system, machine]).encode())
    for path in [*sources, *headers]:
        digest.update(path.name.encode() + b"\0" + path.read_bytes())
    folders = [f"-I{folder}" for folder in include]
    file = f"{name}{ending}"  # linkers on macOS write it into the library

    def build(folder: Path) -> None:
        _run([*compiler, *options, *folders, *map(str, sources), "-o", str(folder / file), *libraries])

    with writing(file, CompilerError):
        return cached(f"{name}-{digest.hexdigest()[:24]}", build, rebuild=rebuild) / file


def _run(command: list[str]) -> None:
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    if done.returncode != 0:
        raise CompilerError(f"{Path(command[0]).name} failed: {_errors(done.stderr or done.stdout)}")


def _errors(output: str) -> str:
    r"""Return the first errors of a compiler or linker, or its last lines if it reports none as such.

    >>> _errors("a.c: In function 'f':\na.c:1:2: warning: unused 'x'\na.c:3:1: error: expected ';'\n  3 | }\n")
    "a.c:3:1: error: expected ';'"
    """
    lines = [line.strip() for line in output.strip().splitlines()]
    reasons = [line for line in lines if "error:" in line or "undefined reference" in line]
    return " / ".join(visible(line)[:LONGEST_LINE] for line in (reasons[:3] or lines[-3:]))


@lru_cache(maxsize=1)
def processor() -> str:
    """Return an identifier of this processor's instruction set: code for one may not run on another.

    >>> processor() == processor()
    True
    """
    described = Path("/proc/cpuinfo")
    if described.is_file():
        lines = described.read_text(encoding="utf-8", errors="replace").splitlines()
        fields = {line.split(":")[0].strip(): line for line in reversed(lines) if ":" in line}
        return "\n".join(fields.get(key, "") for key in ("vendor_id", "model name", "flags", "Features", "CPU part"))
    return f"{platform.machine()} {platform.processor()}"
