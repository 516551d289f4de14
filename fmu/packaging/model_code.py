"""The generated code of a model as an FMU takes it: what it calls, in one file to be fast and one to be small."""

from __future__ import annotations

import re

from tirefmu.symbolic.errors import FmuError
from tirefmu.symbolic.printers.c import INCLUDES
from tirefmu.symbolic.printers.definitions import calling_math, definitions

#: What a host waits for at every step, with the variant for most rows; and what is called now and then.
FAST = ("forces", "relaxation")
SMALL = ("quantities",)

# A routine begins at the left edge and ends with a brace there.
_ROUTINE = re.compile(r"^(?:static )?(?:inline )?(?:void|int) (\w+)\([^;]*?\)\n\{.*?^\}\n", re.DOTALL | re.MULTILINE)


def model_files(model: str) -> tuple[str, str]:
    """Return the names of the two files.

    Examples
    --------
    >>> model_files("mf61")
    ('mf61.c', 'mf61_quantities.c')
    """
    return f"{model}.c", f"{model}_quantities.c"


def split_code(model: str, code: str) -> dict[str, bytes]:
    r"""Return the two files made of a model's generated C code.

    Routines keep their names. What is called now and then is there in its general variant, which holds for every row,
    and calls the system's elementary functions, which differ from those of the forces by roundings.

    Parameters
    ----------
    model : str
    code : str
        As generated.

    Returns
    -------
    dict of str to bytes

    Raises
    ------
    FmuError
        If a routine is not there.

    Examples
    --------
    >>> routines = "".join(f"\nvoid m_{name}(int n)\n{{\n}}\n" for name in ("forces", "quantities"))
    >>> sorted(split_code("m", f"{INCLUDES}\n{routines}"))
    ['m.c', 'm_quantities.c']
    """
    found = {match[1]: match[0] for match in _ROUTINE.finditer(code)}
    before, includes, _ = code.partition(INCLUDES)
    fast = [text for name in FAST for text in _chosen(model, name, found)]
    small = [calling_math(_general(model, name, found)) for name in SMALL]
    texts = ("\n".join(routines) for routines in (fast, small))
    return {
        name: "\n\n".join(part for part in (before + includes, definitions(text), text) if part).encode()
        for name, text in zip(model_files(model), texts, strict=True)
    }


def _chosen(model: str, name: str, found: dict[str, str]) -> list[str]:
    """Return a routine with the variants that it chooses from; nothing for one that the model lacks."""
    parts = ["is_straight"] if name == FAST[0] else []
    parts += [f"{name}_general", f"{model}_{name}_straight", f"{model}_{name}"]
    return [found[part] for part in parts if part in found]


def _general(model: str, name: str, found: dict[str, str]) -> str:
    """Return the one variant that holds for every row, under the routine's own name."""
    general, own = f"{name}_general", f"{model}_{name}"
    if general in found:
        return found[general].replace(f"static void {general}(", f"void {own}(", 1)
    if own not in found:
        raise FmuError(f"the code of {model} has no routine {name}")
    return found[own]
