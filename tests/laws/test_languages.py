"""The same numbers from NumPy, C and CasADi, for every routine."""

from __future__ import annotations

import ctypes

import numpy as np
import pytest

from tirefmu.symbolic.models import MODELS
from tirefmu.tires.code import code_for
from tirefmu.tires.code.c_code import compiled_model
from tirefmu.tires.code.casadi_code import casadi_function
from tirefmu.tires.code.modules import numpy_module, numpy_routine

ROUTINES = ("quantities", "forces", "jacobian_inputs", "jacobian_parameters")


def from_numpy(model, routine, rows, parameters):
    """Return results as (n, n_results)."""
    result = numpy_routine(model, routine)(rows, parameters)
    values = [value for row in result for value in row] if isinstance(result[0], tuple) else result
    return np.stack([np.broadcast_to(value, rows.shape[1]) for value in values], axis=1)


def from_c(model, routine, rows, parameters, size):
    library = compiled_model(model, jacobians=routine.startswith("jacobian_"))
    function = getattr(library, f"{model.name}_{routine}")
    results = np.full((rows.shape[1], size), np.nan)
    for point, row in zip(np.ascontiguousarray(rows.T), results, strict=True):
        function(*(array.ctypes.data_as(ctypes.c_void_p) for array in (point, parameters, row)))
    return results


def from_casadi(model, routine, rows, parameters):
    function = casadi_function(model, routine)
    return np.stack([np.array(function(point, parameters)).ravel() for point in rows.T])


def sizes(tire, routine, rows, parameters, expected):
    """Return the size to which the rounding of a result is relative, shape (n_results,): that in other rows.

    A derivative may be a small difference of large terms: a hundredth of the force per argument is included.
    """
    size = np.maximum(np.abs(expected).max(axis=0), 1e-12)
    if not routine.startswith("jacobian"):
        return size
    forces = np.abs(from_numpy(tire.symbolic_model, "forces", rows, parameters)).max(axis=0)
    by = rows if routine == "jacobian_inputs" else parameters[: len(tire.symbolic_model.coefficients), None]
    return size + 1e-2 * (forces[:, None] / np.abs(by).max(axis=1)).ravel()


@pytest.mark.parametrize("routine", ROUTINES)
def test_three_languages_one_number(tire, points, routine):
    rows, parameters = points(tire, n=60), tire.parameters()
    expected = from_numpy(tire.symbolic_model, routine, rows, parameters)
    assert np.isfinite(expected).all()
    size = sizes(tire, routine, rows, parameters, expected)
    compiled = from_c(tire.symbolic_model, routine, rows, parameters, expected.shape[1])
    assert np.max(np.abs(compiled - expected) / size) < 1e-12
    assert np.max(np.abs(from_casadi(tire.symbolic_model, routine, rows, parameters) - expected) / size) < 1e-12


@pytest.mark.parametrize("routine", ["forces", "quantities", "jacobian_parameters"])
def test_tables_are_evaluated_by_the_same_code(tire, points, routine):
    rows, parameters = points(tire, n=20), tire.parameters()
    expected = getattr(code_for(tire.model, "numpy"), routine)(rows, parameters)
    for language in ("c", "casadi"):
        answer = getattr(code_for(tire.model, language), routine)(rows, parameters)
        assert answer.shape == expected.shape
        np.testing.assert_allclose(answer, expected, rtol=1e-9, atol=1e-9 * np.abs(expected).max())


@pytest.mark.parametrize("model", MODELS)
def test_the_module_lists_the_names_of_the_model(model):
    symbolic_model = MODELS[model]
    module = numpy_module(symbolic_model)
    assert tuple(quantity.name for quantity in symbolic_model.inputs) == module.INPUTS
    assert symbolic_model.parameters == module.PARAMETERS
    assert tuple(quantity.name for quantity in symbolic_model.outputs) == module.FORCES
    assert set(module.QUANTITIES) | set(module.FORCES) == {
        str(line.symbol) for line in symbolic_model.equations if line.named
    }
