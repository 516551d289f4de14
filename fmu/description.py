"""modelDescription.xml for FMI 2.0 and 3.0."""

from __future__ import annotations

import re
import xml.etree.ElementTree as ET
from collections.abc import Sequence
from dataclasses import dataclass
from math import isfinite

from .units import base_unit
from .variables import Variable

#: What both versions call the categories of their log.
LOG_CATEGORIES = {
    "logStatusDiscard": "a value was refused: not finite, or outside its limits",
    "logStatusError": "a call was refused: not allowed, or not supported",
}

# What XML 1.0 cannot hold, not even escaped.
_UNPRINTABLE = re.compile("[\x00-\x08\x0b\x0c\x0e-\x1f\ud800-\udfff\ufffe\uffff]")


@dataclass(frozen=True)
class Header:
    """What stands on top of a model description.

    Attributes
    ----------
    name : str
        The tire's name.
    identifier : str
        Name of the binary; a C identifier.
    description : str
        One sentence.
    sources : tuple of str
        The C files to compile, for hosts that compile them.
    """

    name: str
    identifier: str
    description: str
    sources: tuple[str, ...]


def model_description(fmi: int, header: Header, variables: Sequence[Variable], token: str) -> bytes:
    """Return modelDescription.xml.

    Parameters
    ----------
    fmi : int
        2 or 3.
    header : Header
    variables : sequence of Variable
        In the order of their value references.
    token : str
        Ties the description to the binary: FMI 2's guid, FMI 3's instantiation token.

    Returns
    -------
    bytes
        UTF-8; equal arguments give equal bytes.

    References
    ----------
    FMI 2.0.5, section 2.2; FMI 3.0.2, section 2.4.

    Examples
    --------
    >>> from .variables import TIME
    >>> text = model_description(3, Header("a < b", "a", "", ()), [TIME], "{1}").decode()
    >>> 'modelName="a &lt; b"' in text
    True
    """
    versions = {2: ("2.0", "guid"), 3: ("3.0", "instantiationToken")}
    version, token_name = versions[fmi]
    root = ET.Element(
        "fmiModelDescription",
        {
            "fmiVersion": version,
            "modelName": _text(header.name),
            token_name: token,
            "description": _text(header.description),
            "generationTool": "tirefmu",
            "variableNamingConvention": "flat",
        },
    )
    _co_simulation(root, fmi, header)
    # FMI 2 may do without the time, and some of its hosts stumble over a variable of that name.
    unseen = ("hidden",) if fmi == 3 else ("hidden", "independent")
    _units(root, [variable for variable in variables if variable.causality not in unseen])
    categories = ET.SubElement(root, "LogCategories")
    for name, meaning in LOG_CATEGORIES.items():
        ET.SubElement(categories, "Category", {"name": name, "description": meaning})
    ET.SubElement(root, "DefaultExperiment", {"startTime": "0.0", "stopTime": "1.0", "stepSize": "0.001"})
    if fmi == 2:
        _variables_and_structure_2(root, variables)
    else:
        _variables_and_structure_3(root, variables)
    return xml_bytes(root)


def xml_bytes(root: ET.Element) -> bytes:
    """Return an element as an indented XML file.

    Examples
    --------
    >>> print(xml_bytes(ET.Element("a")).decode(), end="")
    <?xml version='1.0' encoding='utf-8'?>
    <a />
    """
    ET.indent(root)
    written: bytes = ET.tostring(root, encoding="utf-8", xml_declaration=True)
    return written + b"\n"


def _text(text: str) -> str:
    """Return the text without what XML cannot hold."""
    return _UNPRINTABLE.sub("?", text)


def _co_simulation(root: ET.Element, fmi: int, header: Header) -> None:
    """Append what the FMU can do in Co-Simulation."""
    states, derivatives = (
        ("FMUstate", "providesDirectionalDerivative") if fmi == 2 else ("FMUState", "providesDirectionalDerivatives")
    )
    element = ET.SubElement(
        root,
        "CoSimulation",
        {
            "modelIdentifier": header.identifier,
            "canHandleVariableCommunicationStepSize": "true",
            f"canGetAndSet{states}": "true",
            f"canSerialize{states}": "true",
            derivatives: "true",
        },
    )
    if fmi == 2:  # FMI 3 lists them in sources/buildDescription.xml
        element.set("canNotUseMemoryManagementFunctions", "true")
        files = ET.SubElement(element, "SourceFiles")
        for name in header.sources:
            ET.SubElement(files, "File", {"name": name})


def _units(root: ET.Element, variables: Sequence[Variable]) -> None:
    """Append the definitions of the units that occur."""
    definitions = ET.SubElement(root, "UnitDefinitions")
    for unit in dict.fromkeys(variable.unit for variable in variables):
        element = ET.SubElement(definitions, "Unit", {"name": unit})
        ET.SubElement(element, "BaseUnit", {name: repr(power) for name, power in base_unit(unit).items()})
        if unit == "rad":
            ET.SubElement(element, "DisplayUnit", {"name": "deg", "factor": repr(57.29577951308232)})


def _numbers(variable: Variable) -> dict[str, str]:
    """Return the attributes of a variable that both versions write alike."""
    numbers = {"unit": variable.unit}
    if isfinite(variable.lower):
        numbers["min"] = repr(float(variable.lower))
    if isfinite(variable.upper):
        numbers["max"] = repr(float(variable.upper))
    if variable.nominal:
        numbers["nominal"] = repr(float(variable.nominal))
    if variable.start is not None:
        numbers["start"] = repr(float(variable.start))
    return numbers


def _character(variable: Variable) -> dict[str, str]:
    """Return causality, variability and initial."""
    character = {
        "causality": variable.causality,
        "variability": "tunable" if variable.causality == "parameter" else "continuous",
    }
    initial = {"parameter": "exact", "output": "calculated", "local": "calculated"}.get(variable.causality)
    return character if initial is None else {**character, "initial": initial}


def _variables_and_structure_2(root: ET.Element, variables: Sequence[Variable]) -> None:
    """Append variables and structure in the manner of FMI 2, which counts variables from 1."""
    listed = ET.SubElement(root, "ModelVariables")
    indices: dict[int, int] = {}
    for reference, variable in enumerate(variables):
        if variable.causality in ("independent", "hidden"):
            continue
        indices[reference] = len(indices) + 1
        scalar = ET.SubElement(
            listed,
            "ScalarVariable",
            {
                "name": variable.name,
                "valueReference": str(reference),
                "description": _text(variable.description),
                **_character(variable),
            },
        )
        ET.SubElement(scalar, "Real", _numbers(variable))
    structure = ET.SubElement(root, "ModelStructure")
    outputs, unknowns = ET.SubElement(structure, "Outputs"), ET.SubElement(structure, "InitialUnknowns")
    for reference, variable in enumerate(variables):
        if variable.causality == "output":
            known = " ".join(str(indices[depends]) for depends in variable.depends)
            ET.SubElement(outputs, "Unknown", {"index": str(indices[reference]), "dependencies": known})
            # Without a list of dependencies: on all that is known, inputs and parameters.
            ET.SubElement(unknowns, "Unknown", {"index": str(indices[reference])})


def _variables_and_structure_3(root: ET.Element, variables: Sequence[Variable]) -> None:
    """Append variables and structure in the manner of FMI 3, which names them by value reference."""
    listed = ET.SubElement(root, "ModelVariables")
    for reference, variable in enumerate(variables):
        if variable.causality == "hidden":
            continue
        ET.SubElement(
            listed,
            "Float64",
            {
                "name": variable.name,
                "valueReference": str(reference),
                "description": _text(variable.description),
                **_character(variable),
                **_numbers(variable),
            },
        )
    structure = ET.SubElement(root, "ModelStructure")
    outputs = [(reference, v) for reference, v in enumerate(variables) if v.causality == "output"]
    for reference, variable in outputs:
        known = " ".join(map(str, variable.depends))
        ET.SubElement(structure, "Output", {"valueReference": str(reference), "dependencies": known})
    for reference, _ in outputs:
        ET.SubElement(structure, "InitialUnknown", {"valueReference": str(reference)})
