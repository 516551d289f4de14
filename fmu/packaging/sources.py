"""The C sources of a tire's FMU: the wrapper, the model's generated code, the headers that are written for it."""

from __future__ import annotations

import xml.etree.ElementTree as ET
from collections.abc import Iterable
from importlib.resources import files

from ...tires.code.printed import code_file
from ..description.interface import Interface
from ..description.model_description import xml_bytes
from .model_code import model_files, split_code
from .written_headers import model_config, tire_values

#: The translation units of the wrapper, by FMI version; those of both.
WRAPPER = {2: ("fmi2.c",), 3: ("fmi3.c", "fmi3_not_offered.c", "arrays.c")}
COMMON = (
    "values.c", "outputs.c", "instance.c", "life_cycle.c", "access.c", "stepping.c", "derivatives.c", "changes.c",
    "tangents.c", "chain_rule.c", "events.c", "continuous.c", "saved_state.c",
)  # fmt: skip
#: The files of the contact kinematics, by the kind of inputs; that of lagging slips.
_WHEEL = ("wheel_inputs.c", "standstill.c")
_HUB = (*_WHEEL, "hub.c", "hub_spring.c", "hub_derivatives.c", "root.c")
CONTACT = {"slip": ("slip_inputs.c",), "wheel": _WHEEL, "hub": _HUB, "hub-torque": (*_HUB, "spin.c", "spin_steps.c")}
LAGGING = "lagging_slips.c"
HEADERS = (
    "state.h", "outputs.h", "instance.h", "arrays.h", "tire.h", "resource_file.h", "contact.h", "slips.h",
    "effect_states.h", "standstill.h", "hub.h", "spin.h", "root.h", "changes.h", "tangents.h", "chain_rule.h",
    "same_calls.h", "steps.h",
)  # fmt: skip
CONFIG, VALUES = "model_config.h", "tire_values.h"
#: The headers of the model with the radii of a wheel, of which hub inputs need both.
ROLLING_RADIUS, LOADED_RADIUS = "rolling_radius.h", "loaded_radius.h"
#: The source of the tire's values: compiled for one tire, or read from a file of the FMU.
BUILT_IN, FROM_FILE = "built_in_tire.c", "tire_file.c"
#: The source that opens files of the FMU.
RESOURCE = "resource_file.c"
#: The laws of the states, equal for all models.
LAWS = "state_laws.h"
#: The functions of the kinematics of hub inputs, equal for all models.
KINEMATICS = "wheel_kinematics.h"
#: The headers with printed functions.
PRINTED = (LAWS, KINEMATICS, ROLLING_RADIUS, LOADED_RADIUS)


def c_files(fmi: int, shown: Interface) -> tuple[str, ...]:
    """Return the names of the files to compile.

    `fmi`: 2 or 3. Returns: the two files of the model's generated code are last.

    >>> from tirefmu.tires import published
    >>> from ..description.interface import interface
    >>> c_files(2, interface(published("trento_hoosier")))[-4:]
    ('saved_state.c', 'slip_inputs.c', 'mf96.c', 'mf96_quantities.c')
    """
    return (*WRAPPER[fmi], BUILT_IN, *common_files(shown))


def common_files(shown: Interface) -> tuple[str, ...]:
    """Return the C files that do not depend on the FMI version."""
    states = (*((LAGGING,) if shown.lags else ()), *(("effect_states.c",) if shown.memory else ()))
    return (*COMMON, *CONTACT[shown.inputs], *states, *model_files(shown.tire.model))


def generic_files(shown: Interface) -> tuple[str, ...]:
    """Return the names of the files of a binary for every tire with the same variables, and for both FMI versions.

    >>> from tirefmu.tires import published
    >>> from ..description.interface import interface
    >>> generic_files(interface(published("trento_hoosier")))[:4]
    ('fmi2.c', 'fmi3.c', 'fmi3_not_offered.c', 'arrays.c')
    """
    return (*(file for files in WRAPPER.values() for file in files), FROM_FILE, RESOURCE, *common_files(shown))


def sources(fmi: int, shown: Interface, token: str) -> dict[str, bytes]:
    """Return every source file of an FMU, without the standard's own headers.

    `fmi`: 2 or 3. `token`: as in the model description. The result is by file name.

    >>> from tirefmu.tires import published
    >>> from ..description.interface import interface
    >>> sorted(sources(2, interface(published("trento_hoosier")), "{1}"))[:4]
    ['access.c', 'arrays.h', 'built_in_tire.c', 'chain_rule.c']
    """
    code = code_files(c_files(fmi, shown), shown)
    return {**code, CONFIG: model_config(shown).encode(), VALUES: tire_values(shown, token).encode()}


def code_files(names: Iterable[str], shown: Interface) -> dict[str, bytes]:
    """Return C files and their headers, without those that are written for the tire.

    `names`: as from `c_files` or `generic_files`.
    """
    wrapper, model = files("tirefmu.fmu") / "wrapper", shown.tire.model
    generated = code_file(shown.tire.symbolic_model, f"c/{model}.c").parent
    written = [name for name in names if name not in model_files(model)]
    texts = {name: (wrapper / name).read_bytes() for name in (*written, *HEADERS)}
    texts |= split_code(model, (generated / f"{model}.c").read_text(encoding="ascii"))
    texts |= {name: (generated / name).read_bytes() for name in (f"{model}.h", f"{model}_operations.h")}
    texts[LAWS] = (files("tirefmu.generated") / "c" / LAWS).read_bytes()
    if shown.hub:
        texts[KINEMATICS] = (files("tirefmu.generated") / "c" / KINEMATICS).read_bytes()
        texts[LOADED_RADIUS] = (generated / f"{model}_{LOADED_RADIUS}").read_bytes()
    if shown.wheel:
        texts[ROLLING_RADIUS] = (generated / f"{model}_{ROLLING_RADIUS}").read_bytes()
    return texts


def build_description(identifier: str, names: Iterable[str]) -> bytes:
    """Return buildDescription.xml, from which an FMI 3 host compiles the sources.

    `identifier`: the model identifier. `names`: files to compile.

    Source: FMI 3.0.2, section 2.5.1.

    >>> b'SourceFile name="mf96.c"' in build_description("tire", ["mf96.c"])
    True
    """
    root = ET.Element("fmiBuildDescription", {"fmiVersion": "3.0"})
    configuration = ET.SubElement(root, "BuildConfiguration", {"modelIdentifier": identifier})
    listed = ET.SubElement(configuration, "SourceFileSet", {"language": "C99"})
    for name in names:
        ET.SubElement(listed, "SourceFile", {"name": name})
    return xml_bytes(root)
