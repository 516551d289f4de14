"""A tire as a Python module for NumPy, JAX or PyTorch: traced, differentiated and mapped over rows by the library.

Reverse differentiation of a choice between two expressions multiplies the derivative of the one that was not taken by
0. Where that derivative is infinite, the result is NaN. The forces therefore carry the printed Jacobians as their
derivatives (`jax.custom_jvp`, `torch.autograd.Function`): these are finite wherever the forces are, also without load.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import sympy as sp

from ...escaping import python_comment
from ..expressions import ArrayPrinter, NumpyPrinter
from ..routines import Routine, chosen_routines
from .layout import Layout, filled, wrapped
from .program import TOLERANCE, Program


class _JaxPrinter(NumpyPrinter):
    module = "jnp"
    where = "jnp.where"

    def _print_sgn1(self, expr: sp.Expr) -> str:
        return f"_sgn1({self._print(expr.args[0])})"

    def _print_sgn(self, expr: sp.Expr) -> str:
        return f"_sgn({self._print(expr.args[0])})"

    def _print_absolute(self, expr: sp.Expr) -> str:
        return f"_absolute({self._print(expr.args[0])})"

    def _print_Piecewise(self, expr: sp.Expr) -> str:
        (value, condition), (otherwise, _) = expr.args
        return f"_choose({self._print(condition)}, {self._print(value)}, {self._print(otherwise)})"


class _NumpyPrinter(_JaxPrinter):
    module = "np"


class _TorchPrinter(_JaxPrinter):
    module = "torch"


@dataclass(frozen=True)
class Library:
    """What differs between the libraries.

    Attributes
    ----------
    title, imports : str
    printer : ArrayPrinter
    array : str
        Converts inputs and coefficients: ``{}``.
    functions : str
        Definitions of the functions that choose.
    derivatives : str
        How the forces get their derivatives; empty if the library has none.
    stack : str
        Joins results along a new last axis: ``{}`` is a tuple.
    decorator : str
        Line above the functions of the equations.
    """

    title: str
    imports: str
    printer: ArrayPrinter
    array: str
    functions: str
    derivatives: str
    stack: str
    decorator: str = ""


_FUNCTIONS = """def _choose(condition, then, otherwise):
    return @m@.where(@condition@, @then@, @otherwise@)


def _sgn(x):
    return @m@.sign(x)


def _sgn1(x):
    # A comparison alone would turn NaN into a sign.
    return @m@.where(x >= 0, @one@, @m@.sign(x))


def _absolute(x):
    return @m@.abs(x)
"""
_PLAIN = {"condition": "condition", "then": "then", "otherwise": "otherwise", "one": "1.0"}

_JAX_DERIVATIVES = '''

@jax.custom_jvp
def _forces(inputs, coefficients):
    """Forces, shape (..., @n_outputs@); inputs have the shape (..., @n_inputs@), coefficients (@n_coefficients@,)."""
    return jnp.stack(jnp.broadcast_arrays(*_forces_of(_rows(inputs), coefficients)), axis=-1)


@_forces.defjvp
def _forces_jvp(primals, tangents):
    inputs, coefficients = primals
    matrix = _stacked(_by_inputs(_rows(inputs), coefficients))
    change = jnp.einsum("...ij,...j->...i", matrix, tangents[0])
@by_coefficients@    return _forces(inputs, coefficients), change


def _stacked(rows):
    shape = jnp.broadcast_shapes(*(jnp.shape(value) for row in rows for value in row))
    return jnp.stack(
        [jnp.stack([jnp.broadcast_to(value, shape) for value in row], axis=-1) for row in rows], axis=-2
    )
'''
_JAX_BY_COEFFICIENTS = """    matrix = _stacked(_by_coefficients(_rows(inputs), coefficients))
    change = change + jnp.einsum("...ij,j->...i", matrix, tangents[1])
"""

_TORCH_DERIVATIVES = '''

class _Forces(torch.autograd.Function):
    """Forces as a tensor, shape (..., @n_outputs@), with the printed Jacobians as derivatives."""

    generate_vmap_rule = True

    @staticmethod
    def forward(inputs, coefficients):
        forces = map(_tensor, _forces_of(_rows(inputs), coefficients))
        return torch.stack(torch.broadcast_tensors(*forces), dim=-1).to(inputs)

    @staticmethod
    def setup_context(ctx, inputs, output):
        ctx.save_for_backward(*inputs)

    @staticmethod
    def backward(ctx, weights):
        inputs, coefficients = ctx.saved_tensors
        matrix = _stacked(_by_inputs(_rows(inputs), coefficients), inputs)
        by_inputs = torch.einsum("...i,...ij->...j", weights, matrix)
        by_coefficients = None
@by_coefficients@        return by_inputs, by_coefficients


def _stacked(rows, like):
    shape = like.shape[:-1]
    columns = [torch.stack([_tensor(value).to(like).expand(shape) for value in row], dim=-1) for row in rows]
    return torch.stack(columns, dim=-2)


def _forces(inputs, coefficients):
    return _Forces.apply(inputs, coefficients)
'''
_TORCH_BY_COEFFICIENTS = """        if ctx.needs_input_grad[1]:
            matrix = _stacked(_by_coefficients(_rows(inputs), coefficients), inputs)
            by_coefficients = torch.einsum("...i,...ij->j", weights, matrix)
"""

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

def quantities(coefficients=@default@, **inputs):
    """Return the named quantities by name."""
    values = _quantities_of(_rows(_inputs(inputs)), _coefficients(coefficients))
    return dict(zip(QUANTITIES, values, strict=True))
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
expected = rows[:, len(tire.INPUTS) :]
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

NUMPY = Library(
    "NumPy", "import numpy as np", _NumpyPrinter(), "np.asarray({}, dtype=float)",
    filled(_FUNCTIONS, _PLAIN | {"m": "np"}),
    "\n\ndef _forces(inputs, coefficients):\n"
    "    return np.stack(np.broadcast_arrays(*_forces_of(_rows(inputs), coefficients)), axis=-1)\n",
    "np.stack(np.broadcast_arrays(*{}), axis=-1)", '@np.errstate(all="ignore")  # of the branch that is not taken\n',
)  # fmt: skip
JAX = Library(
    "JAX", "import jax\nimport jax.numpy as jnp", _JaxPrinter(), "jnp.asarray({})",
    filled(_FUNCTIONS, _PLAIN | {"m": "jnp"}), _JAX_DERIVATIVES, "jnp.stack(jnp.broadcast_arrays(*{}), axis=-1)",
)  # fmt: skip
_TORCH_FUNCTIONS = """def _tensor(value):
    if hasattr(value, "dtype"):  # tensors and NumPy arrays keep their precision
        return torch.as_tensor(value)
    return torch.as_tensor(value, dtype=torch.get_default_dtype())


def _number(value):
    # Two numbers would make a tensor of the default type, with fewer digits than the inputs may have.
    return torch.tensor(value, dtype=torch.float64) if isinstance(value, (int, float)) else value


""" + filled(
    _FUNCTIONS,
    {
        "m": "torch",
        "condition": "condition",
        "then": "_number(then)",
        "otherwise": "_number(otherwise)",
        "one": "torch.ones_like(x)",
    },
)
TORCH = Library(
    "PyTorch", "import torch", _TorchPrinter(), "_tensor({})", _TORCH_FUNCTIONS, _TORCH_DERIVATIVES,
    "torch.stack(torch.broadcast_tensors(*{}), dim=-1)",
)  # fmt: skip


def printer_for(library: Library) -> Callable[[Program], dict[str, str]]:
    """Return the function that prints a program for a library."""
    layout = Layout(library.printer, "{name} = {value}", "# {}", python_comment)

    def files(program: Program) -> dict[str, str]:
        name = program.name
        return {
            f"{name}.py": _module(program, library, layout),
            f"{name}_selftest.py": _self_test(program, library, layout),
            **program.data_files(),
        }

    return files


def _module(program: Program, library: Library, layout: Layout) -> str:
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


def _vector(program: Program, library: Library) -> str:
    if not program.coefficients:
        return library.array.format("()")
    given = "{name: given[name] for name in COEFFICIENTS}"
    if program.placement == "struct":
        given = "{**COEFFICIENTS, **(given or {})}"
    return library.stack.format(f"[{library.array.format('value')} for value in ({given}).values()]")


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


def _functions(program: Program, library: Library, layout: Layout) -> list[str]:
    """Return the private functions of lists of inputs and of the vector of coefficients."""
    printed = {routine.name: routine for routine in program.routines}
    needed = ["forces"] if "forces" in printed else []
    needed += [name for name in printed if name != "forces"]
    if library.derivatives and "forces" in printed and library is not NUMPY:
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
    if "quantities" in printed:
        names = layout.indented(wrapped([f'"{label}"' for label in printed["quantities"].labels]))
        parts.append(f"\nQUANTITIES = (\n{names},\n)")
    if "forces" in printed:
        own = {"jax": _JAX_BY_COEFFICIENTS, "torch": _TORCH_BY_COEFFICIENTS}.get(_module_of(library), "")
        values = {
            "n_outputs": len(outputs),
            "n_inputs": len(inputs),
            "n_coefficients": len(coefficients),
            "by_coefficients": own if coefficients else "",
        }
        parts.append(filled(library.derivatives, values))
    return parts


#: Names of the private functions.
PRIVATE = {"forces": "_forces_of", "quantities": "_quantities_of", "jacobian_inputs": "_by_inputs",
           "jacobian_parameters": "_by_coefficients"}  # fmt: skip


def _module_of(library: Library) -> str:
    return {"JAX": "jax", "PyTorch": "torch"}.get(library.title, "numpy")


def equations(program: Program, routine: Routine, name: str, layout: Layout, decorator: str = "") -> str:
    """Return the function of a list of inputs and a list of coefficients, as a tuple or a tuple of rows."""
    read = [f"{', '.join(program.input_names)} = inputs"]
    if program.coefficients:
        names = "\n".join(wrapped(list(program.coefficients)))
        read.append(f"(\n{layout.indented(names.splitlines())},\n) = coefficients")
    rows = ["(" + ", ".join(layout.printer.doprint(value) for value in row) + ",)" for row in routine.results]
    result = rows[0] if not routine.name.startswith("jacobian_") else f"({', '.join(rows)},)"
    return (
        f"\n\n{decorator}def {name}(inputs, coefficients):\n{layout.indented(read)}\n\n"
        f"{layout.statements(routine)}\n\n    return {result}\n"
    ).rstrip() + "\n"


def _public(routine: Routine, default: str) -> str:
    if routine.name == "forces":
        pairs = ", ".join(f'"{label}": values[..., {i}]' for i, label in enumerate(routine.labels))
        return filled(_FORCES, {"default": default, "pairs": pairs})
    if routine.name == "quantities":
        return filled(_DICTIONARY, {"default": default})
    summary = f"the derivatives of the forces by {'the inputs' if 'inputs' in routine.name else 'the coefficients'}"
    values = {"name": routine.name, "default": default, "summary": summary, "function": PRIVATE[routine.name]}
    return filled(_MATRIX, values)


def _self_test(program: Program, library: Library, layout: Layout) -> str:
    setup = {
        "numpy": "",
        "jax": 'import jax\n\njax.config.update("jax_enable_x64", True)\njax.config.update("jax_platforms", "cpu")\n',
        "torch": "import torch\n\ntorch.set_default_dtype(torch.float64)\n",
    }
    load = f'{{"coefficients": tire.read_coefficients(FOLDER / "{program.values_file}")}}'
    given = {"torch": "given = {key: torch.as_tensor(value) for key, value in given.items()}\n"}
    text = filled(
        _SELF_TEST,
        {
            "head": layout.head(program.header[:1]),
            "name": program.name,
            "check_file": program.check_file,
            "setup": setup[_module_of(library)],
            "tolerances": ", ".join(f'"{name}": {TOLERANCE[name]!r}' for name, _ in program.sizes()),
            "arguments": load if program.placement == "file" else "{}",
        },
    )
    return text.replace("expected = rows", given.get(_module_of(library), "") + "expected = rows", 1)


numpy_files, jax_files, torch_files = map(printer_for, (NUMPY, JAX, TORCH))
