"""A tire as a JavaScript module (ES2020) with type declarations, for browsers and Node."""

from __future__ import annotations

from ....boundary.escaping import c_comment
from .expressions import JavaScriptPrinter
from .layout import Layout
from .program import PrintedProgram
from .rendering import render

LAYOUT = Layout(JavaScriptPrinter(), "const {name} = {value};", "// {}", c_comment, "  ")
TEMPLATES = {
    "{}.mjs": "javascript.mjs",
    "{}.d.mts": "javascript.d.mts",
    "{}_selftest.mjs": "javascript_selftest.mjs",
}


def files(program: PrintedProgram) -> dict[str, str]:
    """Return the module, its type declarations, its self-test and their data: text by file name."""
    argument = ", coefficients" if program.placement == "file" else ""
    return render(program, LAYOUT, TEMPLATES, argument=argument, first_lines=LAYOUT.head(program.header[:2]))
