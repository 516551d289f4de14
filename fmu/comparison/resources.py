"""The contents of an FMU's resources that `check` reads: the axes of its inputs and the embedded tire."""

from __future__ import annotations

import json
import os
from collections.abc import Iterable
from pathlib import Path

from ...boundary.bounded_file import read_bounded
from ...boundary.errors import FmuError, TirefmuError
from ...boundary.escaping import excerpt
from ...tires import Tire
from ...tires.property_file.reading import read_tir_with_notes

#: The largest resources/interface.json, bytes.
LARGEST_INTERFACE = 1_000_000


def axes_of_inputs(folder: Path, fmu_path: str | os.PathLike[str]) -> str:
    """Return the convention of the inputs and outputs of an FMU with slip inputs.

    `folder`: the unpacked FMU. `fmu_path`: the FMU, for messages. Returns one of "iso", "sae". Raises `FmuError` if
    resources/interface.json is invalid, or the FMU has no slip inputs.
    """
    inputs, axes = declared_interface(folder, fmu_path)
    if inputs != "slip":
        raise FmuError(
            f"{fmu_path}: its inputs are the motion of the wheel, but a recording has slips: export it with slip inputs"
        )
    return axes


def declared_interface(folder: Path, fmu_path: str | os.PathLike[str]) -> tuple[str, str]:
    """Return the kind of inputs and the axes of an FMU, from resources/interface.json.

    `folder`: the unpacked FMU. `fmu_path`: the FMU, for messages. Returns: ``slip`` and ``iso`` without that file.
    Raises `FmuError` if the file is invalid.
    """
    path = folder / "resources" / "interface.json"
    source = f"{fmu_path}: resources/interface.json"
    if not path.is_file():
        return "slip", "iso"
    try:
        interface = json.loads(read_bounded(path, LARGEST_INTERFACE))
    except OSError as error:
        raise FmuError(f"{source}: {error.strerror or error}") from error
    except (ValueError, RecursionError) as error:
        raise FmuError(f"{source}: not JSON ({excerpt(error)})") from error
    if not isinstance(interface, dict):
        raise FmuError(f"{source}: not an object")
    axes = interface.get("axes", "iso")
    if axes not in ("iso", "sae"):
        raise FmuError(f"{source}: unknown axes '{excerpt(axes)}': known are iso and sae")
    return str(interface.get("inputs", "slip")), str(axes)


def embedded_tire(folder: Path, fmu_path: str | os.PathLike[str], outputs: Iterable[str]) -> Tire | None:
    """Return the tire of resources/tire.tir, or None without that file.

    `folder`: the unpacked FMU. `fmu_path`: the FMU, for messages. `outputs`: outputs of the FMU. Raises `FmuError` if
    the file is invalid, or its model lacks one of the outputs.
    """
    path = folder / "resources" / "tire.tir"
    if not path.is_file():
        return None
    try:
        tire = read_tir_with_notes(path).tire  # the export reported its notes
    except TirefmuError as error:
        raise FmuError(f"{fmu_path}: {str(error).replace(str(path), 'resources/tire.tir')}") from error
    missing = [name for name in outputs if name not in tire.outputs]
    if missing:
        raise FmuError(f"{fmu_path}: resources/tire.tir is of {tire.model}, which has no output {missing[0]}")
    return tire
