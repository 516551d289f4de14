"""The binaries of an FMU: for this machine by the host's own compiler, for others by ziglang."""

from __future__ import annotations

import sys
import tempfile
from collections.abc import Iterable, Mapping
from concurrent.futures import ThreadPoolExecutor
from importlib.resources import files
from pathlib import Path
from platform import machine

from tirefmu.symbolic.errors import FmuError
from tirefmu.tires.code.compiler import (
    CompilerError,
    CrossCompiler,
    NoCompilerError,
    compiled_object,
    shared_library,
    suffix,
)

from .cross import FOLDERS_2, PLATFORMS, has_ziglang, universal, ziglang
from .model_code import model_files

#: By sys.platform: FMI 3's name of the system.
SYSTEMS = {"linux": "linux", "darwin": "darwin", "win32": "windows"}
MACHINES = {"x86_64": "x86_64", "amd64": "x86_64", "aarch64": "aarch64", "arm64": "aarch64"}

#: One operation, one rounding, on every machine; and nothing in the binary that nobody can call.
FLAGS = ("-ffp-contract=off", "-ffunction-sections", "-fdata-sections")
#: For the model's code that a host does not wait for.
SMALL = ("-Os", "-fno-inline")
#: Windows gives a library all that it needs but for windows.c, where zig would pack a C runtime into each.
RUNTIME = "windows.c"
SYSTEM = tuple(f"-lapi-ms-win-crt-{part}-l1-1-0" for part in ("heap", "math", "private", "stdio", "string"))
LINK = {
    "linux": ("-s", "-Wl,--gc-sections"),
    # A library for Macs carries its own name, which would be the path it was built at.
    "darwin": ("-Wl,-dead_strip", "-Wl,-x", "-Wl,-S", "-Wl,-install_name,@rpath/fmu.dylib"),
    "win32": ("-s", "-static-libgcc", "-Wl,--gc-sections"),
}


def host_platform() -> str:
    """Return FMI 3's name of this machine.

    Returns
    -------
    str
        Such as ``x86_64-linux``.

    Raises
    ------
    FmuError
        If FMUs know no name for this system or processor.

    Examples
    --------
    >>> host_platform() in PLATFORMS or host_platform() == "aarch64-windows"
    True
    """
    architecture = MACHINES.get(machine().lower())
    if sys.platform not in SYSTEMS or architecture is None:
        raise FmuError(f"FMUs have no name for {machine()} with {sys.platform}")
    return f"{architecture}-{SYSTEMS[sys.platform]}"


def chosen_platforms(platforms: str | Iterable[str]) -> tuple[str, ...]:
    """Return the platforms that are asked for, each once.

    Parameters
    ----------
    platforms : str or iterable of str
        ``host`` (this machine, by its own compiler), ``all``, or names of FMI 3, alone, in a list or with
        commas between them.

    Returns
    -------
    tuple of str
        ``host`` and names of `PLATFORMS`.

    Raises
    ------
    FmuError
        If one is unknown, or there is none.

    Examples
    --------
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
            raise FmuError(f"platform {name!r} is not known: known are host, all, {', '.join(PLATFORMS)}")
    if not names:
        raise FmuError("no platform is given")
    return tuple(names)


def binary_path(fmi: int, identifier: str, platform: str | None = None) -> str:
    """Return where a platform's binary stands inside an FMU.

    Parameters
    ----------
    fmi : int
        2 or 3.
    identifier : str
        The model identifier.
    platform : str, optional
        FMI 3's name; this machine's where None.

    Returns
    -------
    str
        Such as ``binaries/x86_64-linux/tire.so`` in FMI 3 and ``binaries/linux64/tire.so`` in FMI 2.

    Raises
    ------
    FmuError
        If FMUs know no name for this system or processor.

    References
    ----------
    FMI 2.0.5, section 2.3: names of its own for x86, those of FMI 3 for every other processor.

    Examples
    --------
    >>> binary_path(2, "tire", "x86_64-windows"), binary_path(3, "tire", "aarch64-darwin")
    ('binaries/win64/tire.dll', 'binaries/aarch64-darwin/tire.dylib')
    """
    name = platform or host_platform()
    word = name.partition("-")[2]
    # Tools for other processors look into the folder of x86 when they run what was built where they run.
    known_as = f"x86_64-{word}" if platform is None else name
    folder = name if fmi == 3 else FOLDERS_2.get(known_as, name)
    system = next(key for key, value in SYSTEMS.items() if value == word)
    return f"binaries/{folder}/{identifier}{suffix(system)}"


def binaries(
    sources: Mapping[str, bytes], model: str, include: Path, fmi: int, identifier: str, platforms: Iterable[str]
) -> dict[str, bytes]:
    """Return the shared libraries of an FMU by their paths inside it.

    Parameters
    ----------
    sources : mapping of str to bytes
        C files and their headers by name.
    model : str
        Name of the model. Its generated code is most of the work, and is kept for the model's next tire.
    include : Path
        Folder of the FMI standard's headers.
    fmi : int
        2 or 3.
    identifier : str
        The model identifier.
    platforms : iterable of str
        As from `chosen_platforms`.

    Returns
    -------
    dict of str to bytes
        From the cache where the same sources were compiled before.

    Raises
    ------
    FmuError
        If there is no compiler, or it fails; carries its first lines.
    """
    asked = list(platforms)
    if asked == ["host"]:
        return {binary_path(fmi, identifier): _host_binary(sources, model, include)}
    compilers = {name: None if name == "host" else ziglang(name) for name in asked}
    # Two at a time: a compiler waits for the disk, and what zig sets up for Windows at its first time is long.
    with ThreadPoolExecutor(2) as pool:
        jobs = {
            host_platform() if cross is None else name: pool.submit(binary, sources, model, include, cross)
            for name, cross in sorted(compilers.items(), key=lambda item: not item[0].endswith("windows"))
        }
        built = {name: job.result() for name, job in sorted(jobs.items())}
    packed = {binary_path(fmi, identifier, name): library for name, library in built.items()}
    if fmi == 2 and "aarch64-darwin" in built:
        # Many hosts look into FMI 2's one folder for Macs only: it serves both processors, and once is enough.
        macs = {binary_path(2, identifier, name): name for name in built if name.endswith("-darwin")}
        packed = {path: library for path, library in packed.items() if path not in macs or len(macs) == 1}
        packed[binary_path(2, identifier, "x86_64-darwin")] = universal([built[name] for name in macs.values()])
    return packed


def binary(sources: Mapping[str, bytes], model: str, include: Path, cross: CrossCompiler | None = None) -> bytes:
    """Return the bytes of one shared library.

    Parameters
    ----------
    sources, model, include
        As for `binaries`.
    cross : CrossCompiler, optional
        For another machine than this one.

    Returns
    -------
    bytes

    Raises
    ------
    FmuError
        If there is no compiler, or it fails; carries its first lines.
    """
    generated = [file for file in model_files(model) if file in sources]
    own = sorted(file for file in sources if file.endswith(".c") and file not in generated)
    system, bare = (cross.system if cross else sys.platform), cross is not None and cross.system == "win32"
    with tempfile.TemporaryDirectory(prefix="tirefmu-") as name:
        folder = Path(name)
        for file, content in sources.items():
            (folder / file).write_bytes(content)
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
            headers = sorted([*(folder / file for file in sources if file.endswith(".h")), *include.glob("fmi*.h")])
            wrapper = [folder / file for file in own]
            if bare:  # the runtime's headers are for compiling only
                (folder / RUNTIME).write_bytes((files("tirefmu.fmu") / "wrapper" / RUNTIME).read_bytes())
                wrapper = [
                    compiled_object("fmu", file, headers=headers, include=[folder, include], flags=FLAGS, cross=cross)
                    for file in (*wrapper, folder / RUNTIME)
                ]
            library = shared_library(
                "fmu",
                [*wrapper, *compiled],
                headers=headers,
                include=[folder, include],
                flags=[*FLAGS, *LINK[system], *(["-nostdlib"] if bare else [])],
                libraries=SYSTEM if bare else ["-lm"],
                cross=cross,
            )
        except CompilerError as error:
            raise FmuError(f"the binary of the FMU cannot be built: {error}") from error
        return library.read_bytes()


def _host_binary(sources: Mapping[str, bytes], model: str, include: Path) -> bytes:
    """Return this machine's library, by ziglang where that is the only compiler."""
    try:
        return binary(sources, model, include)
    except FmuError as error:
        if not isinstance(error.__cause__, NoCompilerError):
            raise
        if has_ziglang() and host_platform() in PLATFORMS:
            return binary(sources, model, include, ziglang(host_platform()))
        raise FmuError(f"{error}, or the package's extra: pip install 'tirefmu[cross]'") from error.__cause__
