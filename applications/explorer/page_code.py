"""The generated JavaScript of a tire, as a part of a page: a function that returns its module."""

from __future__ import annotations

import re

from ...boundary.escaping import script_text
from ...symbolic.declarations import Quantity
from ...symbolic.printers.languages import printer
from ...symbolic.printers.languages.program import PrintoutSelection, Program, program
from ...tires import Tire

#: Name of the module's files; it does not occur in the page.
_NAME = "tire"


def program_for_page(tire: Tire) -> Program:
    """Return what the page computes: forces, named quantities, rates of states, with the coefficients as variables.

    `tire`: in ISO-W. Its effects are those that can be switched on the page.
    """
    coefficients = dict(zip(tire.symbolic_model.coefficients, tire.parameters().tolist(), strict=False))
    nominal = {name: tire.nominal(name) for name in tire.inputs}
    states = ("states",) if tire.lags or tire.states else ()
    selection = PrintoutSelection(("forces", "quantities", *states), "struct")
    return program(_NAME, tire.symbolic_model, tire.has, coefficients, nominal, selection)


def lagged_slips(program: Program) -> list[Quantity]:
    """Return the lagged slips of a program: inputs that its model does not have."""
    return [quantity for quantity in program.inputs if quantity not in program.model.inputs]


def module_expression(program: Program) -> str:
    """Return a JavaScript expression whose value has the functions of a program.

    Returns: printable ASCII. Comments are not part of it: they may contain text from files.
    """
    module = printer("javascript")(program)[f"{_NAME}.mjs"]
    plain = re.sub(r"/\*.*?\*/|//[^\n]*", "", module, flags=re.DOTALL)
    lines = (line.rstrip() for line in plain.splitlines())
    body = "\n".join(line for line in lines if line).replace("export ", "")
    functions = ", ".join(routine.name for routine in program.routines)
    return script_text(f"(() => {{\n{body}\nreturn {{ {functions} }};\n}})()")
