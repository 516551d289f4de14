"""JAX and PyTorch: gradients are finite wherever the forces are, equal to the printed Jacobians, traced and mapped.

The rows have zero slip, no load, standstill, reverse and a locked wheel.
"""

from __future__ import annotations

import importlib.util
import os
import sys

import numpy as np
import pytest

from tirefmu.applications.exports.self_test import operating_conditions
from tirefmu.symbolic.printers.languages.program import FUNCTIONS


def module_of(folder, name):
    spec = importlib.util.spec_from_file_location(f"printed_{folder.name}", folder / f"{name}.py")
    module = importlib.util.module_from_spec(spec)
    sys.modules[spec.name] = module
    spec.loader.exec_module(module)
    return module


@pytest.mark.skipif("TIREFMU_HOSTS" not in os.environ, reason="traces thousands of operations: make hosts")
def test_jax(trento, printout):
    """The coefficients are arguments, too."""
    jax, rows = pytest.importorskip("jax"), operating_conditions(trento, 16).T
    tire = module_of(printout(trento, "jax", "jax", functions=FUNCTIONS[:4], values="struct", rows=1), "mf96")
    with jax.enable_x64(True):

        def side_force(inputs, values):
            return tire.forces(values, **dict(zip(tire.INPUTS, inputs, strict=True)))["Fy"]

        gradient = jax.jit(jax.vmap(jax.grad(side_force, argnums=(0, 1)), in_axes=(0, None)))
        by_inputs, by_values = gradient(rows, {"PKY1": tire.COEFFICIENTS["PKY1"]})
        expected = tire.jacobian_inputs(**dict(zip(tire.INPUTS, rows.T, strict=True)))[1]
        expected = np.stack([np.broadcast_to(column, len(rows)) for column in expected], axis=1)
        assert np.isfinite(by_inputs).all()
        np.testing.assert_allclose(by_inputs, expected, rtol=1e-12, atol=1e-9)
        assert np.isfinite(by_values["PKY1"]).all()
        assert np.abs(by_values["PKY1"]).max() > 0.1


def test_torch(trento, printout):
    """Inputs in double precision keep it, although the default type of a tensor is single."""
    torch, rows = pytest.importorskip("torch"), operating_conditions(trento, 16).T
    tire = module_of(printout(trento, "torch", "torch", functions=FUNCTIONS[:3:2], rows=1), "mf96")
    inputs = torch.tensor(rows, dtype=torch.float64, requires_grad=True)

    def moment(inputs):
        return tire.forces(**dict(zip(tire.INPUTS, inputs.T, strict=True)))["Mz"]

    (gradient,) = torch.autograd.grad(moment(inputs).sum(), inputs)
    expected = tire.jacobian_inputs(**dict(zip(tire.INPUTS, rows.T, strict=True)))[2]
    assert gradient.dtype == torch.float64
    assert torch.isfinite(gradient).all()
    for column, values in zip(gradient.T, expected, strict=True):
        np.testing.assert_allclose(column, np.broadcast_to(values, len(rows)), rtol=1e-12, atol=1e-12)
    mapped = torch.func.vmap(torch.func.grad(lambda row: moment(row[None])[0]))(inputs.detach())
    np.testing.assert_allclose(mapped, gradient, rtol=1e-12, atol=1e-12)
