"""Values, gradients and Hessians at kinks and limits, in single and double precision.

The JAX printout runs with dual numbers of NumPy arrays in place of JAX; its expressions are those of every language.
"""

from __future__ import annotations

import re

import numpy as np
import pytest

from tirefmu.applications.exports import printed
from tirefmu.symbolic.models import MODELS

from .dual_arrays import Dual, dual, module_from
from .special_points import special_points, symmetric

#: Largest difference of Hessians, relative to the largest entry in the inputs' typical sizes.
SMALL = {np.float64: 1e-9, np.float32: 1e-2}
TYPICAL = {"Fz": 4e3, "V": 10.0, "p": 2e5}


@pytest.fixture(scope="module", params=[f"{model}{kind}" for model in MODELS for kind in ("", "-symmetric")])
def tire(request, tire_of):
    model, _, kind = request.param.partition("-")
    given = tire_of(model).in_signs("iso")
    return symmetric(given) if kind else given


@pytest.fixture(scope="module")
def text(tire):
    """Return the JAX printout of a tire."""
    return printed(tire, "jax", functions=("forces",), rows=1)[f"{tire.model}.py"]


@pytest.mark.parametrize("number", [np.float64, np.float32])
def test_gradients_and_hessians_are_finite_and_symmetric(tire, text, number, monkeypatch):
    """By all inputs: of the equations differentiated twice (C++, CasADi), of the Jacobian (JAX, PyTorch)."""
    printout, rows = module_from(text, monkeypatch), special_points(tire).astype(number)
    n = len(rows)
    seeds = np.eye(n, dtype=number)
    outer = [Dual(row, seed[:, None]) for row, seed in zip(rows, seeds, strict=True)]
    inner = [Dual(x, Dual(seed[:, None, None], 0.0)) for x, seed in zip(outer, seeds, strict=True)]
    with np.errstate(under="ignore"):
        by_inputs, forces = printout._by_inputs(outer, ()), printout._forces_of(inner, ())
    typical = np.array([[TYPICAL.get(name, 0.1)] for name in tire.inputs], dtype=number)
    sizes = np.where(rows == 0, typical, np.minimum(typical, np.abs(rows)))
    for name, force, row in zip(tire.outputs, forces, by_inputs, strict=True):
        columns = list(map(dual, row))
        of_force, of_column = dual(dual(force).x), dual(dual(force).d)
        gradients = of_force.d, np.array([np.broadcast_to(column.x, rows.shape[1:]) for column in columns])
        hessians = of_column.d, np.array([np.broadcast_to(column.d, rows.shape) for column in columns])
        scaled = [np.broadcast_to(matrix, (n, *rows.shape)) * sizes[:, None] * sizes for matrix in hessians]
        for matrix in (of_force.x, *gradients, *scaled):
            bad = np.argwhere(~np.isfinite(matrix))
            assert not len(bad), (name, bad[0], dict(zip(tire.inputs, rows[:, bad[0][-1]].tolist(), strict=True)))
        equal = SMALL[number] * (1.0 + np.abs(scaled[0]).max(axis=(0, 1)))
        for one, other in ((scaled[0], scaled[0].swapaxes(0, 1)), scaled):
            bad = np.argwhere(np.abs(one - other) > equal)
            assert not len(bad), (name, bad[0], dict(zip(tire.inputs, rows[:, bad[0][-1]].tolist(), strict=True)))


@pytest.mark.parametrize("number", [np.float64, np.float32])
def test_the_side_force_keeps_its_sign_around_90_degrees(tire, text, number, monkeypatch):
    """In single precision the number next to 90 deg is beyond it: its tangent is negative."""
    right, steps = number(np.pi / 2), np.arange(-4, 5) * np.finfo(number).eps
    rows = np.array([np.full(len(steps), tire.nominal(name), dtype=number) for name in tire.inputs])
    rows[tire.inputs.index("alpha")] = right + 2 * right * steps.astype(number)
    forces = module_from(text, monkeypatch)._forces_of(rows, ())[tire.outputs.index("Fy")]
    np.testing.assert_allclose(forces, forces[0], rtol=1e-3)


def test_no_number_is_beyond_single_precision(text):
    """But those that are chosen by the type."""
    numbers = [float(text) for text in re.findall(r"\d[\d.]*e[-+]?\d+", re.sub(r".*\b1e-13.*", "", text))]
    assert not [number for number in numbers if not 1e-37 < number < 1e37]
