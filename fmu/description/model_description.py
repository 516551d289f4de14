"""modelDescription.xml for FMI 2.0 and 3.0."""

from __future__ import annotations

import xml.etree.ElementTree as ET
from collections.abc import Sequence
from dataclasses import dataclass
from math import isfinite

from ...boundary.escaping import xml_text
from .arrays import gather
from .units import base_unit
from .variables import Variable, is_indicator

#: Log categories of both FMI versions.
LOG_CATEGORIES = {
    "logEvents": "an assumption of the FMU at the end of initialization; only if loggingOn is true",
    "logStatusWarning": "an input is outside the valid range of the tire",
    "logStatusDiscard": "a value was rejected or a result is not available: not finite, or outside its limits",
    "logStatusError": "a call was rejected: not allowed, not supported, or with a pointer that is NULL",
}

#: The display units that a description offers, by unit: display value = factor x value + offset.
DISPLAY_UNITS = {
    "rad": {"name": "deg", "factor": repr(57.29577951308232)},
    "K": {"name": "degC", "offset": repr(-273.15)},
}
#: Relative tolerance of solvers in Model Exchange: hosts take 1e-4 or 1e-5 without it, too coarse for a wheel that
#: oscillates on its tire.
TOLERANCE = "1e-7"
#: The value of fmiVersion, and the attribute with the token, by FMI version.
VERSION_ATTRIBUTES = {2: ("2.0", "guid"), 3: ("3.0", "instantiationToken")}


@dataclass(frozen=True)
class Header:
    """The attributes of a model description.

    - `name`: the tire's name.
    - `identifier`: name of the binary; a C identifier.
    - `description`: one sentence.
    - `sources`: the C files to compile, for hosts that compile them.
    - `model_exchange`: whether the FMU supports Model Exchange in addition to Co-Simulation.
    - `note`: what the FMU assumes; empty if nothing.
    - `has_event_mode`: whether events within a step of Co-Simulation are reported to the host, in FMI 3.
    - `has_arrays`: whether vectors are array variables, in FMI 3.
    """

    name: str
    identifier: str
    description: str
    sources: tuple[str, ...]
    model_exchange: bool = False
    note: str = ""
    has_event_mode: bool = False
    has_arrays: bool = False


def model_description(fmi: int, header: Header, variables: Sequence[Variable], token: str) -> bytes:
    """Return modelDescription.xml.

    `fmi`: 2 or 3. `variables`: in the order of their value references. `token`: identifies the binary that belongs to
    the description: FMI 2's guid, FMI 3's instantiation token. Returns: UTF-8; equal arguments give equal bytes.

    Source: FMI 2.0.5, section 2.2; FMI 3.0.2, section 2.4.

    >>> from .variables import TIME
    >>> text = model_description(3, Header("a < b", "a", "", ()), [TIME], "{1}").decode()
    >>> 'modelName="a &lt; b"' in text
    True
    """
    version, token_name = VERSION_ATTRIBUTES[fmi]
    root = ET.Element(
        "fmiModelDescription",
        {
            "fmiVersion": version,
            "modelName": header.name,
            token_name: token,
            "description": header.description,
            "generationTool": "tirefmu",
            "variableNamingConvention": "flat",
        },
    )
    if fmi == 2:
        root.set("numberOfEventIndicators", str(sum(map(is_indicator, variables))))
    if header.model_exchange:
        _append_interface_type(root, "ModelExchange", fmi, header)
    _append_interface_type(root, "CoSimulation", fmi, header)
    # FMI 2 does not require the time as a variable, and some of its hosts reject a variable of that name.
    unseen = ("hidden",) if fmi == 3 else ("hidden", "independent")
    _units(root, [variable for variable in variables if variable.causality not in unseen])
    categories = ET.SubElement(root, "LogCategories")
    for name, meaning in LOG_CATEGORIES.items():
        ET.SubElement(categories, "Category", {"name": name, "description": meaning})
    experiment = {"startTime": "0.0", "stopTime": "1.0", "stepSize": "0.001"}
    if header.model_exchange and any(variable.derivative_of is not None for variable in variables):
        experiment = {**experiment, "tolerance": TOLERANCE}
    ET.SubElement(root, "DefaultExperiment", experiment)
    _variables_and_structure(root, fmi, variables)
    if header.has_arrays:
        gather(root, variables)
    return xml_bytes(root)


def with_token(fmi: int, description: bytes, token: str) -> bytes:
    """Return a model description that was written without token with one.

    >>> with_token(2, b'<a guid=""/>', "{1}")
    b'<a guid="{1}"/>'
    """
    name = VERSION_ATTRIBUTES[fmi][1]
    return description.replace(f'{name}=""'.encode(), f'{name}="{token}"'.encode(), 1)


def xml_bytes(root: ET.Element) -> bytes:
    """Return an element as an indented XML file; every XML file of an FMU is written by this function.

    U+FFFD replaces characters that XML 1.0 does not allow.

    >>> print(xml_bytes(ET.Element("a")).decode(), end="")
    <?xml version='1.0' encoding='utf-8'?>
    <a />
    """
    ET.indent(root)
    for element in root.iter():
        element.attrib.update({name: xml_text(value) for name, value in element.attrib.items()})
    written: bytes = ET.tostring(root, encoding="utf-8", xml_declaration=True)
    return written + b"\n"


def _append_interface_type(root: ET.Element, kind: str, fmi: int, header: Header) -> None:
    """Append the capabilities in Model Exchange or Co-Simulation."""
    states, derivatives = (
        ("FMUstate", "providesDirectionalDerivative") if fmi == 2 else ("FMUState", "providesDirectionalDerivatives")
    )
    element = ET.SubElement(root, kind, {"modelIdentifier": header.identifier})
    if kind == "CoSimulation":
        element.set("canHandleVariableCommunicationStepSize", "true")
        if fmi == 2 and header.model_exchange:
            element.set("canInterpolateInputs", "true")
        if fmi == 3 and header.has_event_mode:
            element.set("hasEventMode", "true")
    for name in (f"canGetAndSet{states}", f"canSerialize{states}", derivatives):
        element.set(name, "true")
    if fmi == 3:  # sources/buildDescription.xml lists the sources
        element.set("providesAdjointDerivatives", "true")
        return
    element.set("canNotUseMemoryManagementFunctions", "true")
    files = ET.SubElement(element, "SourceFiles")
    for name in header.sources:
        ET.SubElement(files, "File", {"name": name})


def _units(root: ET.Element, variables: Sequence[Variable]) -> None:
    """Append the definitions of the units in use."""
    definitions = ET.SubElement(root, "UnitDefinitions")
    for unit in dict.fromkeys(variable.unit for variable in variables):
        element = ET.SubElement(definitions, "Unit", {"name": unit})
        ET.SubElement(element, "BaseUnit", {name: repr(power) for name, power in base_unit(unit).items()})
        if unit in DISPLAY_UNITS:
            ET.SubElement(element, "DisplayUnit", DISPLAY_UNITS[unit])


def _numbers(variable: Variable) -> dict[str, str]:
    """Return the numeric attributes of a variable, equal in both versions."""
    numbers = {"unit": variable.unit}
    if variable.unit == "K":
        numbers["displayUnit"] = DISPLAY_UNITS["K"]["name"]
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
    if variable.causality in ("input", "independent"):
        return character
    # A variable with a start value has it until the host sets another.
    return {**character, "initial": "calculated" if variable.start is None else "exact"}


def _is_given(variable: Variable) -> bool:
    """Return whether a variable is known when initialization begins."""
    return variable.causality in ("input", "parameter") or (
        variable.causality != "hidden" and variable.start is not None
    )


def _by_group(variables: Sequence[Variable]) -> tuple[list[int], list[int], list[int]]:
    """Return the value references of outputs, of derivatives, and of initial unknowns."""
    outputs = [reference for reference, v in enumerate(variables) if v.causality == "output"]
    derivatives = [reference for reference, v in enumerate(variables) if v.derivative_of is not None]
    states = {v.derivative_of for v in variables} - {None}
    computed = [
        reference
        for reference, v in enumerate(variables)
        if reference in derivatives or (reference in (*outputs, *states) and v.start is None)
    ]
    return outputs, derivatives, computed


def _variables_and_structure(root: ET.Element, fmi: int, variables: Sequence[Variable]) -> None:
    """Append variables and structure: FMI 2 refers to variables by index, from 1, FMI 3 by value reference."""
    listed = ET.SubElement(root, "ModelVariables")
    unseen = ("independent", "hidden") if fmi == 2 else ("hidden",)
    seen = [reference for reference, variable in enumerate(variables) if variable.causality not in unseen]
    places = {reference: str(index if fmi == 2 else reference) for index, reference in enumerate(seen, start=1)}
    for reference in seen:
        variable = variables[reference]
        about = {"name": variable.name, "valueReference": str(reference), "description": variable.description}
        about |= _character(variable)
        if fmi == 2:
            element = ET.SubElement(ET.SubElement(listed, "ScalarVariable", about), "Real", _numbers(variable))
        else:
            element = ET.SubElement(listed, "Float64", {**about, **_numbers(variable)})
        if variable.derivative_of is not None:
            element.set("derivative", places[variable.derivative_of])
    structure = ET.SubElement(root, "ModelStructure")
    indicators = [reference for reference, variable in enumerate(variables) if is_indicator(variable)]
    names = ("Output", "ContinuousStateDerivative", "InitialUnknown", "EventIndicator")
    groups = dict(zip(names, (*_by_group(variables), indicators), strict=True))

    given = [reference for reference in seen if _is_given(variables[reference])]

    def unknown(parent: ET.Element, name: str, key: str, group: str, reference: int) -> None:
        """Append an unknown with what it depends on: some importers refuse one without."""
        variable = variables[reference]
        initial = given if variable.initially is None else variable.initially
        depends = initial if group == "InitialUnknown" else variable.depends
        about = {key: places[reference], "dependencies": " ".join(places[cause] for cause in depends)}
        ET.SubElement(parent, name, about)

    if fmi == 3:
        for group, references in groups.items():
            for reference in references:
                unknown(structure, group, "valueReference", group, reference)
        return
    plural = {"Output": "Outputs", "ContinuousStateDerivative": "Derivatives", "InitialUnknown": "InitialUnknowns"}
    for group in (group for group in plural if groups[group]):
        element = ET.SubElement(structure, plural[group])
        for reference in groups[group]:
            unknown(element, "Unknown", "index", group, reference)
