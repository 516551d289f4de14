"""NumPy, JAX and PyTorch as libraries of arrays: what differs in a module that is printed for them.

Reverse differentiation of a choice between two expressions multiplies the derivative of the one that was not taken by
0. Where that derivative is infinite, the result is NaN. The forces therefore carry the printed Jacobians as their
derivatives (`jax.custom_jvp`, `torch.autograd.Function`): these are finite wherever the forces are, also without load.
"""

from __future__ import annotations

from dataclasses import dataclass

import sympy as sp

from ..expressions import ArrayPrinter, NumpyPrinter
from .layout import filled


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

    def _print_And(self, expr: sp.Expr) -> str:
        return " & ".join(f"({self._print(arg)})" for arg in expr.args)

    def _print_Or(self, expr: sp.Expr) -> str:
        return " | ".join(f"({self._print(arg)})" for arg in expr.args)


class _NumpyPrinter(_JaxPrinter):
    module = "np"


class _TorchPrinter(_JaxPrinter):
    module = "torch"


@dataclass(frozen=True)
class ArrayLibrary:
    """A library of arrays.

    - `array`: converts inputs and coefficients: ``{}``.
    - `functions`: definitions of the functions that choose.
    - `forces`: definition of the forces, with their derivatives if the library differentiates.
    - `stack`: joins results along a new last axis: ``{}`` is a tuple.
    - `by_coefficients`: the part of the derivatives of `forces` by coefficients; empty if the library does not
      differentiate.
    - `decorator`: line above the functions of the equations.
    - `test_setup`, `test_inputs`: lines of the self-test: settings after the imports, and the conversion of the inputs.
    """

    title: str
    imports: str
    printer: ArrayPrinter
    array: str
    functions: str
    forces: str
    stack: str
    by_coefficients: str = ""
    decorator: str = ""
    test_setup: str = ""
    test_inputs: str = ""


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

NUMPY = ArrayLibrary(
    "NumPy", "import numpy as np", _NumpyPrinter(), "np.asarray({}, dtype=float)",
    filled(_FUNCTIONS, _PLAIN | {"m": "np"}),
    "\n\ndef _forces(inputs, coefficients):\n"
    "    return np.stack(np.broadcast_arrays(*_forces_of(_rows(inputs), coefficients)), axis=-1)\n",
    "np.stack(np.broadcast_arrays(*{}), axis=-1)",
    decorator='@np.errstate(all="ignore")  # of the branch that is not taken\n',
)  # fmt: skip
JAX = ArrayLibrary(
    "JAX", "import jax\nimport jax.numpy as jnp", _JaxPrinter(), "jnp.asarray({})",
    filled(_FUNCTIONS, _PLAIN | {"m": "jnp"}), _JAX_DERIVATIVES, "jnp.stack(jnp.broadcast_arrays(*{}), axis=-1)",
    by_coefficients=_JAX_BY_COEFFICIENTS,
    test_setup='import jax\n\njax.config.update("jax_enable_x64", True)\njax.config.update("jax_platforms", "cpu")\n',
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
TORCH = ArrayLibrary(
    "PyTorch", "import torch", _TorchPrinter(), "_tensor({})", _TORCH_FUNCTIONS, _TORCH_DERIVATIVES,
    "torch.stack(torch.broadcast_tensors(*{}), dim=-1)",
    by_coefficients=_TORCH_BY_COEFFICIENTS,
    test_setup="import torch\n\ntorch.set_default_dtype(torch.float64)\n",
    test_inputs="given = {key: torch.as_tensor(value) for key, value in given.items()}\n",
)  # fmt: skip
