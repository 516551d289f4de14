"""The C sources of a tire's FMU: the wrapper, the model's generated code, and what ties them to a tire."""

from __future__ import annotations

import xml.etree.ElementTree as ET
from collections.abc import Iterable, Sequence
from importlib.resources import files
from math import isfinite

from .description import xml_bytes
from .variables import LAGGED, Variable

#: The translation units of the wrapper, by FMI version.
WRAPPER = {
    2: ("fmi2.c", "instance.c", "saved_state.c"),
    3: ("fmi3.c", "fmi3_not_offered.c", "instance.c", "saved_state.c"),
}
#: How slips act, by whether they lag behind.
SLIPS = {False: "direct_slips.c", True: "lagging_slips.c"}
HEADERS = ("instance.h", "slips.h")
CONFIG = "model_config.h"


def c_files(fmi: int, model: str, variables: Sequence[Variable]) -> tuple[str, ...]:
    """Return the names of the files to compile.

    Parameters
    ----------
    fmi : int
        2 or 3.
    model : str
    variables : sequence of Variable

    Returns
    -------
    tuple of str
        The model's generated code last.

    Examples
    --------
    >>> from .variables import TIME
    >>> c_files(2, "mf96", [TIME])
    ('fmi2.c', 'instance.c', 'saved_state.c', 'direct_slips.c', 'mf96.c')
    """
    return (*WRAPPER[fmi], SLIPS[_lags(variables)], f"{model}.c")


def sources(fmi: int, model: str, variables: Sequence[Variable], token: str) -> dict[str, bytes]:
    """Return every source file of an FMU, without the standard's own headers.

    Parameters
    ----------
    fmi : int
        2 or 3.
    model : str
        Name of the model, which is the name of its generated code.
    variables : sequence of Variable
        In the order of their value references.
    token : str
        As in the model description.

    Returns
    -------
    dict of str to bytes
        By file name.

    Examples
    --------
    >>> from .variables import TIME
    >>> sorted(sources(2, "mf96", [TIME], "{1}"))[:5]
    ['direct_slips.c', 'fmi2.c', 'instance.c', 'instance.h', 'mf96.c']
    """
    wrapper, generated = files("tirefmu.fmu") / "wrapper", files("tirefmu.generated") / "c"
    *own, code = c_files(fmi, model, variables)
    found = {name: (wrapper / name).read_bytes() for name in (*own, *HEADERS)}
    found |= {name: (generated / name).read_bytes() for name in (code, f"{model}.h")}
    return {**found, CONFIG: model_config(model, variables, token).encode()}


def model_config(model: str, variables: Sequence[Variable], token: str) -> str:
    """Return the header that ties the wrapper to a model and a tire.

    Parameters
    ----------
    model : str
    variables : sequence of Variable
    token : str

    Returns
    -------
    str

    Examples
    --------
    >>> from .variables import TIME
    >>> print(model_config("mf96", [TIME], "{1}").splitlines()[5])
    #define INSTANTIATION_TOKEN "{1}"
    """
    prefix, lags = model.upper(), _lags(variables)
    names = [f'"{variable.name}"' for variable in variables]
    starts = [repr(float(variable.start or 0.0)) for variable in variables]
    lower = [repr(float(v.lower)) if isfinite(v.lower) else "-DBL_MAX" for v in variables]
    upper = [repr(float(v.upper)) if isfinite(v.upper) else "DBL_MAX" for v in variables]
    kinds = [variable.causality.upper() for variable in variables]
    lines = [
        "/* Written by tirefmu for one tire. */",
        "#include <float.h>",
        "",
        f'#include "{model}.h"',
        "",
        f'#define INSTANTIATION_TOKEN "{token}"',
        f"#define N_INPUTS {prefix}_N_INPUTS",
        f"#define N_OUTPUTS {prefix}_N_FORCES",
        f"#define N_PARAMETERS {prefix}_N_PARAMETERS",
        f"#define N_COEFFICIENTS {prefix}_N_COEFFICIENTS",
        f"#define N_LOCALS {len(LAGGED) if lags else 0}",
        f"#define model_forces {model}_forces",
        f"#define model_jacobian_inputs {model}_jacobian_inputs",
        f"#define model_jacobian_parameters {model}_jacobian_parameters",
        *(_relaxation(model) if lags else ()),
        "",
        "/* By value reference. */",
        *_table("VALUE_NAMES", names),
        *_table("VALUE_KINDS", kinds),
        *_table("START_VALUES", starts),
        *_table("LOWER_LIMITS", lower),
        *_table("UPPER_LIMITS", upper),
    ]
    return "\n".join(lines) + "\n"


def _relaxation(model: str) -> Iterable[str]:
    """Yield what lagging slips need of the generated code."""
    yield f"#define model_relaxation {model}_relaxation"
    for name, place in (("KAPPA", "kappa"), ("ALPHA", "alpha"), ("SPEED", "V")):
        yield f"#define {name} {model.upper()}_{place}"


def _lags(variables: Iterable[Variable]) -> bool:
    """Return whether the slips that act are variables of their own."""
    return any(variable in LAGGED for variable in variables)


def _table(name: str, entries: Sequence[str]) -> Iterable[str]:
    """Yield the lines of a macro that initializes an array, eight entries in each."""
    yield f"#define {name} {{ \\"
    for i in range(0, len(entries), 8):
        yield f"    {', '.join(entries[i : i + 8])}, \\"
    yield "}"


def build_description(identifier: str, names: Iterable[str]) -> bytes:
    """Return buildDescription.xml, by which an FMI 3 host compiles the sources.

    Parameters
    ----------
    identifier : str
        The model identifier.
    names : iterable of str
        Files to compile.

    Returns
    -------
    bytes

    References
    ----------
    FMI 3.0.2, section 2.5.1.

    Examples
    --------
    >>> b'SourceFile name="mf96.c"' in build_description("tire", ["mf96.c"])
    True
    """
    root = ET.Element("fmiBuildDescription", {"fmiVersion": "3.0"})
    configuration = ET.SubElement(root, "BuildConfiguration", {"modelIdentifier": identifier})
    listed = ET.SubElement(configuration, "SourceFileSet", {"language": "C99"})
    for name in names:
        ET.SubElement(listed, "SourceFile", {"name": name})
    return xml_bytes(root)
