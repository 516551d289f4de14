"""The hackable FMU: the model's NumPy code and a page of Python inside, run by pythonfmu (FMI 2)."""

from __future__ import annotations

import importlib.metadata
import json
import re
import xml.etree.ElementTree as ET
from collections.abc import Sequence
from importlib.resources import files
from math import isfinite
from pathlib import Path

from tirefmu.symbolic.errors import FmuError
from tirefmu.tires import Tire
from tirefmu.tires.code.modules import code_folder

from .description import xml_bytes
from .variables import Variable

#: The version of FMI that pythonfmu speaks.
FMI = 2


def python_contents(
    tire: Tire, identifier: str, token: str, description: bytes, variables: Sequence[Variable]
) -> dict[str, bytes]:
    """Return what makes an FMU of a tire run in Python, by paths inside it.

    Parameters
    ----------
    tire : Tire
        In ISO signs.
    identifier : str
        The model identifier.
    token : str
        As in the description.
    description : bytes
        The native FMU's modelDescription.xml for FMI 2.
    variables : sequence of Variable
        In the order of their value references.

    Returns
    -------
    dict of str to bytes
        The description with what pythonfmu can do, its binaries, it itself, and the tire's Python files.

    Raises
    ------
    FmuError
        If pythonfmu is not installed.
    """
    brought, license_text = _pythonfmu()
    # Python knows a module by its name: two tires in one process need two.
    slave = f"tire_{re.sub('[^0-9a-f]', '', token)}"
    generated = code_folder(tire.book)
    told = {"model": tire.model, "variables": [_told(variable) for variable in variables]}
    binaries = {
        f"binaries/{path.parent.name}/{identifier}{path.suffix}": path.read_bytes()
        for path in (brought / "resources" / "binaries").rglob("*")
        if path.suffix in (".so", ".dll", ".dylib")
    }
    return {
        "modelDescription.xml": _described(description),
        "documentation/licenses/pythonfmu.txt": license_text.encode(),
        "resources/slavemodule.txt": slave.encode(),
        f"resources/{slave}.py": (files("tirefmu.fmu") / "python_slave.py").read_bytes(),
        f"resources/{tire.model}.py": (generated / "numpy" / f"{tire.model}.py").read_bytes(),
        "resources/variables.json": (json.dumps(told, indent=1, allow_nan=False) + "\n").encode(),
        **{f"resources/pythonfmu/{path.name}": path.read_bytes() for path in brought.glob("*.py")},
        **binaries,
    }


def _told(variable: Variable) -> dict[str, str | float]:
    """Return what the slave needs of a variable."""
    limits = {"min": variable.lower, "max": variable.upper}
    return {
        "name": variable.name,
        "causality": variable.causality,
        "start": float(variable.start or 0.0),
        **{name: float(limit) for name, limit in limits.items() if isfinite(limit)},
    }


def _described(native: bytes) -> bytes:
    """Return a model description with the capabilities of pythonfmu in place of the native ones."""
    root = ET.fromstring(native)
    element = root.find("CoSimulation")
    if element is None:
        raise FmuError("the model description is not one for Co-Simulation")
    kept = {
        name: element.attrib[name]
        for name in (
            "modelIdentifier", "canHandleVariableCommunicationStepSize", "canGetAndSetFMUstate",
            "canSerializeFMUstate", "canNotUseMemoryManagementFunctions",
        )
    }  # fmt: skip
    element.clear()
    # The tool that the host has to have is Python with NumPy.
    element.attrib.update({**kept, "needsExecutionTool": "true"})
    return xml_bytes(root)


def _pythonfmu() -> tuple[Path, str]:
    """Return the folder of the installed pythonfmu, and its license."""
    # Not by import: an FMU of this kind that runs in this process brings a pythonfmu of its own.
    try:
        installed = importlib.metadata.distribution("pythonfmu")
    except importlib.metadata.PackageNotFoundError as error:
        raise FmuError("the Python variant of an FMU needs the package pythonfmu: pip install pythonfmu") from error
    licenses = [path for path in installed.files or () if re.search("licen[sc]e", path.name, re.IGNORECASE)]
    texts = [path.read_text(encoding="utf-8") for path in licenses]
    return Path(str(installed.locate_file("pythonfmu"))), "\n".join([f"pythonfmu {installed.version}", "", *texts])
