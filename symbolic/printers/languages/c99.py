"""A tire as one C99 file in double precision: no allocation, no state, nothing but math.h."""

from __future__ import annotations

from ....boundary.escaping import c_comment
from .expressions import C99Printer
from .layout import Layout
from .program import PrintedProgram
from .rendering import render

LAYOUT = Layout(C99Printer(), "const double {name} = {value};", "/* {} */", c_comment)


def files(program: PrintedProgram) -> dict[str, str]:
    """Return the C file, its self-test and their data: text by file name."""
    argument = "&coefficients, " if program.coefficients else ""
    usage = f"&{program.name}_default_coefficients, " if program.placement == "struct" else argument
    templates = {"{}.h": "c.h", "{}_selftest.c": "c_selftest.c"}
    return render(program, LAYOUT, templates, argument=argument, usage=usage)
