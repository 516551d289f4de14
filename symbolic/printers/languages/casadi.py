"""A tire as CasADi functions: a Python module that builds them and saves them to files for any host of CasADi."""

from __future__ import annotations

from ..expressions import CasadiPrinter
from .program import PrintedProgram
from .python_arrays import python_layout
from .rendering import render

LAYOUT = python_layout(CasadiPrinter())


def files(program: PrintedProgram) -> dict[str, str]:
    """Return the module, its self-test and their data: text by file name."""
    templates = {"{}.py": "casadi.py", "{}_selftest.py": "python_selftest.py"}
    pairs = [f'"{routine.name}": _{routine.name}' for routine in program.routines]
    return render(program, LAYOUT, templates, library="casadi", pairs=pairs)
