"""Parts of Python modules that all libraries share: the table of coefficients and the functions of the equations."""

from __future__ import annotations

from ..routines import Routine
from .layout import Layout, wrapped
from .program import Program

#: Names of the private functions.
PRIVATE = {"forces": "_forces_of", "quantities": "_quantities_of", "jacobian_inputs": "_by_inputs",
           "jacobian_parameters": "_by_coefficients", "states": "_states_of"}  # fmt: skip


def coefficient_table(program: Program, layout: Layout) -> str:
    """Return the coefficients as a dictionary of values, or their names where the values are in a file."""
    if not program.coefficients:
        return ""
    if program.placement == "file":
        return "COEFFICIENTS = (\n" + layout.indented(wrapped([f'"{key}"' for key in program.coefficients])) + ",\n)\n"
    declared = program.model.coefficients
    lines = [
        f'"{key}": {value!r},  {layout.remark(f"{declared[key].description} [{declared[key].unit}]")}'
        for key, value in program.coefficients.items()
    ]
    return "COEFFICIENTS = {\n" + layout.indented(lines) + "\n}\n"


def equations(program: Program, routine: Routine, name: str, layout: Layout, decorator: str = "") -> str:
    """Return the function of a list of inputs and a list of coefficients, as a tuple or a tuple of rows."""
    read = layout.lines(f"{', '.join(program.input_names)} = inputs")
    if program.coefficients:
        names = "\n".join(wrapped(list(program.coefficients)))
        read.append(f"(\n{layout.indented(names.splitlines())},\n) = coefficients")
    matrix = routine.name.startswith("jacobian_")
    results = layout.indented(layout.rows(routine, "({},)," if matrix else "{},"), 2)
    return (
        f"\n\n{decorator}def {name}(inputs, coefficients):\n{layout.indented(read)}\n\n"
        f"{layout.statements(routine)}\n\n    return (\n{results}\n    )\n"
    )
