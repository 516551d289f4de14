"""Prebuilt binaries: each is valid for every tire of a model with the same variables, and needs no compiler.

The values of the tire are in a file of the FMU (`values_file`), which the binary reads when it is instantiated. A
binary is found by the digest of its C sources: it is never used for other sources, such as those of an added effect or
of another version of tirefmu. ``make prebuilt`` builds the binaries (`prebuilding`); a wheel contains them.
"""

from __future__ import annotations

import hashlib
import json
import lzma
import struct
from dataclasses import dataclass
from importlib.resources import files
from pathlib import Path

from ...boundary.errors import FmuError
from ...tires import Tire
from ..description.interface import Interface, interface
from .sources import CONFIG, code_files, generic_files
from .written_headers import input_ranges, model_config

#: The folder of the binaries, and the file with their digests in it.
FOLDER = Path(str(files("tirefmu.fmu"))) / "prebuilt"
MANIFEST = "manifest.json"
#: The file of the values inside an FMU, and its format, as in wrapper/tire_file.c and wrapper/tire.h.
VALUES_FILE = "resources/tire_values.bin"
_FORMAT = b"TIREFMU2"
_TEXT_SIZES = (48, 256)


@dataclass(frozen=True)
class Generic:
    """The common parts of the tires that share a binary.

    - `shown`: with all named quantities as outputs: an FMU without them has the first variables of this list.
    - `sources`: C files and headers by name.
    - `structure`: SHA-256 digest of the sources, by which the binary accepts a file of values.
    """

    shown: Interface
    sources: dict[str, bytes]
    structure: str


def generic(tire: Tire, *, inputs: str = "slip", axes: str = "iso") -> Generic:
    """Return the common parts of a tire and the other tires of its model with the same variables.

    `inputs`, `axes`: as in `export`.

    >>> from dataclasses import replace
    >>> from tirefmu.tires import published
    >>> tire = published("trento_hoosier")
    >>> other = replace(tire, values={**tire.values, "PDY1": 3.0})
    >>> generic(tire).structure == generic(other).structure != generic(tire, axes="sae").structure
    True
    """
    shown = interface(tire, inputs=inputs, axes=axes, quantities=True)
    sources = {**code_files(generic_files(shown), shown), CONFIG: model_config(shown).encode()}
    digest = hashlib.sha256()
    for name, content in sorted(sources.items()):
        digest.update(b"%s %d\n%s" % (name.encode(), len(content), content))
    structure = digest.hexdigest()
    sources[CONFIG] += f'#define STRUCTURE "{structure}"\n'.encode()
    return Generic(shown, sources, structure)


def values_file(shared: Generic, token: str, count: int) -> bytes:
    """Return the file with the values of a tire, little-endian.

    `found`: of the tire. `token`: as in the model description. `count`: number of variables in the model description.
    Raises `FmuError` if a text is too long for the file.

    >>> from tirefmu.tires import published
    >>> values_file(generic(published("trento_hoosier")), "{1}", 100)[:8]
    b'TIREFMU2'
    """
    texts = []
    for text, size in zip((token, shared.shown.relaxation_note), _TEXT_SIZES, strict=True):
        if len(text.encode()) >= size:
            raise FmuError(f"{text[:40]}... is too long for {VALUES_FILE}")
        texts.append(text.encode().ljust(size, b"\0"))
    numbers = [
        *(float(variable.start or 0.0) for variable in shared.shown.variables),
        *(limit for limits in input_ranges(shared.shown) for limit in limits),
    ]
    body = struct.pack(f"<Q{len(numbers)}d", count, *numbers)
    return b"".join([_FORMAT, shared.structure.encode(), *texts, body])


def has_prebuilt() -> bool:
    """Return whether the installation contains binaries.

    >>> has_prebuilt() in (True, False)
    True
    """
    return (FOLDER / MANIFEST).is_file()


def prebuilt_binary(structure: str, platform: str) -> bytes | None:
    """Return a prebuilt binary.

    `structure`: as of `generic`. `platform`: FMI 3's name. Returns: None if there is none for these sources and this
    platform. Raises `FmuError` if the file is missing or damaged, or the binary differs from its digest.

    >>> prebuilt_binary("another structure", "x86_64-linux") is None
    True
    """
    if not has_prebuilt():
        return None
    entry = json.loads((FOLDER / MANIFEST).read_text(encoding="ascii")).get(f"{structure} {platform}")
    if entry is None:
        return None
    path, end = FOLDER / entry["file"], entry["start"] + entry["size"]
    try:
        content = lzma.LZMADecompressor().decompress(path.read_bytes(), end)[entry["start"] :]
    except (OSError, lzma.LZMAError):
        content = b""
    if hashlib.sha256(content).hexdigest() != entry["sha256"]:
        raise FmuError(f"{path} is missing or differs from its digest: install tirefmu again, or delete its folder")
    return content
