"""The binaries of an FMU: the system's compiler builds for this machine, ziglang for other platforms."""

from __future__ import annotations

import sys
import tempfile
from collections.abc import Collection, Iterable, Mapping
from concurrent.futures import ThreadPoolExecutor
from importlib.resources import files
from pathlib import Path
from platform import machine

from ...boundary.errors import FmuError
from ...tires.code.compiler import (
    CompilerError,
    CrossCompiler,
    NoCompilerError,
    compiled_object,
    shared_library,
    suffix,
)
from .cross_compiler import FOLDERS_2, PLATFORMS, has_ziglang, universal, ziglang
from .model_code import model_files
from .sources import BUILT_IN, PRINTED, VALUES, WRAPPER

#: FMI 3's names of the systems, by sys.platform.
SYSTEMS = {"linux": "linux", "darwin": "darwin", "win32": "windows"}
MACHINES = {"x86_64": "x86_64", "amd64": "x86_64", "aarch64": "aarch64", "arm64": "aarch64"}

#: Each operation is rounded once on every machine, and none is watched for traps; the binary contains no
#: unreachable functions and no tables for exceptions, which C does not have.
FLAGS = (
    "-ffp-contract=off", "-fno-trapping-math", "-ffunction-sections", "-fdata-sections",
    "-fno-asynchronous-unwind-tables", "-fno-unwind-tables",
)  # fmt: skip
#: For code that is called rarely: a part of the model's code, and the files of the wrapper that no step calls.
SMALL = ("-Os", "-fno-inline")
RARE = frozenset(
    {
        "chain_rule.c", "changes.c", "derivatives.c", "events.c", "fmi3_not_offered.c", "hub_derivatives.c",
        "instance.c", "life_cycle.c", "saved_state.c",
    }
)  # fmt: skip
#: The version of the standard that a file is for; the others are for all.
VERSIONS = {file: version for version, names in WRAPPER.items() for file in names}
#: On Windows the system's libraries and windows.c replace the C runtime that zig would link into each binary.
RUNTIME = "windows.c"
SYSTEM = tuple(f"-lapi-ms-win-crt-{part}-l1-1-0" for part in ("heap", "math", "private", "stdio", "string"))
LINK = {
    "linux": ("-s", "-Wl,--gc-sections"),
    # A library for macOS contains its own name, by default the path of the build.
    "darwin": ("-Wl,-dead_strip", "-Wl,-x", "-Wl,-S", "-Wl,-install_name,@rpath/fmu.dylib"),
    "win32": ("-s", "-static-libgcc", "-Wl,--gc-sections"),
}


def host_platform() -> str:
    """Return FMI 3's name of this machine.

    Returns: such as ``x86_64-linux``. Raises `FmuError` if FMI has no name for this system or processor.

    >>> host_platform() in PLATFORMS or host_platform() == "aarch64-windows"
    True
    """
    architecture = MACHINES.get(machine().lower())
    if sys.platform not in SYSTEMS or architecture is None:
        raise FmuError(f"FMI has no platform name for {machine()} with {sys.platform}")
    return f"{architecture}-{SYSTEMS[sys.platform]}"


def chosen_platforms(platforms: str | Iterable[str]) -> tuple[str, ...]:
    """Return the requested platforms, without duplicates.

    `platforms`: ``host`` (this machine, with the system's compiler), ``all``, or FMI 3 names: one, several separated by
    commas, or an iterable. Returns: ``host`` and names of `PLATFORMS`. Raises `FmuError` if one is unknown, or none is
    given.

    >>> chosen_platforms("x86_64-windows, x86_64-linux")
    ('x86_64-windows', 'x86_64-linux')
    >>> chosen_platforms("all") == tuple(PLATFORMS)
    True
    """
    parts = platforms.split(",") if isinstance(platforms, str) else platforms
    names = list(dict.fromkeys(name.strip() for name in parts))
    if "all" in names:
        return tuple(PLATFORMS)
    for name in names:
        if name not in ("host", *PLATFORMS):
            raise FmuError(f"platform {name!r} is unknown: known platforms are host, all, {', '.join(PLATFORMS)}")
    if not names:
        raise FmuError("no platform is given")
    return tuple(names)


def binary_path(fmi: int, identifier: str, platform: str | None = None) -> str:
    """Return the path of a platform's binary inside an FMU.

    `fmi`: 2 or 3. `identifier`: the model identifier. `platform`: FMI 3's name; None for this machine. Returns: such as
    ``binaries/x86_64-linux/tire.so`` in FMI 3 and ``binaries/linux64/tire.so`` in FMI 2. Raises `FmuError` if FMI has
    no name for this system or processor.

    Source: FMI 2.0.5, section 2.3, for x86; FMI 2 defines no names for other processors, which use those of FMI 3.

    >>> binary_path(2, "tire", "x86_64-windows"), binary_path(3, "tire", "aarch64-darwin")
    ('binaries/win64/tire.dll', 'binaries/aarch64-darwin/tire.dylib')
    """
    name = platform or host_platform()
    word = name.partition("-")[2]
    # FMI 2 tools on other processors search the x86 folder for binaries of their own machine.
    folder_name = f"x86_64-{word}" if platform is None else name
    folder = name if fmi == 3 else FOLDERS_2.get(folder_name, name)
    system = next(key for key, value in SYSTEMS.items() if value == word)
    return f"binaries/{folder}/{identifier}{suffix(system)}"


def binaries(
    sources: Mapping[str, bytes],
    model: str,
    include: Path,
    fmi: int,
    identifier: str,
    platforms: Iterable[str],
    ready: Mapping[str, bytes] | None = None,
) -> dict[str, bytes]:
    """Return the shared libraries of an FMU by their paths inside it.

    `sources`: C files and their headers by name. `model`: name of the model. Compiled code of a model is cached, as it
    takes most of the time. `include`: folder of the FMI standard's headers. `fmi`: 2 or 3. `identifier`: the model
    identifier. `platforms`: as from `chosen_platforms`. `ready`: binaries that need no compiler, by FMI 3's name of the
    platform. Returns: from the cache if the same sources were compiled before. Raises `FmuError` if there is no
    compiler, or it fails; the message has its errors.
    """
    requested, ready = list(platforms), ready or {}
    if requested == ["host"]:
        return {binary_path(fmi, identifier): ready.get(host_platform()) or host_binary(sources, model, include)}
    names = {name: host_platform() if name == "host" else name for name in requested}
    compilers = {name: None if name == "host" else ziglang(name) for name, named in names.items() if named not in ready}
    # Two in parallel: a compiler waits for the disk, and zig's first build for Windows is slow.
    with ThreadPoolExecutor(2) as pool:
        jobs = {
            host_platform() if cross is None else name: pool.submit(binary, sources, model, include, cross)
            for name, cross in sorted(compilers.items(), key=lambda item: not item[0].endswith("windows"))
        }
        compiled = {name: job.result() for name, job in jobs.items()}
    built = {**{name: ready[name] for name in names.values() if name in ready}, **compiled}
    built = dict(sorted(built.items()))
    packed = {binary_path(fmi, identifier, name): library for name, library in built.items()}
    if fmi == 2 and "aarch64-darwin" in built:
        # Many hosts search FMI 2's single folder for macOS only: it receives one binary for both processors.
        macs = {binary_path(2, identifier, name): name for name in built if name.endswith("-darwin")}
        packed = {path: library for path, library in packed.items() if path not in macs or len(macs) == 1}
        packed[binary_path(2, identifier, "x86_64-darwin")] = universal([built[name] for name in macs.values()])
    return packed


def binary(
    sources: Mapping[str, bytes],
    model: str,
    include: Path,
    cross: CrossCompiler | None = None,
    tire_files: Collection[str] = (),
) -> bytes:
    """Return the bytes of one shared library.

    `sources`, `model`, `include`: as in `binaries`. `cross`: none for this machine. `tire_files`: the sources for one
    tire, beside its values; a header of them is in a separate folder. Raises `FmuError` if there is no compiler, or it
    fails; the message has its errors.
    """
    generated = [file for file in model_files(model) if file in sources]
    wrapper_files = sorted(file for file in sources if file.endswith(".c") and file not in generated)
    system, bare = (cross.system if cross else sys.platform), cross is not None and cross.system == "win32"
    with tempfile.TemporaryDirectory(prefix="tirefmu-") as name:
        folder, of_tire = Path(name), Path(name) / "tire"
        of_tire.mkdir()
        for file, content in sources.items():
            (of_tire if file in (VALUES, *tire_files) and file.endswith(".h") else folder).joinpath(file).write_bytes(
                content
            )
        header = folder / f"{model}.h"
        try:
            compiled = [
                compiled_object(
                    f"fmu-{Path(file).stem}",
                    folder / file,
                    headers=[header],
                    include=[folder],
                    flags=[*FLAGS, *(SMALL if file != f"{model}.c" else ())],
                    cross=cross,
                )
                for file in generated
            ]
            common = sorted([*folder.glob("*.h"), *include.glob("fmi*.h")])
            headers = [*common, *sorted(of_tire.glob("*.h"))]
            parts = [folder / file for file in wrapper_files]
            if bare:  # the runtime's headers are needed for compiling only
                (folder / RUNTIME).write_bytes((files("tirefmu.fmu") / "wrapper" / RUNTIME).read_bytes())
                parts.append(folder / RUNTIME)

            if cross is None:  # what does not depend on the tire is compiled once for tires of the same structure
                linked = [part for part in parts if part.name in (BUILT_IN, *tire_files)]
                units: dict[str, list[Path]] = {}
                for part in sorted(set(parts).difference(linked)):
                    units.setdefault(_unit(part.name, sources[part.name]), []).append(part)
                for name, group in units.items():
                    unit = folder / name
                    unit.write_text("".join(f'#include "{part.name}"\n' for part in group), encoding="ascii")
                    read, searched = [*common, *group], [folder, include]
                    linked.append(compiled_object("fmu", unit, headers=read, include=searched, flags=FLAGS))
            else:  # where each call of the compiler takes long: those that must be small
                linked = [
                    compiled_object(
                        "fmu", part, headers=headers, include=[folder, of_tire, include],
                        flags=[*FLAGS, *(SMALL if part.name in RARE else ())], cross=cross,
                    ) if bare or part.name in RARE else part
                    for part in parts
                ]  # fmt: skip
            library = shared_library(
                "fmu",
                [*linked, *compiled],
                headers=headers,
                include=[folder, of_tire, include],
                flags=[*FLAGS, *LINK[system], *(["-nostdlib"] if bare else [])],
                libraries=SYSTEM if bare else ["-lm"],
                cross=cross,
            )
        except CompilerError as error:
            raise FmuError(f"the binary of the FMU cannot be built: {error}") from error
        return library.read_bytes()


def _unit(file: str, content: bytes) -> str:
    """Return the name of the file with which a file of the wrapper is compiled: the compiler takes longer to start.

    Apart are the files of one version of the standard, so that both share the rest, and those with another header that
    is printed: such headers define functions of the same names.
    """
    header = next((header for header in PRINTED if f'#include "{header}"'.encode() in content), PRINTED[0])
    return f"unit_{VERSIONS.get(file, '')}_{header[:-2]}.c"


def host_binary(sources: Mapping[str, bytes], model: str, include: Path, tire_files: Collection[str] = ()) -> bytes:
    """Return the bytes of this machine's library, built by ziglang if there is no other compiler.

    `sources`, `model`, `include`: as in `binaries`. `tire_files`: as in `binary`. Raises `FmuError`: as `binary`.
    """
    try:
        return binary(sources, model, include, None, tire_files)
    except FmuError as error:
        if not isinstance(error.__cause__, NoCompilerError):
            raise
        if has_ziglang() and host_platform() in PLATFORMS:
            return binary(sources, model, include, ziglang(host_platform()), tire_files)
        raise FmuError(f"{error}, or the package's extra: pip install 'tirefmu[cross]'") from error.__cause__
