"""The icon of an FMU, and the terminals that group its variables."""

from __future__ import annotations

import struct
import xml.etree.ElementTree as ET
import zlib
from collections.abc import Sequence
from functools import cache

from .model_description import xml_bytes
from .variables import Variable

#: Edge of the icon in pixels, and the rings of the wheel in it as shares of half the edge: outer radius and colour.
SIZE = 64
RINGS = ((0.97, (30, 30, 34)), (0.62, (176, 182, 190)), (0.52, (236, 238, 241)), (0.17, (110, 116, 124)))

#: The causality of the variables of each terminal.
TERMINALS = {"wheel": "input", "contact": "output"}


def pictures(fmi: int, variables: Sequence[Variable]) -> dict[str, bytes]:
    """Return the files by their paths inside the FMU.

    Parameters
    ----------
    fmi : int
        2, which supports an icon only, or 3.
    variables : sequence of Variable

    Returns
    -------
    dict of str to bytes

    References
    ----------
    FMI 2.0.5, section 2.3 (model.png); FMI 3.0.2, section 2.4.9 (terminals and icons).

    Examples
    --------
    >>> sorted(pictures(2, ())), sorted(pictures(3, ()))
    (['model.png'], ['terminalsAndIcons/icon.png', 'terminalsAndIcons/terminalsAndIcons.xml'])
    """
    if fmi == 2:
        return {"model.png": icon()}
    return {"terminalsAndIcons/icon.png": icon(), "terminalsAndIcons/terminalsAndIcons.xml": terminals(variables)}


@cache
def icon() -> bytes:
    r"""Return a wheel as a PNG file, with a transparent background.

    Returns
    -------
    bytes

    References
    ----------
    W3C, Portable Network Graphics (PNG) Specification, third edition.

    Examples
    --------
    >>> icon()[:8]
    b'\x89PNG\r\n\x1a\n'
    """
    middle = (SIZE - 1) / 2
    rows = []
    for y in range(SIZE):
        pixels = [_pixel(((x - middle) ** 2 + (y - middle) ** 2) / (SIZE / 2) ** 2) for x in range(SIZE)]
        rows.append(b"\0" + b"".join(pixels))  # 0: no filter
    parts = (
        (b"IHDR", struct.pack(">IIBBBBB", SIZE, SIZE, 8, 6, 0, 0, 0)),
        (b"IDAT", zlib.compress(b"".join(rows), 9)),
        (b"IEND", b""),
    )
    return b"\x89PNG\r\n\x1a\n" + b"".join(
        struct.pack(">I", len(content)) + name + content + struct.pack(">I", zlib.crc32(name + content))
        for name, content in parts
    )


def _pixel(radius_squared: float) -> bytes:
    """Return red, green, blue and opacity at a distance from the hub."""
    inside = [colour for radius, colour in RINGS if radius_squared <= radius**2]
    return bytes((*inside[-1], 255)) if inside else bytes(4)


def terminals(variables: Sequence[Variable]) -> bytes:
    """Return terminalsAndIcons.xml: one terminal for the inputs of the wheel, one for the outputs of the contact.

    Parameters
    ----------
    variables : sequence of Variable

    Returns
    -------
    bytes
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
    for name, causality in TERMINALS.items():
        members = [variable for variable in variables if variable.causality == causality]
        if members:
            terminal = ET.SubElement(listed, "Terminal", {"name": name, "matchingRule": "plug"})
            for variable in members:
                ET.SubElement(
                    terminal,
                    "TerminalMemberVariable",
                    {"variableName": variable.name, "memberName": variable.name, "variableKind": "signal"},
                )
    return xml_bytes(root)
