"""A tire as a C++17 header, templated on the scalar type: double, float, automatic differentiation, firmware."""

from __future__ import annotations

from ....boundary.escaping import c_comment
from .expressions import CppPrinter
from .layout import Layout
from .program import PrintedProgram
from .rendering import render

LAYOUT = Layout(CppPrinter(), "const Scalar {name} = {value};", "// {}", c_comment)


def files(program: PrintedProgram) -> dict[str, str]:
    """Return the header, its self-test and their data: text by file name."""
    argument = ", coefficients" if program.placement == "file" else ""
    return render(program, LAYOUT, {"{}.hpp": "cpp.hpp", "{}_selftest.cpp": "cpp_selftest.cpp"}, argument=argument)
