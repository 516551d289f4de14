"""The binary of an FMU for this machine, by the host's own compiler."""

from __future__ import annotations

import sys
import tempfile
from collections.abc import Mapping
from pathlib import Path
from platform import machine

from tirefmu.symbolic.errors import FmuError
from tirefmu.tires.compiler import SUFFIX, CompilerError, compiled_object, shared_library

#: By sys.platform: FMI 3's name of the system, and FMI 2's.
SYSTEMS = {"linux": ("linux", "linux"), "darwin": ("darwin", "darwin"), "win32": ("windows", "win")}
MACHINES = {"x86_64": "x86_64", "amd64": "x86_64", "aarch64": "aarch64", "arm64": "aarch64"}

#: One operation, one rounding, on every machine; and nothing in the binary that nobody can call.
FLAGS = ("-ffp-contract=off", "-ffunction-sections", "-fdata-sections")
LINK = {
    "linux": ("-s", "-Wl,--gc-sections"),
    "darwin": ("-Wl,-dead_strip",),
    "win32": ("-s", "-static-libgcc", "-Wl,--gc-sections"),
}


def binary_path(fmi: int, identifier: str) -> str:
    """Return where this machine's binary stands inside an FMU.

    Parameters
    ----------
    fmi : int
        2 or 3.
    identifier : str
        The model identifier.

    Returns
    -------
    str
        Such as ``binaries/x86_64-linux/tire.so`` in FMI 3 and ``binaries/linux64/tire.so`` in FMI 2, which
        has no word for the processor.

    Raises
    ------
    FmuError
        If FMUs know no name for this system or processor.

    Examples
    --------
    >>> binary_path(3, "tire").split("/")[0]
    'binaries'
    """
    architecture = MACHINES.get(machine().lower())
    if sys.platform not in SYSTEMS or architecture is None:
        raise FmuError(f"FMUs have no name for {machine()} with {sys.platform}")
    system, system_2 = SYSTEMS[sys.platform]
    folder = f"{system_2}64" if fmi == 2 else f"{architecture}-{system}"
    return f"binaries/{folder}/{identifier}{SUFFIX}"


def binary(sources: Mapping[str, bytes], model: str, include: Path) -> bytes:
    """Return the bytes of a shared library for this machine.

    Parameters
    ----------
    sources : mapping of str to bytes
        C files and their headers by name.
    model : str
        Name of the model. Its generated code is most of the work, and is kept for the model's next tire.
    include : Path
        Folder of the FMI standard's headers.

    Returns
    -------
    bytes
        From the cache where the same sources were compiled before.

    Raises
    ------
    FmuError
        If there is no compiler, or it fails; carries its first lines.
    """
    own = sorted(file for file in sources if file.endswith(".c") and file != f"{model}.c")
    with tempfile.TemporaryDirectory(prefix="tirefmu-") as name:
        folder = Path(name)
        for file, content in sources.items():
            (folder / file).write_bytes(content)
        code, header = folder / f"{model}.c", folder / f"{model}.h"
        try:
            compiled = compiled_object(f"fmu-{model}", code, headers=[header], include=[folder], flags=FLAGS)
            library = shared_library(
                "fmu",
                [*(folder / file for file in own), compiled],
                headers=sorted([*(folder / file for file in sources if file.endswith(".h")), *include.glob("fmi*.h")]),
                include=[folder, include],
                flags=[*FLAGS, *LINK[sys.platform]],
            )
        except CompilerError as error:
            raise FmuError(f"the binary of the FMU cannot be built: {error}") from error
        return library.read_bytes()
