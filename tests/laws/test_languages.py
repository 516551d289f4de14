"""The same numbers from NumPy, C and CasADi, for every routine."""

from __future__ import annotations

import numpy as np
import pytest

from tirefmu.symbolic.models import MODELS
from tirefmu.tires.code import code_for
from tirefmu.tires.code.modules import numpy_module

ROUTINES = ("quantities", "forces", "jacobian_inputs", "jacobian_parameters")


def results(tire, language, routine, rows):
    """Return results as (n, n_results)."""
    table = getattr(code_for(tire.symbolic_model, language), routine)(rows, tire.parameters())
    return table.reshape(len(table), -1) if routine.startswith("jacobian") else table.T


def sizes(tire, routine, rows, expected):
    """Return the size to which the rounding of a result is relative, shape (n_results,): that in other rows.

    A derivative may be a small difference of large terms: a hundredth of the force per argument is included.
    """
    size = np.maximum(np.abs(expected).max(axis=0), 1e-12)
    if not routine.startswith("jacobian"):
        return size
    forces = np.abs(results(tire, "numpy", "forces", rows)).max(axis=0)
    by = rows if routine == "jacobian_inputs" else tire.parameters()[: len(tire.symbolic_model.coefficients), None]
    return size + 1e-2 * (forces[:, None] / np.abs(by).max(axis=1)).ravel()


@pytest.mark.parametrize("routine", ROUTINES)
def test_three_languages_one_number(tire, points, routine):
    rows = points(tire, n=60)
    expected = results(tire, "numpy", routine, rows)
    assert np.isfinite(expected).all()
    for language in ("c", "casadi"):
        difference = np.abs(results(tire, language, routine, rows) - expected)
        assert np.max(difference / sizes(tire, routine, rows, expected)) < 1e-12, language


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
