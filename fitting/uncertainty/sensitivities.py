"""Derivatives of forces and named quantities by the coefficients."""

from __future__ import annotations

from functools import lru_cache
from typing import Any

import casadi as ca
import numpy as np

from ...boundary.errors import UnknownName
from ...numerics.arrays import FloatArray
from ...symbolic.model import Model
from ...tires.code.casadi_code import casadi_expression
from ...tires.code.modules import numpy_module
from ...tires.tire import Tire


def sensitivities(tire: Tire, name: str, inputs: FloatArray) -> tuple[FloatArray, FloatArray, list[str]]:
    """Return the values of a force or named quantity at rows, and its derivatives by coefficients.

    `name`: "Fy", "K_yalpha", ... `inputs`, shape (n_inputs, n): in the model's order, SI, in the signs of the tire.
    Returns shapes (n,) and (k, n), and the names of the k coefficients on
    which it depends; further parameters, such as options, may be among them. Raises `UnknownName` if the model has no
    such output or quantity.
    """
    function, reached = _with_derivatives(tire.symbolic_model, name)
    n = inputs.shape[1]
    rows, parameters = tire.effective_inputs(inputs), tire.parameters()
    values, slopes = function.map(n)(rows, np.repeat(parameters[:, None], n, axis=1))
    names = [list(tire.symbolic_model.parameters)[column] for column in reached]
    factors = np.array([tire.rescaled.get(coefficient, 1.0) for coefficient in names])
    return np.array(values).ravel(), np.array(slopes).reshape(len(reached), n) * factors[:, None], names


@lru_cache(maxsize=64)
def _with_derivatives(model: Model, name: str) -> tuple[Any, tuple[int, ...]]:
    """Return an output or a quantity with its nonzero derivatives by parameters, and these parameters."""
    outputs = [quantity.name for quantity in model.outputs]
    quantities = numpy_module(model).QUANTITIES
    if name not in (*outputs, *quantities):
        raise UnknownName(f"output or quantity of {model.name}", name, [*outputs, *quantities])
    inputs, parameters = ca.SX.sym("inputs", len(model.inputs)), ca.SX.sym("parameters", len(model.parameters))
    if name in outputs:
        value = casadi_expression(model, "forces", inputs, parameters)[outputs.index(name)]
    else:
        value = casadi_expression(model, "quantities", inputs, parameters)[quantities.index(name)]
    gradient = ca.jacobian(value, parameters)
    reached = tuple(int(column) for column in gradient.sparsity().get_triplet()[1])
    slopes = ca.vertcat(*gradient.nonzeros()) if reached else ca.SX(0, 1)
    return ca.Function(f"{name}_with_derivatives", [inputs, parameters], [value, slopes]), reached
