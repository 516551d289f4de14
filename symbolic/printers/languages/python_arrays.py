"""A tire as a Python module for NumPy, JAX or PyTorch: traced, differentiated and mapped over rows by the library."""

from __future__ import annotations

from collections.abc import Callable

import sympy as sp

from tirefmu.boundary.escaping import python_comment

from ..routines import Routine, chosen_routines
from .array_libraries import JAX, NUMPY, TORCH, ArrayLibrary
from .layout import Layout, filled, wrapped
from .program import TOLERANCE, Program
from .python_parts import PRIVATE, coefficient_table, equations

_MODULE = '''@head@
#
# Usage:
#     import @name@
#     @name@.forces(alpha=0.05)["Fy"]          # scalars or arrays; other inputs have their nominal values
# Self-test: python @name@_selftest.py
"""@title@, for @library@."""
@imports@

NOMINAL = {
@nominal@
}
INPUTS = tuple(NOMINAL)
@coefficients@

@definitions@

def _inputs(given):
    if unknown := given.keys() - NOMINAL.keys():
        raise TypeError(f"unknown input {min(unknown)}")
    values = [@array_of_value@ for value in {**NOMINAL, **given}.values()]
    return @joined@


def _rows(inputs):
    return [inputs[..., i] for i in range(@n_inputs@)]


def _coefficients(given):
    return @array_of_coefficients@
@functions@
@public@'''

_FORCES = '''

def forces(coefficients=@default@, **inputs):
    """Return forces and moments by name: N, N m."""
    values = _forces(_inputs(inputs), _coefficients(coefficients))
    return {@pairs@}
'''
_DICTIONARY = '''

def @name@(coefficients=@default@, **inputs):
    """Return @summary@ by name."""
    values = @function@(_rows(_inputs(inputs)), _coefficients(coefficients))
    return dict(zip(@labels@, values, strict=True))
'''
_MATRIX = '''

def @name@(coefficients=@default@, **inputs):
    """Return @summary@, as rows of columns: [force][column]."""
    return @function@(_rows(_inputs(inputs)), _coefficients(coefficients))
'''

_READ = '''

def read_coefficients(path):
    """Return the coefficients in a text file with lines "NAME value"."""
    with open(path, encoding="ascii") as file:
        found = dict(line.split() for line in file)
    return {name: float(found[name]) for name in COEFFICIENTS}
'''

_SELF_TEST = '''@head@
"""Compare @name@.py with the stored results of tirefmu in @check_file@.

Run it with "python @name@_selftest.py". It prints the largest difference of each function, relative to the result or
its typical size. Exit code 1: a difference exceeds the tolerance.
"""
import sys
from pathlib import Path

import numpy as np
@setup@
import @name@ as tire

FOLDER = Path(__file__).parent
TOLERANCES = {@tolerances@}


def numbers(value, n):
    """Return results as an array, shape (n, n_results)."""
    if isinstance(value, dict):
        value = value.values()
    flat = [entry for row in value for entry in (row if isinstance(row, (tuple, list)) else [row])]
    return np.stack([np.broadcast_to(np.asarray(entry), n) for entry in flat], axis=1)


lines = (FOLDER / "@check_file@").read_text(encoding="ascii").splitlines()
sizes, rows = np.array(lines[1].split(), dtype=float), np.array([line.split() for line in lines[2:]], dtype=float)
given = dict(zip(tire.INPUTS, rows[:, : len(tire.INPUTS)].T, strict=True))
@converted@expected = rows[:, len(tire.INPUTS) :]
ok, start = len(rows) == int(lines[0]) > 0, 0
try:
    arguments = @arguments@
except KeyError as error:
    sys.exit(f"no coefficient {error}")
for name, tolerance in TOLERANCES.items():
    results = numbers(getattr(tire, name)(**arguments, **given), len(rows))
    end = start + results.shape[1]
    size = np.maximum(sizes[start:end], np.abs(expected[:, start:end]))
    largest = np.max(np.abs(results - expected[:, start:end]) / size)
    print(name, f"{largest:.3g}")
    ok = ok and bool(largest <= tolerance)
    start = end
sys.exit(0 if ok else 1)
'''


def printer_for(library: ArrayLibrary) -> Callable[[Program], dict[str, str]]:
    """Return the function that prints a program for a library."""
    layout = Layout(library.printer, "{name} = {value}", "# {}", python_comment, continued=" \\")

    def files(program: Program) -> dict[str, str]:
        name = program.name
        return {
            f"{name}.py": _module(program, library, layout),
            f"{name}_selftest.py": _self_test(program, library, layout),
            **program.data_files(),
        }

    return files


def _module(program: Program, library: ArrayLibrary, layout: Layout) -> str:
    default = {"inline": "()", "struct": "None", "file": "None"}[program.placement]
    public = "".join(_public(routine, "None" if default == "None" else "()") for routine in program.routines)
    if program.placement == "file":
        public += _READ
    title = f"{program.model.title}: {', '.join(quantity.name for quantity in program.outputs)}"
    values = {
        "head": layout.head(program.header),
        "name": program.name,
        "title": python_comment(title),
        "library": library.title,
        "imports": library.imports,
        "nominal": layout.indented(f'"{key}": {value!r},' for key, value in program.nominal.items()),
        "coefficients": coefficient_table(program, layout),
        "definitions": library.functions,
        "array_of_value": library.array.format("value"),
        "joined": library.stack.format("values"),
        "n_inputs": len(program.inputs),
        "array_of_coefficients": _vector(program, library),
        "functions": "\n".join(_functions(program, library, layout)),
        "public": public.strip("\n") + "\n",
    }
    return filled(_MODULE, values)


def _vector(program: Program, library: ArrayLibrary) -> str:
    if not program.coefficients:
        return library.array.format("()")
    given = "{name: given[name] for name in COEFFICIENTS}"
    if program.placement == "struct":
        given = "{**COEFFICIENTS, **(given or {})}"
    return library.stack.format(f"[{library.array.format('value')} for value in ({given}).values()]")


def _functions(program: Program, library: ArrayLibrary, layout: Layout) -> list[str]:
    """Return the private functions of lists of inputs and of the vector of coefficients."""
    printed = {routine.name: routine for routine in program.routines}
    needed = ["forces"] if "forces" in printed else []
    needed += [name for name in printed if name != "forces"]
    if library.by_coefficients and "forces" in printed:
        needed += [name for name in ("jacobian_inputs", "jacobian_parameters") if name not in needed]
    if not program.coefficients:
        needed = [name for name in needed if name != "jacobian_parameters"]
    outputs = [quantity.symbol for quantity in program.outputs]
    inputs = [quantity.symbol for quantity in program.inputs]
    coefficients = [sp.Symbol(name, real=True) for name in program.coefficients]
    parts = []
    for name in needed:
        routine = printed.get(name) or chosen_routines(program.lines, [name], outputs, inputs, coefficients)[0]
        parts.append(equations(program, routine, PRIVATE[name], layout, library.decorator))
    for name in [name for name in ("quantities", "states") if name in printed]:
        names = layout.indented(wrapped([f'"{label}"' for label in printed[name].labels]))
        parts.append(f"\n{name.upper()} = (\n{names},\n)")
    if "forces" in printed:
        values = {
            "n_outputs": len(outputs),
            "n_inputs": len(inputs),
            "n_coefficients": len(coefficients),
            "by_coefficients": library.by_coefficients if coefficients else "",
        }
        parts.append(filled(library.forces, values))
    return parts


def _public(routine: Routine, default: str) -> str:
    if routine.name == "forces":
        pairs = ", ".join(f'"{label}": values[..., {i}]' for i, label in enumerate(routine.labels))
        return filled(_FORCES, {"default": default, "pairs": pairs})
    summary = f"the {routine.summary[0].lower()}{routine.summary[1:-1]}"
    values = {"name": routine.name, "default": default, "summary": summary, "function": PRIVATE[routine.name]}
    template = _MATRIX if routine.name.startswith("jacobian_") else _DICTIONARY
    return filled(template, {**values, "labels": routine.name.upper()})


def _self_test(program: Program, library: ArrayLibrary, layout: Layout) -> str:
    load = f'{{"coefficients": tire.read_coefficients(FOLDER / "{program.values_file}")}}'
    return filled(
        _SELF_TEST,
        {
            "head": layout.head(program.header[:1]),
            "name": program.name,
            "check_file": program.check_file,
            "setup": library.test_setup,
            "converted": library.test_inputs,
            "tolerances": ", ".join(f'"{name}": {TOLERANCE[name]!r}' for name, _ in program.sizes()),
            "arguments": load if program.placement == "file" else "{}",
        },
    )


numpy_files, jax_files, torch_files = map(printer_for, (NUMPY, JAX, TORCH))
