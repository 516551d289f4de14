"""A tire as a Python module for NumPy, JAX or PyTorch: traced, differentiated and mapped over rows by the library.

Reverse differentiation of a choice between two expressions multiplies the derivative of the one that was not taken by
0. Where that derivative is infinite, the result is NaN. For JAX and PyTorch the forces therefore carry the printed
Jacobians as their derivatives (`jax.custom_jvp`, `torch.autograd.Function`): these are finite wherever the forces are,
also without load.
"""

from __future__ import annotations

from collections.abc import Callable

import sympy as sp

from ....boundary.escaping import python_comment
from ..expressions import ArrayPrinter, NumpyPrinter
from ..routines import chosen_routines
from .layout import Layout
from .program import PrintedProgram
from .rendering import Function, function_of, render

#: Names of the private functions of the equations.
PRIVATE = {"forces": "_forces_of", "quantities": "_quantities_of", "jacobian_inputs": "_by_inputs",
           "jacobian_parameters": "_by_coefficients", "states": "_states_of"}  # fmt: skip
#: The name of the library in the module.
MODULES = {"numpy": "np", "jax": "jnp", "torch": "torch"}


class _Printer(NumpyPrinter):
    """Calls of the functions of the module that choose, which each library defines in its own way."""

    def __init__(self, module: str) -> None:
        super().__init__()
        self.module, self.where = module, "_choose"

    def _print_own(self, expr: sp.Expr) -> str:
        return f"_{expr.func.__name__}({self._print(expr.args[0])})"

    _print_sgn = _print_sgn1 = _print_absolute = _print_own

    def _print_SmallestSquare(self, expr: sp.Expr) -> str:
        # The first input: it has the type of all.
        return str(super()._print_SmallestSquare(expr)) if self.module == "np" else "_smallest_square(inputs[0])"

    def _print_joined(self, expr: sp.Expr) -> str:
        return (" & " if expr.func is sp.And else " | ").join(f"({self._print(arg)})" for arg in expr.args)

    _print_And = _print_Or = _print_joined


def python_layout(printer: ArrayPrinter) -> Layout:
    """Return the layout of Python modules."""
    return Layout(printer, "{name} = {value}", "# {}", python_comment, continued=" \\")


def printer_for(library: str) -> Callable[[PrintedProgram], dict[str, str]]:
    """Return the function that prints a program for a library of `MODULES`."""
    layout = python_layout(_Printer(MODULES[library]))

    def files(program: PrintedProgram) -> dict[str, str]:
        equations = _equations(program, layout, differentiates=library != "numpy")
        return render(
            program, layout, {"{}.py": "python.py", "{}_selftest.py": "python_selftest.py"}, library=library,
            module=MODULES[library], private=PRIVATE, equations=equations,
            has_forces=any(function.name == "forces" for function in equations),
        )  # fmt: skip

    return files


def _equations(program: PrintedProgram, layout: Layout, differentiates: bool) -> list[Function]:
    """Return the functions of lists of inputs and of the vector of coefficients, with those that derivatives need."""
    printed = {routine.name: routine for routine in program.routines}
    needed = sorted(printed, key=lambda name: name != "forces")
    if differentiates and "forces" in printed:
        needed += [name for name in ("jacobian_inputs", "jacobian_parameters") if name not in needed]
    if not program.coefficients:
        needed = [name for name in needed if name != "jacobian_parameters"]
    symbols = (
        [quantity.symbol for quantity in program.outputs], [quantity.symbol for quantity in program.inputs],
        [sp.Symbol(name, real=True) for name in program.coefficients],
    )  # fmt: skip
    routines = [printed.get(name) or chosen_routines(program.lines, [name], *symbols)[0] for name in needed]
    return [function_of(routine, program, layout) for routine in routines]


numpy_files, jax_files, torch_files = map(printer_for, MODULES)
