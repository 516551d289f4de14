"""The generated code of a model for an FMU: two files, one compiled for speed and one for size."""

from __future__ import annotations

import re
from functools import lru_cache

from ...boundary.errors import FmuError
from ...symbolic.printers.definitions import INCLUDES, calling_functions, calling_math, definitions

#: Routines that a host calls at every step, and routines that it calls rarely.
FAST = ("forces", "relaxation", "state_lines")
SMALL = ("quantities",)

# A routine starts and ends in the first column.
_ROUTINE = re.compile(r"^(?:static )?(?:inline )?(?:void|int) (\w+)\([^;]*?\)\n\{.*?^\}\n", re.DOTALL | re.MULTILINE)


def model_files(model: str) -> tuple[str, str]:
    """Return the names of the two files.

    >>> model_files("mf61")
    ('mf61.c', 'mf61_quantities.c')
    """
    return f"{model}.c", f"{model}_quantities.c"


@lru_cache(maxsize=8)
def split_code(model: str, code: str) -> dict[str, bytes]:
    r"""Return the two files of a model's generated C code.

    Routines have their original names. The file for size has the general variants, which are valid for every row and
    call the system's elementary functions. Their results differ by rounding from those used for the forces.

    `code`: the generated code. Raises `FmuError` if a routine is missing.

    >>> routines = "".join(f"\nvoid m_{name}(int n)\n{{\n}}\n" for name in ("forces", "quantities"))
    >>> sorted(split_code("m", f"{INCLUDES}\n{routines}"))
    ['m.c', 'm_quantities.c']
    """
    routines = {match[1]: match[0] for match in _ROUTINE.finditer(code)}
    before, includes, _ = code.partition(INCLUDES)
    fast = [text for name in FAST for text in _chosen(model, name, routines)]
    small = [calling_math(_general(model, name, routines)) for name in SMALL]
    texts = ("\n".join(parts) for parts in (fast, small))
    return {
        name: "\n\n".join(part for part in (before + includes, definitions(text), text) if part).encode()
        for name, text in zip(model_files(model), texts, strict=True)
    }


def _chosen(model: str, name: str, routines: dict[str, str]) -> list[str]:
    """Return a routine and the variants that it calls; empty for a routine that the model lacks.

    Elementary functions are expanded where a step calls them; elsewhere the code is a third smaller without.
    """
    parts = ["is_plain"] if name == FAST[0] else []
    parts += [f"{name}_general", f"{model}_{name}_plain", f"{model}_{name}"]
    expanded = f"{model}_{name}_plain"
    return [
        routines[part] if part == expanded else calling_functions(routines[part]) for part in parts if part in routines
    ]


def _general(model: str, name: str, routines: dict[str, str]) -> str:
    """Return the variant that is valid for every row, under the routine's own name."""
    general, plain = f"{name}_general", f"{model}_{name}"
    if general in routines:
        return routines[general].replace(f"static void {general}(", f"void {plain}(", 1)
    if plain not in routines:
        raise FmuError(f"the code of {model} has no routine {name}")
    return routines[plain]
