"""Vectors and the matrix of an FMU with hub inputs as array variables of FMI 3."""

from __future__ import annotations

import xml.etree.ElementTree as ET
from collections.abc import Sequence
from dataclasses import dataclass, replace

from ...symbolic.wheel import quantities as hub
from .variables import Variable

#: Value reference of the first array, beyond those of all scalars; as in wrapper/arrays.h.
FIRST_ARRAY = 0x10000
#: Every array: its name, shape, the scalars in it, and what they are.
ARRAYS = (
    ("r", (3,), hub.POSITION, "position of the wheel centre, global"),
    ("R", (3, 3), hub.ROTATION, "orientation of the carrier: the columns are its axes in global axes"),
    ("v", (3,), hub.VELOCITY, "velocity of the wheel centre, global"),
    ("w", (3,), hub.TURNING, "angular velocity of the carrier, global"),
    ("road_n", (3,), hub.NORMAL, "normal of the road plane, global; of any length"),
    ("road_v", (3,), hub.ROAD_VELOCITY, "velocity of the road surface, global"),
    ("c", (3,), hub.CONTACT_POINT, "position of the contact point, global"),
    ("F", (3,), hub.WRENCH[:3], "force on the wheel, carrier axes"),
    ("M", (3,), hub.WRENCH[3:], "moment on the wheel about its centre, carrier axes"),
    ("F_global", (3,), hub.GLOBAL_WRENCH[:3], "force on the wheel, global axes"),
    ("M_global", (3,), hub.GLOBAL_WRENCH[3:], "moment on the wheel about its centre, global axes"),
)


@dataclass(frozen=True)
class Array:
    """An array of variables with successive value references.

    - `shape`: the scalars are in the order of rows.
    - `first`, `size`: value reference of its first scalar, and their number.
    """

    name: str
    description: str
    shape: tuple[int, ...]
    first: int
    size: int


def arrays(variables: Sequence[Variable]) -> list[Array]:
    """Return the arrays that variables form; the value reference of each is `FIRST_ARRAY` and its place in this list.

    `variables`: in the order of their value references. Returns: empty without hub inputs.

    >>> from tirefmu.tires import published
    >>> from .interface import interface
    >>> hub = interface(published("trento_hoosier"), inputs="hub").variables
    >>> [(array.name, array.shape) for array in arrays(hub)][:3]
    [('r', (3,)), ('R', (3, 3)), ('v', (3,))]
    """
    references = {variable.name: reference for reference, variable in enumerate(variables)}
    return [
        Array(name, what, shape, references[scalars[0].name], len(scalars))
        for name, shape, scalars, what in ARRAYS
        if scalars[0].name in references
    ]


def with_arrays(variables: Sequence[Variable]) -> list[Variable]:
    """Return variables with an array, without start value, in place of its scalars: for documentation, terminals."""
    listed: list[Variable | None] = list(variables)
    for array in arrays(variables):
        scalar = variables[array.first]
        named = replace(scalar, name=array.name, description=array.description, start=None)
        listed[array.first : array.first + array.size] = [named, *([None] * (array.size - 1))]
    return [variable for variable in listed if variable is not None]


def gather(root: ET.Element, variables: Sequence[Variable]) -> None:
    """Replace the scalars of arrays by arrays in a model description of FMI 3.

    `root`: of the model description with scalars only; it is changed. `variables`: in the order of their value
    references.

    Source: FMI 3.0.2, section 2.4.7.5 (array variables).
    """
    listed, structure = root.find("ModelVariables"), root.find("ModelStructure")
    if listed is None or structure is None:
        return
    elements = {element.get("valueReference"): element for element in listed}
    moved: dict[str, str] = {}
    for place, array in enumerate(arrays(variables)):
        references = [str(array.first + i) for i in range(array.size)]
        first, *others = (elements[reference] for reference in references)
        if first.get("start") is not None:
            first.set("start", " ".join(elements[reference].get("start", "") for reference in references))
        first.attrib |= {"name": array.name, "description": array.description}
        first.set("valueReference", str(FIRST_ARRAY + place))
        for size in array.shape:
            ET.SubElement(first, "Dimension", {"start": str(size)})
        for element in others:
            listed.remove(element)
        moved |= dict.fromkeys(references, str(FIRST_ARRAY + place))
    for element in list(structure):
        reference = element.get("valueReference", "")
        element.set("valueReference", moved.get(reference, reference))
        causes = element.get("dependencies")
        if causes is not None:
            element.set("dependencies", " ".join(dict.fromkeys(moved.get(cause, cause) for cause in causes.split())))
    seen: set[tuple[str, str | None]] = set()
    for element in list(structure):
        key = (element.tag, element.get("valueReference"))
        if key in seen:
            structure.remove(element)
        seen.add(key)
