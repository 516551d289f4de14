"""Export of a tire as a library with the Standard Tyre Interface (TYDEX-STI), for multibody programs.

A call of the interface builds an instance for Model Exchange from the compiled-in values and the states of the host, so
that nothing is stored between calls.
"""

from __future__ import annotations

import os
from collections.abc import Iterable
from importlib.resources import files
from pathlib import Path

from ...boundary.errors import FmuError, path_from
from ...boundary.escaping import c_string
from ...fmu.description.hub_variables import known_value
from ...fmu.description.interface import Interface, interface
from ...fmu.packaging.binaries import SYSTEMS, binary, chosen_platforms, host_binary, host_platform
from ...fmu.packaging.cross_compiler import PLATFORMS, ziglang
from ...fmu.packaging.export import fmi_headers, write_file
from ...fmu.packaging.sources import BUILT_IN, CONFIG, VALUES, code_files, common_files
from ...fmu.packaging.written_headers import model_config, tire_values
from ...symbolic.printers.definitions import comment
from ...tires import Tire, TireLike, tire_from
from ...tires.code.compiler import suffix

#: The subroutines and their header, beside this module; the header that is written for a tire.
OWN, HEADER = ("sti.c", "sti_entries.c", "sti.h"), "sti_tire.h"
#: Texts of the interface have 256 characters with their end.
_LONGEST_TITLE = 200


def export_sti(
    tire: TireLike,
    path: str | os.PathLike[str],
    *,
    platforms: str | Iterable[str] = "host",
) -> Path:
    """Write a tire as a library with the tyre subroutine of the Standard Tyre Interface.

    The library has the equations of an FMU with hub inputs. Its subroutines are ``tirefmu_sti_`` (Fortran, road of
    Adams), ``tirefmu_sti`` (C, as MotionSolve calls it) and ``dtyre_`` (Fortran, road of STI 1.2).

    Parameters
    ----------
    tire : Tire, path of a .tir file, or name of a published tire
        In any signs.
    path : path-like
        The library to write; it ends with .so (Linux), .dll (Windows) or .dylib (macOS).
    platforms : str or iterable of str
        One platform, as for `export`. ``host`` with the ending of another system is the platform of that system with an
        x86_64 processor.

    Returns
    -------
    Path
        The file written.

    Raises
    ------
    FmuError
        If the platform does not have libraries with this ending, there is no compiler or it fails, or the file cannot
        be written. No partial file remains.
    UnknownName
        If there is neither a file nor a published tire of that name.
    WrongType
        If the tire or the path is of another type.

    References
    ----------
    TYDEX-Format and STI, release 1.3 (1997); docs/sti.md names the sources for the calling conventions.

    Examples
    --------
    >>> from tempfile import TemporaryDirectory
    >>> with TemporaryDirectory() as folder:
    ...     export_sti("trento_hoosier", Path(folder) / f"libtire{suffix()}").stem
    'libtire'
    """
    requested, target = chosen_platforms(platforms), path_from(path)
    platform = _platform(requested, target)
    iso = tire_from(tire).in_signs("iso")
    sources, tire_files = library_sources(interface(iso, inputs="hub"), tire_header(iso)), (*OWN, HEADER)
    include = fmi_headers()
    if platform == host_platform():
        write_file(target, host_binary(sources, iso.model, include, tire_files))
    else:
        write_file(target, binary(sources, iso.model, include, ziglang(platform), tire_files))
    return target


def library_sources(shown: Interface, tire_header: str) -> dict[str, bytes]:
    """Return every source file of a library, by name.

    `shown`: with hub inputs. `tire_header`: content of sti_tire.h.
    """
    texts = {name: (files(__package__) / name).read_bytes() for name in OWN}
    written = {CONFIG: model_config(shown), VALUES: tire_values(shown, ""), HEADER: tire_header}
    shared = code_files((BUILT_IN, *common_files(shown)), shown)
    return {**texts, **shared, **{name: text.encode() for name, text in written.items()}}


def tire_header(tire: Tire) -> str:
    """Return the header with the data of a library's tire, without the values of its equations.

    >>> from tirefmu.tires import published
    >>> print(tire_header(published("trento_hoosier")).splitlines()[1])
    #define TIRE_TITLE "tirefmu: Hoosier 6.0/18.0-10 LCO (Trento team 6), Magic Formula 1996, Trento form"
    """
    title = f"tirefmu: {tire.name or 'tire'}, {tire.symbolic_model.title}"[:_LONGEST_TITLE]
    lines = [
        comment("Written by tirefmu for one tire."),
        f"#define TIRE_TITLE {c_string(title)}",
        f"#define TIRE_WIDTH {float(known_value(tire, 'WIDTH', 0.0))!r}",
    ]
    return "\n".join(lines) + "\n"


def _platform(requested: tuple[str, ...], target: Path) -> str:
    """Return the platform of a library."""
    endings = {name: suffix(platform.system) for name, platform in PLATFORMS.items()}
    if len(requested) != 1:
        raise FmuError(f"a library is for one platform, not for {', '.join(requested)}")
    named = host_platform() if requested == ("host",) else requested[0]
    if target.suffix not in endings.values():
        raise FmuError(f"{target.name}: the name of a library ends with {', '.join(sorted(set(endings.values())))}")
    if suffix(_system(named)) == target.suffix:
        return named
    if requested == ("host",):
        return next(name for name, ending in endings.items() if ending == target.suffix)
    raise FmuError(f"{target.name}: libraries for {named} end with {suffix(_system(named))}")


def _system(platform: str) -> str:
    """Return the system of a platform, named as by sys.platform."""
    return next(system for system, word in SYSTEMS.items() if word == platform.partition("-")[2])
