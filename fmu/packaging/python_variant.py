"""The Python variant of an FMU: editable Python files and the model's NumPy code, run by pythonfmu (FMI 2)."""

from __future__ import annotations

import importlib.metadata
import json
import re
import xml.etree.ElementTree as ET
from collections.abc import Sequence
from importlib.resources import files
from math import isfinite
from pathlib import Path

from ...boundary.errors import FmuError
from ...tires import Tire
from ...tires.code.printed import code_file
from ..description.documentation import license_of
from ..description.model_description import xml_bytes
from ..description.variables import Variable


def python_contents(
    tire: Tire, identifier: str, token: str, description: bytes, variables: Sequence[Variable]
) -> dict[str, bytes]:
    """Return the files of an FMU that runs in Python, by paths inside it.

    `tire`: in ISO signs. `identifier`: the model identifier. `token`: as in the model description. `description`: the
    native FMU's modelDescription.xml for FMI 2. `variables`: in the order of their value references. Returns: the
    description with the capabilities of pythonfmu, its binaries and modules, and the tire's Python files. Raises
    `FmuError` if pythonfmu is not installed.
    """
    licenses = license_of("pythonfmu")
    # Not by import: an FMU of this kind that runs in this process imports its own copy of pythonfmu.
    distribution = importlib.metadata.distribution("pythonfmu")
    installed = Path(str(distribution.locate_file("pythonfmu")))
    # Python identifies a module by name: two tires in one process need two names.
    slave = f"tire_{re.sub('[^0-9a-f]', '', token)}"
    summary = {"model": tire.model, "variables": [_variable_json(variable) for variable in variables]}
    binaries = {
        f"binaries/{path.parent.name}/{identifier}{path.suffix}": path.read_bytes()
        for path in (installed / "resources" / "binaries").rglob("*")
        if path.suffix in (".so", ".dll", ".dylib")
    }
    return {
        "modelDescription.xml": _with_capabilities(description),
        "documentation/licenses/pythonfmu.txt": f"pythonfmu {distribution.version}\n\n{licenses}".encode(),
        "resources/slavemodule.txt": slave.encode(),
        f"resources/{slave}.py": (files("tirefmu.fmu") / "packaging" / "python_slave.py").read_bytes(),
        "resources/state_laws.py": (files("tirefmu.generated") / "numpy" / "state_laws.py").read_bytes(),
        f"resources/{tire.model}.py": code_file(tire.symbolic_model, f"numpy/{tire.model}.py").read_bytes(),
        "resources/variables.json": (json.dumps(summary, indent=1, allow_nan=False) + "\n").encode(),
        **{f"resources/pythonfmu/{path.name}": path.read_bytes() for path in installed.glob("*.py")},
        **binaries,
    }


def _variable_json(variable: Variable) -> dict[str, str | float]:
    """Return the attributes of a variable that the slave reads."""
    limits = {"min": variable.lower, "max": variable.upper}
    return {
        "name": variable.name,
        "causality": variable.causality,
        "start": float(variable.start or 0.0),
        **{name: float(limit) for name, limit in limits.items() if isfinite(limit)},
    }


def _with_capabilities(native: bytes) -> bytes:
    """Return a model description with the capabilities of pythonfmu instead of the native ones."""
    root = ET.fromstring(native)
    element = root.find("CoSimulation")
    if element is None:
        raise FmuError("the model description is not one for Co-Simulation")
    attributes = {
        name: element.attrib[name]
        for name in (
            "modelIdentifier", "canHandleVariableCommunicationStepSize", "canGetAndSetFMUstate",
            "canSerializeFMUstate", "canNotUseMemoryManagementFunctions",
        )
    }  # fmt: skip
    element.clear()
    # The required tool is Python with NumPy.
    element.attrib.update({**attributes, "needsExecutionTool": "true"})
    return xml_bytes(root)
