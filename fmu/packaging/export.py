"""Export of a tire as an FMU."""

from __future__ import annotations

import hashlib
import importlib.util
import io
import json
import os
import re
import tempfile
import uuid
import zipfile
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any

from ...boundary.bounded_file import write_whole
from ...boundary.errors import FmuError, WrongType, path_from, writing
from ...boundary.named_options import named
from ...symbolic.reserved import C_KEYWORDS
from ...tires import Tire, TireLike, tire_from, write_tir
from ...tires.property_file.names import not_measured
from ..description.arrays import with_arrays
from ..description.documentation import header_license, index_html, license_of
from ..description.interface import AXES, HUB, INPUTS, Interface, interface
from ..description.model_description import Header, model_description, with_token
from ..description.terminals_and_icons import pictures
from ..description.variables import variables, with_remarks
from .binaries import binaries, chosen_platforms, host_platform
from .prebuilt import VALUES_FILE, generic, has_prebuilt, prebuilt_binary, values_file
from .python_variant import python_contents
from .sources import VALUES, build_description, c_files, sources
from .written_headers import tire_values

VERSIONS = (2, 3)
AXES_NAMES = {"iso": "ISO-W", "sae": "SAE"}
#: The FMI versions of each kind of FMU.
KINDS = {"native": VERSIONS, "pythonfmu": (2,)}


@named()
def export(
    tire: TireLike,
    path: str | os.PathLike[str],
    *,
    fmi: int | float | str | None = None,
    inputs: str = "slip",
    axes: str = "iso",
    quantities: bool = False,
    kind: str = "native",
    platforms: str | Iterable[str] = "host",
    arrays: bool = False,
) -> Path:
    """Write a tire as a native FMU for Co-Simulation and Model Exchange.

    The FMU runs without Python. Inputs and outputs have the names of the table columns. Every coefficient is a tunable
    parameter, and so are the conventions of `Tire.evaluate` (0 for the first value, 1 for the second). Outputs depend
    on the present inputs. In a tire with a relax_* effect the slips have a first-order lag from step to step, as in
    `evaluate` with ``hold=True``; they start in steady state at the end of initialization. A tire in other signs than
    those of the axes is converted. Equal tires and the same binaries or compiler give equal bytes.

    Parameters
    ----------
    tire : Tire, path of a .tir file, or name of a published tire
        In any signs.
    path : path-like
        The file to write. Its name is the model identifier as far as C allows.
    fmi : {3, 2, "3.0", "2.0"}, optional
        Version of the standard, as a number or a text; None for the latest version that the kind supports.
    inputs : {"slip", "wheel", "hub", "hub-torque"}
        ``slip``: kappa, alpha, gamma, Fz and so on, as the model reads them. ``wheel``: velocities V_x and V_y of
        the contact point and the angular speed omega of the wheel. The FMU computes slips and rolling radius, also at
        standstill and in reverse. A tire without relaxation has default relaxation lengths there; the FMU logs them.
        ``hub``: position, orientation and velocities of the wheel carrier, spin of the wheel and the road. The FMU
        computes contact point, load and slips, and the forces at the wheel centre. ``hub-torque``: the spin follows
        from drive and brake torque.
    axes : {"iso", "sae"}
        TYDEX W (z up), or SAE (z down, y to the right), as `signs` of `Tire.evaluate`.
    quantities : bool
        Whether every named quantity is an output.
    kind : {"native", "pythonfmu"}
        ``pythonfmu`` (FMI 2) contains Python instead of C: it needs Python with NumPy, and its files in ``resources``
        may be edited. It contains pythonfmu's binaries and has no directional derivatives.
    platforms : str or iterable of str
        For native FMUs. ``host``: this machine. ``all``, or FMI 3 names (x86_64-linux, aarch64-linux,
        x86_64-windows, x86_64-darwin, aarch64-darwin); on Linux for a C library of 2012 or later. A tire without
        added effects needs no compiler where the installation contains binaries, as wheels do. Otherwise the system's
        compiler builds for this machine, and ziglang, the package's extra `cross`, for the others.
    arrays : bool
        For hub inputs and FMI 3: vectors and the rotation matrix are array variables (r, R, v, ..., F, M) in place of
        scalars (r_x, ...).

    Returns
    -------
    Path
        The file written.

    Raises
    ------
    FmuError
        If the version, the inputs or a platform are unknown, there is no C compiler or it fails, or the file
        cannot be written. No partial file remains.
    UnknownName
        If there is neither a file nor a published tire of that name.
    WrongType
        If the tire, the path or the version is of another type.

    References
    ----------
    FMI 2.0.5 and 3.0.2, https://fmi-standard.org.

    Examples
    --------
    >>> from tempfile import TemporaryDirectory
    >>> with TemporaryDirectory() as folder:
    ...     export("trento_hoosier", Path(folder) / "tire.fmu", fmi="2.0").name
    'tire.fmu'
    """
    if kind not in KINDS:
        raise FmuError(f"kind {kind!r} is unknown: known kinds are {', '.join(KINDS)}")
    version = max(KINDS[kind]) if fmi is None else fmi_version(fmi)
    if version not in KINDS[kind]:
        raise FmuError(f"the {kind} variant supports FMI {KINDS[kind][0]} only, not FMI {version}")
    checked_interface(inputs, axes)
    if kind == "pythonfmu" and (inputs, axes, quantities) != ("slip", "iso", False):
        raise FmuError("the pythonfmu variant has slip inputs, ISO axes and the forces only")
    if arrays and (kind, version, inputs in HUB) != ("native", 3, True):
        raise FmuError(f"arrays need a native FMU of FMI 3 with hub inputs, not FMI {version} with {inputs} inputs")
    requested = chosen_platforms(platforms)
    target, tire = path_from(path), tire_from(tire)
    if kind == "pythonfmu" and tire.states:
        raise FmuError(f"the pythonfmu variant has no states of effects ({', '.join(tire.states)}): use kind native")
    identifier = c_identifier(target.stem)
    shown = interface(tire, inputs=inputs, axes=axes, quantities=quantities)
    files, token = _described(tire, shown, version, identifier, kind, arrays)
    if kind == "native":
        ready, values = _prebuilt(tire, shown, token, requested)
        code = {name.removeprefix("sources/"): text for name, text in files.items() if name.endswith((".c", ".h"))}
        files |= values | binaries(code, tire.model, fmi_headers(), version, identifier, requested, ready)
    write_zip(target, files)
    return target


def _prebuilt(
    tire: Tire, shown: Interface, token: str, requested: Iterable[str]
) -> tuple[dict[str, bytes], dict[str, bytes]]:
    """Return the prebuilt binaries by platform, and the file of values that they read."""
    if not has_prebuilt():
        return {}, {}
    shared = generic(tire, inputs=shown.inputs, axes=shown.axes)
    names = {host_platform() if name == "host" else name for name in requested}
    ready = {name: content for name in names if (content := prebuilt_binary(shared.structure, name)) is not None}
    return ready, {VALUES_FILE: values_file(shared, token, len(shown.variables))} if ready else {}


def checked_interface(inputs: str, axes: str) -> None:
    """Check that inputs and axes exist.

    Raises `FmuError` if one does not.

    >>> checked_interface("slip", "iso")
    """
    for what, given, allowed in (("inputs", inputs, INPUTS), ("axes", axes, AXES)):
        if given not in allowed:
            raise FmuError(f"{what} {given!r} are unknown: known are {', '.join(allowed)}")


def fmi_version(fmi: Any) -> int:
    """Return a version of FMI from a number or a text.

    `fmi`: 2, 3, 2.0, 3.0, "2", "3", "2.0" or "3.0". Raises `FmuError` if tirefmu does not support this version. Raises
    `WrongType` if it is neither a number nor a text.

    >>> fmi_version("3"), fmi_version(2.0)
    (3, 2)
    >>> fmi_version("1.0")
    Traceback (most recent call last):
    ...
    tirefmu.boundary.errors.FmuError: FMI 1.0 is not supported: supported are 2 and 3
    """
    if isinstance(fmi, bool) or not isinstance(fmi, (int, float, str)):
        raise WrongType("fmi", fmi, "2 or 3, as a number or a text")
    versions = {text: version for version in VERSIONS for text in (str(version), f"{version}.0")}
    if str(fmi).strip() not in versions:
        raise FmuError(f"FMI {fmi} is not supported: supported are 2 and 3")
    return versions[str(fmi).strip()]


def contents(
    tire: Tire,
    fmi: int,
    identifier: str,
    kind: str = "native",
    *,
    inputs: str = "slip",
    axes: str = "iso",
    quantities: bool = False,
) -> dict[str, bytes]:
    """Return the files of a tire's FMU by their paths inside it, without binaries.

    `fmi`: 2 or 3. `identifier`: the model identifier, see `c_identifier`. `kind`, `inputs`, `axes`, `quantities`: as in
    `export`. Raises `FmuError` if the headers of the standard are not installed, or a unit is unknown.

    >>> from tirefmu.tires import published
    >>> sorted(contents(published("trento_hoosier"), 2, "tire"))[:2]
    ['documentation/index.html', 'documentation/licenses/fmi-headers.txt']
    """
    return _described(tire, interface(tire, inputs=inputs, axes=axes, quantities=quantities), fmi, identifier, kind)[0]


def _described(
    tire: Tire, shown: Interface, fmi: int, identifier: str, kind: str, has_arrays: bool = False
) -> tuple[dict[str, bytes], str]:
    """Return the files of an FMU without binaries, and its token."""
    native, written_in, inputs, axes = kind == "native", tire.signs, shown.inputs, shown.axes
    name, iso = tire.name or identifier, tire.in_signs("iso")
    listed = with_remarks(shown.variables, shown.tire) if native else with_remarks(variables(iso), iso)
    rewritten = "" if written_in == shown.tire.signs else f", converted from {written_in} signs"
    assumed = "Tire with relaxation lengths by default" if shown.relaxation_note else "Steady-state tire"
    what = "Tire with relaxation" if tire.lags else assumed
    sentence = f"{what} {name}: {tire.symbolic_model.title}; {inputs} inputs; {AXES_NAMES[axes]} axes{rewritten}"
    unmeasured = not_measured(tire)
    sentence += f"; not determined by its data: {', '.join(unmeasured)}" if unmeasured else ""
    note = ". ".join(text for text in (shown.relaxation_note, *unmeasured.values()) if text)
    header = Header(name, identifier, sentence, c_files(fmi, shown), native, note, shown.spins, has_arrays)
    named = with_arrays(listed) if has_arrays else listed

    # The token connects description and binary; it depends on everything that determines the FMU's behaviour.
    blank = sources(fmi, shown, "") if native else {}
    blank_description = model_description(fmi, header, listed, "")
    token = fingerprint({**blank, "modelDescription.xml": blank_description})
    description = with_token(fmi, blank_description, token)
    packaged = {
        "modelDescription.xml": description,
        "documentation/index.html": index_html(iso, header, named),
        "documentation/licenses/license.txt": license_of("tirefmu").encode(),
        "documentation/licenses/fmi-headers.txt": header_license(fmi_headers() / f"fmi{fmi}Functions.h"),
        "resources/tire.tir": _tir(iso),
    }
    if not native:
        return packaged | python_contents(iso, identifier, token, description, listed), token
    code = {**blank, VALUES: tire_values(shown, token).encode()}
    packaged |= {f"sources/{file}": text for file, text in code.items()}
    packaged["resources/interface.json"] = (json.dumps({"inputs": inputs, "axes": axes}) + "\n").encode()
    packaged |= pictures(fmi, named)
    if fmi == 3:
        packaged["sources/buildDescription.xml"] = build_description(identifier, header.sources)
    return packaged, token


def c_identifier(name: str) -> str:
    """Return a valid C identifier for a name.

    >>> c_identifier("Hoosier 18.0x6.0-10"), c_identifier("2nd tire"), c_identifier("double")
    ('Hoosier_18_0x6_0_10', 'tire_2nd_tire', 'tire_double')
    """
    plain = re.sub(r"[^A-Za-z0-9_]", "_", name)
    return plain if re.match("[A-Za-z]", plain) and plain not in C_KEYWORDS else f"tire_{plain}"


def fingerprint(parts: Mapping[str, bytes]) -> str:
    """Return a token for named parts: different parts have different tokens.

    The result has braces and hyphens, the form of FMI 2's guid.

    >>> fingerprint({"a": b"1"}) == fingerprint({"a": b"1"}) != fingerprint({"a": b"2"})
    True
    """
    digest = hashlib.sha256()
    for name, part in sorted(parts.items()):
        digest.update(b"%s %d\n%s" % (name.encode(), len(part), part))
    return f"{{{uuid.UUID(bytes=digest.digest()[:16])}}}"


def fmi_headers() -> Path:
    """Return the folder of the FMI standard's C headers, which fmpy contains.

    Raises `FmuError` if fmpy is not installed, or has no headers.
    """
    spec = importlib.util.find_spec("fmpy")  # not imported: the import is slow
    for root in (spec.submodule_search_locations or []) if spec else []:
        folder = Path(root) / "c-code"
        if (folder / "fmi3Functions.h").is_file() and (folder / "fmi2Functions.h").is_file():
            return folder
    raise FmuError("the headers of the FMI standard are in the Python package fmpy: pip install fmpy")


def _tir(tire: Tire) -> bytes:
    """Return the tire as the bytes of a .tir file."""
    with tempfile.TemporaryDirectory(prefix="tirefmu-") as folder:
        path = Path(folder) / "tire.tir"
        write_tir(tire, path)
        return path.read_bytes()


def write_zip(target: Path, files: Mapping[str, bytes]) -> None:
    """Write an archive completely or not at all; the same files give the same bytes."""
    content = io.BytesIO()
    with zipfile.ZipFile(content, "w") as archive:
        for name in sorted(files):
            entry = zipfile.ZipInfo(name, date_time=(1980, 1, 1, 0, 0, 0))
            entry.create_system = 3  # Unix on every system, so that permissions are stored
            entry.external_attr = (0o755 if name.startswith("binaries/") else 0o644) << 16
            archive.writestr(entry, files[name], zipfile.ZIP_DEFLATED, 6)
    write_file(target, content.getvalue())


def write_file(target: Path, content: bytes) -> None:
    """Write a file completely or not at all.

    Raises `FmuError` if it cannot be written.
    """
    with writing(target, FmuError):
        write_whole(target, content)
