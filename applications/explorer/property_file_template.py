"""The .tir file of a tire, prepared so that the page can write it with changed values and effects."""

from __future__ import annotations

import re
from typing import Any

from ...tires import Tire
from ...tires.property_file.names import ASSUMED, listed
from ...tires.property_file.writing import tir_text

#: A section, and a line with a value: the key, the value, a comment.
_SECTION = re.compile(r"\[(.*)\]")
_ENTRY = re.compile(r"(\w+) = (\S+)(.*)")
#: Key of the remark in `Tire.about` that lists what was changed on the page.
CHANGES = "changed"


def property_file_template(tire: Tire) -> list[Any]:
    """Return the lines of a tire's .tir file; those that depend on the state of the page are objects.

    `tire`: in ISO-W, with every effect that can be switched on the page. Returns: ``{"coefficient": name, "rest":
    comment}`` is the line of a coefficient, ``{"assumed": names, "title": section}`` the list of coefficients that the
    tire's file did not have. The page writes the entries of [TIREFMU] that depend on the effects at ``{"effects":
    True}``, and what was changed at ``{"changes": True}``.

    >>> from tirefmu.tires import published
    >>> lines = property_file_template(published("trento_hoosier").in_signs("iso"))
    >>> next(line for line in lines if isinstance(line, dict))["coefficient"]
    'UNLOADED_RADIUS'
    """
    sections = {name: declaration.section for name, declaration in tire.symbolic_model.coefficients.items()}
    lines: list[Any] = []
    section, has_about = "", False
    for line in tir_text(tire).splitlines():
        if heading := _SECTION.fullmatch(line):
            section = heading[1]
            has_about = has_about or section == "TIREFMU_ABOUT"
        entry = _ENTRY.fullmatch(line)
        key = entry[1] if entry else ""
        if entry and sections.get(key) == section:
            lines.append({"coefficient": key, "rest": entry[3]})
        elif entry and section == ASSUMED:
            lines.append({"assumed": list(listed(line.partition(" = ")[2])), "title": key})
        elif not _replaced(section, key):
            lines.append(line)
        if (section, key) == ("TIREFMU", "NAME"):
            lines.append({"effects": True})
        elif line == "[TIREFMU_ABOUT]":
            lines.append({"changes": True})
    return lines if has_about else [*lines, "", "[TIREFMU_ABOUT]", {"changes": True}]


def _replaced(section: str, key: str) -> bool:
    """Return whether the page writes its own entry instead."""
    if section == "TIREFMU":
        return key == "EFFECTS" or key.startswith("CORE_")
    return (section, key) == ("TIREFMU_ABOUT", CHANGES.upper())
