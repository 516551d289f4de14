"""The inputs and outputs of any FMU, by which a system connects it."""

from __future__ import annotations

import os
import xml.etree.ElementTree as ET
from dataclasses import dataclass
from pathlib import Path

from tirefmu.boundary.errors import FmuError
from tirefmu.boundary.escaping import visible

from .archive import DESCRIPTION, unpacked


@dataclass(frozen=True)
class Connector:
    """An input or output of an FMU.

    - `causality`: ``input`` or ``output``.
    - `unit`: empty if the FMU declares none.
    """

    name: str
    causality: str
    unit: str
    description: str


def connectors(path: str | os.PathLike[str]) -> tuple[int, list[Connector]]:
    """Return the FMI version of an FMU and its inputs and outputs that are real numbers.

    Raises `FmuError` if it is not a readable FMU, or of another version than 2 or 3.

    >>> from tirefmu.fmu import export
    >>> fmi, found = connectors(export("trento_hoosier", "tire.fmu", fmi=2))
    >>> fmi, [connector.name for connector in found]
    (2, ['kappa', 'alpha', 'gamma', 'Fz', 'Fx', 'Fy', 'Mz', 'friction_use'])
    """
    with unpacked(path) as folder:
        try:
            root = ET.parse(folder / DESCRIPTION).getroot()
        except ET.ParseError as error:
            raise FmuError(f"{Path(path)}: {DESCRIPTION} cannot be read ({error})") from error
    version = root.get("fmiVersion", "")
    if version[:2] not in ("2.", "3."):
        raise FmuError(f"{Path(path)}: FMI {visible(version)[:20]} is not supported: supported are 2 and 3")
    if root.find("CoSimulation") is None:
        raise FmuError(f"{Path(path)}: the FMU has no Co-Simulation")
    listed: list[Connector] = []
    for element in root.iterfind("ModelVariables/*"):
        real = element if element.tag == "Float64" else element.find("Real")
        if real is not None and element.get("causality") in ("input", "output"):
            texts = (element.get("name", ""), element.get("causality", ""))
            listed.append(Connector(*texts, real.get("unit", ""), element.get("description", "")))
    return int(version[0]), listed
