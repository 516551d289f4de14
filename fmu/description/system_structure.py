"""The files of a system of FMUs by the SSP standard: structure (.ssd), parameter values (.ssv), mapping (.ssm)."""

from __future__ import annotations

import xml.etree.ElementTree as ET
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace

from .model_description import xml_bytes
from .units import base_unit
from .variables import Variable

#: Version of SSP and the type of connectors, by FMI version: SSP 1.0 knows the types of FMI 2 only. Values of parameter
#: sets are Real in both: OMSimulator reads units of no other type.
SSP_VERSIONS = {2: ("1.0", "Real"), 3: ("2.0", "Float64")}
#: The namespaces have these names in SSP 2.0, too.
NAMESPACES = {
    prefix: f"http://ssp-standard.org/SSP1/SystemStructure{name}"
    for prefix, name in {
        "ssc": "Common",
        "ssd": "Description",
        "ssm": "ParameterMapping",
        "ssv": "ParameterValues",
    }.items()
}
MEDIA = {
    "fmu": "application/x-fmu-sharedlibrary",
    "ssv": "application/x-ssp-parameter-set",
    "ssm": "application/x-ssp-parameter-mapping",
}


@dataclass(frozen=True)
class Component:
    """A tire or a vehicle in a system.

    - `name`: unique in the system.
    - `fmu`, `values`, `mapping`: paths of the FMU, the parameter set and its mapping inside the archive; the last two
      are empty for a vehicle.
    - `variables`: of the FMU.
    """

    name: str
    fmu: str
    values: str
    mapping: str
    variables: tuple[Variable, ...]

    @property
    def connectors(self) -> list[Variable]:
        """Inputs and outputs."""
        return [variable for variable in self.variables if variable.causality in ("input", "output")]


def parameters(variables: Iterable[Variable]) -> list[Variable]:
    """Return the parameters among variables.

    >>> parameters([Variable("PDY1", "parameter", "1", "friction"), Variable("Fz", "input", "N", "load")])[0].name
    'PDY1'
    """
    return [variable for variable in variables if variable.causality == "parameter"]


def inputs_of(tires: Iterable[Component]) -> list[Variable]:
    """Return the inputs of tires with the names of the connectors of their system.

    >>> load = Variable("Fz", "input", "N", "vertical load", 4000.0)
    >>> inputs_of([Component("FL", "t.fmu", "FL.ssv", "t.ssm", (load,))])[0].name
    'FL_Fz'
    """
    return [
        replace(variable, name=f"{tire.name}_{variable.name}")
        for tire in tires
        for variable in tire.variables
        if variable.causality == "input"
    ]


def parameter_set(fmi: int, name: str, chosen: Sequence[Variable]) -> bytes:
    """Return a parameter set with the start values of variables.

    `fmi`: 2 for SSP 1.0, 3 for SSP 2.0.

    Source: SSP 1.0, section 6 (ParameterSet).

    >>> print(parameter_set(2, "tire", [Variable("PDY1", "parameter", "1", "friction", 0.9)]).decode())
    ... # doctest: +ELLIPSIS
    <?xml version='1.0' encoding='utf-8'?>
    <ssv:ParameterSet ... version="1.0" name="tire" generationTool="tirefmu">
      <ssv:Parameters>
        <ssv:Parameter name="PDY1" description="friction">
          <ssv:Real value="0.9" unit="1" />
    ...
    """
    root = _root("ssv:ParameterSet", ("ssv", "ssc"), SSP_VERSIONS[fmi][0], name)
    listed = ET.SubElement(root, "ssv:Parameters")
    for variable in chosen:
        about = {"name": variable.name, "description": variable.description}
        element = ET.SubElement(listed, "ssv:Parameter", about)
        ET.SubElement(element, "ssv:Real", {"value": repr(float(variable.start or 0.0)), "unit": variable.unit})
    _append_units(root, "ssv", chosen)
    return xml_bytes(root)


def parameter_mapping(fmi: int, variables: Iterable[Variable]) -> bytes:
    """Return the mapping of a parameter set of a tire to the parameters of its FMU, which have the same names.

    `fmi`: 2 for SSP 1.0, 3 for SSP 2.0.

    Source: SSP 1.0, section 7 (ParameterMapping).

    >>> b'source="PDY1" target="PDY1"' in parameter_mapping(2, [Variable("PDY1", "parameter", "1", "friction")])
    True
    """
    root = _root("ssm:ParameterMapping", ("ssm", "ssc"), SSP_VERSIONS[fmi][0])
    for variable in parameters(variables):
        ET.SubElement(root, "ssm:MappingEntry", {"source": variable.name, "target": variable.name})
    return xml_bytes(root)


def system_structure(
    fmi: int, name: str, components: Sequence[Component], vehicle: Component | None = None, values: str = ""
) -> bytes:
    """Return SystemStructure.ssd of a system of tires, alone or with a vehicle.

    `fmi`: 2 for SSP 1.0, 3 for SSP 2.0. `components`: the tires. `vehicle`: its variables are those of the tires, with
    the name of the tire in front, such as FL_Fz. Without a vehicle the system has the inputs and outputs of every tire
    as connectors, such as FL_Fz, and their start values in the parameter set `values`. With one they are connected to
    those of the vehicle, and the system has no connectors.

    Source: SSP 1.0, section 5 (SystemStructureDescription).

    >>> load = Variable("Fz", "input", "N", "vertical load")
    >>> written = system_structure(2, "car", [Component("FL", "t.fmu", "FL.ssv", "t.ssm", (load,))])
    >>> b'<ssd:Connection startConnector="FL_Fz" endElement="FL" endConnector="Fz" />' in written
    True
    """
    version, kind = SSP_VERSIONS[fmi]
    root = _root("ssd:SystemStructureDescription", ("ssd", "ssc", "ssv", "ssm"), version, name)
    system = ET.SubElement(root, "ssd:System", {"name": name})
    if vehicle is None:
        outside = ET.SubElement(system, "ssd:Connectors")
        _append_parameters(system, values)
    elements = ET.SubElement(system, "ssd:Elements")
    connections = ET.SubElement(system, "ssd:Connections")
    if vehicle:
        _append_component(elements, vehicle, kind)
    at_vehicle = {variable.name for variable in vehicle.variables} if vehicle else set()
    for tire in components:
        _append_parameters(_append_component(elements, tire, kind), tire.values, tire.mapping)
        for variable in tire.connectors:
            joined = f"{tire.name}_{variable.name}"
            if vehicle is None:
                _append_connector(outside, joined, variable, kind)
            if vehicle is None or joined in at_vehicle:
                other = {"Element": vehicle.name, "Connector": joined} if vehicle else {"Connector": joined}
                here = {"Element": tire.name, "Connector": variable.name}
                _append_connection(connections, *((other, here) if variable.causality == "input" else (here, other)))
    every = [*components, *([vehicle] if vehicle else [])]
    _append_units(root, "ssd", [variable for component in every for variable in component.connectors])
    ET.SubElement(root, "ssd:DefaultExperiment", {"startTime": "0.0", "stopTime": "1.0"})
    return xml_bytes(root)


def _append_component(elements: ET.Element, component: Component, kind: str) -> ET.Element:
    source = {"name": component.name, "type": MEDIA["fmu"], "source": component.fmu, "implementation": "CoSimulation"}
    element = ET.SubElement(elements, "ssd:Component", source)
    connectors = ET.SubElement(element, "ssd:Connectors")
    for variable in component.connectors:
        _append_connector(connectors, variable.name, variable, kind)
    return element


def _append_parameters(element: ET.Element, values: str, mapping: str = "") -> None:
    bindings = ET.SubElement(element, "ssd:ParameterBindings")
    binding = ET.SubElement(bindings, "ssd:ParameterBinding", {"type": MEDIA["ssv"], "source": values})
    if mapping:
        ET.SubElement(binding, "ssd:ParameterMapping", {"type": MEDIA["ssm"], "source": mapping})


def _append_connection(connections: ET.Element, start: Mapping[str, str], end: Mapping[str, str]) -> None:
    named = {f"start{key}": text for key, text in start.items()} | {f"end{key}": text for key, text in end.items()}
    ET.SubElement(connections, "ssd:Connection", named)


def _root(tag: str, prefixes: Sequence[str], version: str, name: str = "") -> ET.Element:
    spaces = {f"xmlns:{prefix}": NAMESPACES[prefix] for prefix in prefixes}
    named = {"name": name} if name else {}
    return ET.Element(tag, {**spaces, "version": version, **named, "generationTool": "tirefmu"})


def _append_connector(parent: ET.Element, name: str, variable: Variable, kind: str) -> None:
    described = {"name": name, "kind": variable.causality, "description": variable.description}
    connector = ET.SubElement(parent, "ssd:Connector", described)
    ET.SubElement(connector, f"ssc:{kind}", {"unit": variable.unit} if variable.unit else {})


def _append_units(root: ET.Element, prefix: str, variables: Iterable[Variable]) -> None:
    units = ET.SubElement(root, f"{prefix}:Units")
    for unit in dict.fromkeys(variable.unit for variable in variables if variable.unit):
        element = ET.SubElement(units, "ssc:Unit", {"name": unit})
        ET.SubElement(element, "ssc:BaseUnit", {name: repr(power) for name, power in base_unit(unit).items()})
