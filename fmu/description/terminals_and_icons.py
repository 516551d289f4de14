"""The icon of an FMU, and the terminals that group its variables."""

from __future__ import annotations

import xml.etree.ElementTree as ET
from collections.abc import Sequence
from importlib.resources import files

from ...symbolic.wheel import quantities as hub
from .hub_variables import BRAKE, TORQUES
from .model_description import xml_bytes
from .variables import Variable

#: The terminals of the inputs and outputs that are not in `HUB_TERMINALS`, by causality.
TERMINALS = {"input": "wheel", "output": "contact"}
#: With hub inputs: further terminals and what is in them, as scalars and as arrays.
HUB_TERMINALS = {
    "carrier": ("r", "R", "v", "w", *(quantity.name for quantity in (*hub.CARRIER, hub.SPIN))),
    "road": ("road_n", "road_v", *(quantity.name for quantity in (*hub.ROAD, hub.FRICTION))),
    "torques": tuple(variable.name for variable in TORQUES),
    "hub": ("F", "M", "F_global", "M_global", *(q.name for q in (*hub.WRENCH, *hub.GLOBAL_WRENCH, BRAKE))),
}


def pictures(fmi: int, variables: Sequence[Variable]) -> dict[str, bytes]:
    """Return the files by their paths inside the FMU.

    `fmi`: 2, which supports an icon only, or 3.

    Source: FMI 2.0.5, section 2.3 (model.png); FMI 3.0.2, section 2.4.9 (terminals and icons).

    >>> sorted(pictures(2, ())), sorted(pictures(3, ()))
    (['model.png'], ['terminalsAndIcons/icon.png', 'terminalsAndIcons/terminalsAndIcons.xml'])
    """
    icon = (files(__package__) / "icon.png").read_bytes()
    if fmi == 2:
        return {"model.png": icon}
    return {"terminalsAndIcons/icon.png": icon, "terminalsAndIcons/terminalsAndIcons.xml": terminals(variables)}


def terminals(variables: Sequence[Variable]) -> bytes:
    """Return terminalsAndIcons.xml: the inputs of the wheel and the outputs of the contact.

    With hub inputs there are terminals for the carrier, the road, the hub and the torques, too.
    """
    root = ET.Element("fmiTerminalsAndIcons", {"fmiVersion": "3.0"})
    view = ET.SubElement(root, "GraphicalRepresentation")
    ET.SubElement(
        view,
        "CoordinateSystem",
        {"x1": "-100", "y1": "-100", "x2": "100", "y2": "100", "suggestedScalingFactorTo_mm": "0.1"},
    )
    ET.SubElement(view, "Icon", {"x1": "-100", "y1": "-100", "x2": "100", "y2": "100"})
    listed = ET.SubElement(root, "Terminals")
    has_hub = any(variable.name in ("r_x", "r") for variable in variables)
    members: dict[str, list[str]] = {}
    for variable in variables:
        if variable.causality in TERMINALS:
            terminals = [name for name, members in HUB_TERMINALS.items() if has_hub and variable.name in members]
            members.setdefault((*terminals, TERMINALS[variable.causality])[0], []).append(variable.name)
    for terminal, names in members.items():
        element = ET.SubElement(listed, "Terminal", {"name": terminal, "matchingRule": "plug"})
        for name in names:
            about = {"variableName": name, "memberName": name, "variableKind": "signal"}
            ET.SubElement(element, "TerminalMemberVariable", about)
    return xml_bytes(root)
