"""The generated JavaScript of a tire, as a part of a page: a function that returns its module."""

from __future__ import annotations

import re

from tirefmu.symbolic.escaping import script_text
from tirefmu.symbolic.printers.languages import printer
from tirefmu.symbolic.printers.languages.program import Program, Selection, program
from tirefmu.tires import Tire

#: Name of the module's files; it does not occur in the page.
_NAME = "tire"


def program_for_page(tire: Tire) -> Program:
    """Return what the page computes: forces and named quantities, with the coefficients as variables.

    Parameters
    ----------
    tire : Tire
        In ISO-W. Its effects are those that can be switched on the page.

    Returns
    -------
    Program
    """
    coefficients = dict(zip(tire.book.coefficients, tire.parameters().tolist(), strict=False))
    nominal = {name: tire.nominal(name) for name in tire.inputs}
    return program(_NAME, tire.book, tire.has, coefficients, nominal, Selection(("forces", "quantities"), "struct"))


def module_expression(found: Program) -> str:
    """Return a JavaScript expression whose value has the functions `forces` and `quantities` of a program.

    Parameters
    ----------
    found : Program

    Returns
    -------
    str
        Printable ASCII. Comments are not part of it: they may contain text from files.
    """
    module = printer("javascript")(found)[f"{_NAME}.mjs"]
    plain = re.sub(r"/\*.*?\*/|//[^\n]*", "", module, flags=re.DOTALL)
    lines = (line.rstrip() for line in plain.splitlines())
    body = "\n".join(line for line in lines if line).replace("export ", "")
    return script_text(f"(() => {{\n{body}\nreturn {{ forces, quantities }};\n}})()")
