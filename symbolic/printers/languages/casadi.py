"""A tire as CasADi functions: a Python module that builds them and saves them to files for any host of CasADi."""

from __future__ import annotations

from tirefmu.boundary.escaping import python_comment

from ..expressions import CasadiPrinter
from .layout import Layout, filled, wrapped
from .program import TOLERANCE, Program
from .python_parts import coefficient_table, equations

LAYOUT = Layout(CasadiPrinter(), "{name} = {value}", "# {}", python_comment, continued=" \\")

_MODULE = '''@head@
#
# Usage:
#     import @name@
#     f = @name@.function("forces")           # casadi.Function of a column of inputs, see INPUTS
#     f([0.0, 0.05, ...])
# "python @name@.py" saves every function to a file: casadi.Function.load("@name@_forces.casadi") reads it in Python,
# and the same call of CasADi in MATLAB and C++. Self-test: python @name@_selftest.py
"""@title@, for CasADi."""
import casadi as ca

NOMINAL = {
@nominal@
}
INPUTS = tuple(NOMINAL)
@coefficients@
@functions@

_RESULTS = {@results@}
FUNCTIONS = tuple(_RESULTS)


def function(name):
    """Return a function as a casadi.Function.

    It maps a column of inputs@argument@ to a column, or to a matrix with a row for each force. Derivatives by automatic
    differentiation are those of the equations; at a load of 0 use jacobian_inputs instead.
    """
    inputs = ca.SX.sym("inputs", len(INPUTS))
    coefficients = ca.SX.sym("coefficients", @n_coefficients@)
    results = _RESULTS[name](ca.vertsplit(inputs), ca.vertsplit(coefficients))
    matrix = name.startswith("jacobian_")
    result = ca.vertcat(*(ca.horzcat(*row) for row in results)) if matrix else ca.vertcat(*results)
    return ca.Function(name, [@symbols@], [result], [@names@], ["results"])
@read_file@

if __name__ == "__main__":
    for name in FUNCTIONS:
        function(name).save(f"@name@_{name}.casadi")
'''

_READ_FILE = '''

def read_coefficients(path):
    """Return the coefficients in a text file with lines "NAME value", in the order of COEFFICIENTS."""
    with open(path, encoding="ascii") as file:
        found = dict(line.split() for line in file)
    return [float(found[name]) for name in COEFFICIENTS]
'''

_SELF_TEST = '''@head@
"""Compare @name@.py with the stored results of tirefmu in @check_file@.

Run it with "python @name@_selftest.py". Each function is saved to a file and loaded from it. The largest difference of
each is printed, relative to the result or its typical size. Exit code 1: a difference exceeds the tolerance.
"""
import sys
from pathlib import Path

import casadi as ca
import numpy as np
import @name@ as tire

FOLDER = Path(__file__).parent
TOLERANCES = {@tolerances@}

lines = (FOLDER / "@check_file@").read_text(encoding="ascii").splitlines()
sizes, rows = np.array(lines[1].split(), dtype=float), np.array([line.split() for line in lines[2:]], dtype=float)
inputs, expected = rows[:, : len(tire.INPUTS)], rows[:, len(tire.INPUTS) :]
ok, start = len(rows) == int(lines[0]) > 0, 0
try:
    coefficients = @values@
except KeyError as error:
    sys.exit(f"no coefficient {error}")
for name, tolerance in TOLERANCES.items():
    path = str(FOLDER / f"@name@_{name}.casadi")
    tire.function(name).save(path)
    function = ca.Function.load(path)
    results = np.stack([np.array(function(row, *coefficients)).ravel() for row in inputs])
    end = start + results.shape[1]
    size = np.maximum(sizes[start:end], np.abs(expected[:, start:end]))
    largest = np.max(np.abs(results - expected[:, start:end]) / size)
    print(name, f"{largest:.3g}")
    ok = ok and bool(largest <= tolerance)
    start = end
sys.exit(0 if ok else 1)
'''


def files(program: Program) -> dict[str, str]:
    """Return the module, its self-test and their data: text by file name."""
    name, some = program.name, bool(program.coefficients)
    results = ", ".join(f'"{routine.name}": _{routine.name}' for routine in program.routines)
    names = ['"inputs"', '"coefficients"'] if some else ['"inputs"']
    values = {
        "head": LAYOUT.head(program.header),
        "name": name,
        "title": python_comment(program.model.title),
        "nominal": LAYOUT.indented(f'"{key}": {value!r},' for key, value in program.nominal.items()),
        "coefficients": coefficient_table(program, LAYOUT),
        "functions": "".join(equations(program, routine, f"_{routine.name}", LAYOUT) for routine in program.routines),
        "results": "\n" + LAYOUT.indented(wrapped(results.split(", "), 60)) + ",\n",
        "argument": " and a column of coefficients" if some else "",
        "n_coefficients": len(program.coefficients),
        "symbols": "inputs, coefficients" if some else "inputs",
        "names": ", ".join(names),
        "read_file": _READ_FILE if program.placement == "file" else "",
    }
    given = {
        "inline": "()",
        "struct": "(list(tire.COEFFICIENTS.values()),)",
        "file": f'(tire.read_coefficients(FOLDER / "{program.values_file}"),)',
    }
    test = {
        "head": LAYOUT.head(program.header[:1]),
        "name": name,
        "check_file": program.check_file,
        "tolerances": ", ".join(f'"{function}": {TOLERANCE[function]!r}' for function, _ in program.sizes()),
        "values": given[program.placement] if some else "()",
    }
    return {f"{name}.py": filled(_MODULE, values), f"{name}_selftest.py": filled(_SELF_TEST, test),
            **program.data_files()}  # fmt: skip
