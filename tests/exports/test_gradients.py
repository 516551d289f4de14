"""JAX and PyTorch: derivatives are finite wherever the forces are, equal to the printed Jacobians, traced and mapped.

The rows have zero slip, no load, standstill, reverse and a locked wheel.
"""

from __future__ import annotations

import importlib.util
import os
import sys

import numpy as np
import pytest

from tirefmu.applications.exports import operating_conditions
from tirefmu.symbolic.printers.languages.program import FUNCTIONS

from .special_points import special_points, symmetric


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


def assert_hessians(tire, hessian, single):
    """Check Hessians by all inputs, shape (rows, outputs, inputs, inputs): finite, and symmetric to the precision."""
    sizes = np.array([{"Fz": tire.nominal("Fz"), "V": 10.0, "p": 2e5}.get(name, 0.1) for name in tire.inputs])
    scaled = np.asarray(hessian) * sizes[:, None] * sizes
    assert np.isfinite(scaled).all()
    size = 1.0 + np.abs(scaled).max(axis=(2, 3), keepdims=True)
    assert (np.abs(scaled - scaled.swapaxes(2, 3)) <= (1e-2 if single else 1e-9) * size).all()


def second(tire):
    """Return a symmetric tire with limits at 0, and special rows of it, shape (rows, inputs)."""
    tire = symmetric(tire.in_signs("iso"))
    return tire, special_points(tire).T[::8]


@pytest.mark.filterwarnings("ignore:.*torch.jit.script:FutureWarning")  # of PyTorch itself, in its forward mode
@pytest.mark.parametrize("single", [False, True])
def test_torch_second_derivatives(mf61, printout, single):
    """Forward over reverse, and reverse twice."""
    torch, (tire, rows) = pytest.importorskip("torch"), second(mf61)
    printed = module_of(printout(tire, "torch", f"second{single}", functions=FUNCTIONS[:1], rows=1), "mf61")
    inputs = torch.tensor(rows, dtype=torch.float32 if single else torch.float64)

    def forces(row):
        return torch.stack(list(printed.forces(**dict(zip(printed.INPUTS, row, strict=True))).values()))

    for derivative in (torch.func.jacfwd, torch.func.jacrev):
        hessian = torch.func.vmap(derivative(torch.func.jacrev(forces)))(inputs)
        assert hessian.dtype == inputs.dtype
        assert_hessians(tire, hessian, single)


@pytest.mark.skipif("TIREFMU_HOSTS" not in os.environ, reason="traces thousands of operations: make hosts")
@pytest.mark.parametrize("single", [False, True])
def test_jax_second_derivatives(mf61, printout, single):
    """Forward twice, and reverse over forward."""
    jax, (tire, rows) = pytest.importorskip("jax"), second(mf61)
    printed = module_of(printout(tire, "jax", f"second{single}", functions=FUNCTIONS[:1], rows=1), "mf61")
    with jax.enable_x64(not single):

        def forces(row):
            values = printed.forces(**dict(zip(printed.INPUTS, row, strict=True))).values()
            return jax.numpy.stack(list(values))

        for derivative in (jax.jacfwd, jax.jacrev):
            assert_hessians(tire, jax.vmap(derivative(jax.jacfwd(forces)))(jax.numpy.asarray(rows)), single)
