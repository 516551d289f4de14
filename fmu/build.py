"""A tire packed as an FMU."""

from __future__ import annotations

import hashlib
import importlib.util
import os
import re
import tempfile
import uuid
import zipfile
from collections.abc import Mapping
from pathlib import Path

from tirefmu.symbolic.errors import FmuError
from tirefmu.tires import Tire, write_tir

from .binaries import binary, binary_path
from .description import Header, model_description
from .documentation import LICENSE, header_license, index_html
from .sources import build_description, c_files, sources
from .variables import variables

#: What an FMU can take as inputs.
INPUTS = ("slip",)
VERSIONS = (2, 3)

_C_KEYWORD = re.compile(
    "auto|break|case|char|const|continue|default|do|double|else|enum|extern|float|for|goto|if|inline|int|long|"
    "register|restrict|return|short|signed|sizeof|static|struct|switch|typedef|union|unsigned|void|volatile|while"
)


def export(tire: Tire, path: str | os.PathLike[str], *, fmi: int = 3, inputs: str = "slip") -> Path:
    """Write a tire as a native FMU for Co-Simulation.

    The FMU runs without Python. Inputs and outputs carry the names of the tables, every coefficient is a
    tunable parameter, and so are the conventions of `Tire.evaluate` (0 for the first value, 1 for the
    second). Outputs follow the inputs without delay; where the tire has a relax_* effect, slips lag behind from
    step to step, as `evaluate` with inputs held has it, from steady state at the end of initialization. It
    speaks ISO-W: a tire written in other signs is rewritten. Equal tires give equal bytes from the same
    compiler.

    Parameters
    ----------
    tire : Tire
    path : path-like
        The file to write. Its name is the model identifier as far as C allows.
    fmi : {3, 2}
        Version of the standard.
    inputs : {"slip"}
        kappa, alpha, gamma, Fz as the model reads them.

    Returns
    -------
    Path
        The file written.

    Raises
    ------
    FmuError
        If the version or the inputs are unknown, there is no C compiler or it fails, or the file cannot be
        written. No half-written file is left.

    References
    ----------
    FMI 2.0.5 and 3.0.2, https://fmi-standard.org.

    Examples
    --------
    >>> from tirefmu.tires import published
    >>> export(published("trento_hoosier"), "tire.fmu").name
    'tire.fmu'
    """
    if fmi not in VERSIONS:
        raise FmuError(f"FMI {fmi} is not known: known are 2 and 3")
    if inputs not in INPUTS:
        raise FmuError(f"inputs {inputs!r} are not known: known are {', '.join(INPUTS)}")
    target = Path(path)
    identifier = c_identifier(target.stem)
    files = contents(tire, fmi, identifier)
    code = {name.removeprefix("sources/"): text for name, text in files.items() if name.endswith((".c", ".h"))}
    library = binary(code, tire.model, fmi_headers())
    _write_zip(target, {**files, binary_path(fmi, identifier): library})
    return target


def contents(tire: Tire, fmi: int, identifier: str) -> dict[str, bytes]:
    """Return the files of a tire's FMU by their paths inside it, all but the binaries.

    Parameters
    ----------
    tire : Tire
    fmi : int
        2 or 3.
    identifier : str
        The model identifier, see `c_identifier`.

    Returns
    -------
    dict of str to bytes

    Raises
    ------
    FmuError
        If the headers of the standard are not installed, or a unit is unknown.

    Examples
    --------
    >>> from tirefmu.tires import published
    >>> sorted(contents(published("trento_hoosier"), 2, "tire"))[:2]
    ['documentation/index.html', 'documentation/licenses/fmi-headers.txt']
    """
    written_in, tire = tire.signs, tire.in_signs("iso")
    book, listed = tire.book, variables(tire)
    compiled = c_files(fmi, book.name, listed)
    name = tire.name or identifier
    rewritten = "" if written_in == "iso" else f", rewritten from {written_in} signs"
    kind = "Tire with relaxation" if tire.lags else "Steady-state tire"
    sentence = f"{kind} {name}: {book.title}; slip inputs; ISO-W axes{rewritten}"
    header = Header(name, identifier, sentence, compiled)

    blank = sources(fmi, book.name, listed, "")
    token = fingerprint({**blank, "modelDescription.xml": model_description(fmi, header, listed, "")})
    code = sources(fmi, book.name, listed, token)
    packed = {
        "modelDescription.xml": model_description(fmi, header, listed, token),
        "documentation/index.html": index_html(name, sentence, book.title, listed),
        "documentation/licenses/license.txt": LICENSE.encode(),
        "documentation/licenses/fmi-headers.txt": header_license(fmi_headers() / f"fmi{fmi}Functions.h"),
        "resources/tire.tir": _tir(tire),
        **{f"sources/{file}": text for file, text in code.items()},
    }
    if fmi == 3:
        packed["sources/buildDescription.xml"] = build_description(identifier, compiled)
    return packed


def c_identifier(name: str) -> str:
    """Return a name as C and the FMI standard allow it.

    Parameters
    ----------
    name : str

    Returns
    -------
    str

    Examples
    --------
    >>> c_identifier("Hoosier 18.0x6.0-10"), c_identifier("2nd tire"), c_identifier("double")
    ('Hoosier_18_0x6_0_10', 'tire_2nd_tire', 'tire_double')
    """
    plain = re.sub(r"[^A-Za-z0-9_]", "_", name)
    return plain if re.match("[A-Za-z]", plain) and not _C_KEYWORD.fullmatch(plain) else f"tire_{plain}"


def fingerprint(parts: Mapping[str, bytes]) -> str:
    """Return a token for named parts: another one for any other parts.

    Parameters
    ----------
    parts : mapping of str to bytes

    Returns
    -------
    str
        In braces and hyphens, as FMI 2 likes its guid.

    Examples
    --------
    >>> fingerprint({"a": b"1"}) == fingerprint({"a": b"1"}) != fingerprint({"a": b"2"})
    True
    """
    digest = hashlib.sha256()
    for name, part in sorted(parts.items()):
        digest.update(b"%s %d\n%s" % (name.encode(), len(part), part))
    return f"{{{uuid.UUID(bytes=digest.digest()[:16])}}}"


def fmi_headers() -> Path:
    """Return the folder of the FMI standard's C headers, which fmpy brings.

    Returns
    -------
    Path

    Raises
    ------
    FmuError
        If fmpy is not installed, or without them.
    """
    found = importlib.util.find_spec("fmpy")  # not imported: it loads much that a build does not need
    for root in (found.submodule_search_locations or []) if found else []:
        folder = Path(root) / "c-code"
        if (folder / "fmi3Functions.h").is_file() and (folder / "fmi2Functions.h").is_file():
            return folder
    raise FmuError("the headers of the FMI standard come with the Python package fmpy: pip install fmpy")


def _tir(tire: Tire) -> bytes:
    """Return the tire as the bytes of a .tir file."""
    with tempfile.TemporaryDirectory(prefix="tirefmu-") as folder:
        path = Path(folder) / "tire.tir"
        write_tir(tire, path)
        return path.read_bytes()


def _write_zip(target: Path, files: Mapping[str, bytes]) -> None:
    """Write an archive at once or not at all, the same bytes for the same files."""
    half_done: Path | None = None
    try:
        with tempfile.NamedTemporaryFile(dir=target.parent, suffix=".fmu", delete=False) as file:
            half_done = Path(file.name)
            with zipfile.ZipFile(file, "w", zipfile.ZIP_DEFLATED) as archive:
                for name in sorted(files):
                    entry = zipfile.ZipInfo(name, date_time=(1980, 1, 1, 0, 0, 0))
                    entry.create_system = 3  # Unix, wherever it was written: permissions are kept
                    entry.external_attr = (0o755 if name.startswith("binaries/") else 0o644) << 16
                    archive.writestr(entry, files[name], zipfile.ZIP_DEFLATED)
        half_done.chmod(0o644)
        os.replace(half_done, target)
    except OSError as error:
        raise FmuError(f"{target} cannot be written: {error.strerror}") from error
    finally:
        if half_done is not None:
            half_done.unlink(missing_ok=True)
