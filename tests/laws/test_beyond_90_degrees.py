"""Beyond 90 deg of slip angle the wheel moves backwards: the side force opposes the sliding velocity, in all models."""

from __future__ import annotations

import numpy as np
import pandas as pd
import pytest

from tirefmu.tires.code import code_for
from tirefmu.tires.evaluation import Conventions, evaluate

ANGLES = np.radians([91.0, 95.0, 120.0, 150.0, 179.0])


def rows_at(tire, alpha, **inputs):
    given = {"Fz": tire["FNOMIN"], "kappa": 0.05, **inputs, "alpha": alpha}
    return np.array(np.broadcast_arrays(*(given.get(name, tire.nominal(name)) for name in tire.inputs)), dtype=float)


@pytest.mark.parametrize("language", ["numpy", "c"])
def test_forces_are_those_of_the_supplement(tire, language):
    code, parameters = code_for(tire.symbolic_model, language), tire.parameters()
    for side in (1.0, -1.0):
        beyond, inside = (code.forces(rows_at(tire, side * alpha), parameters) for alpha in (ANGLES, np.pi - ANGLES))
        np.testing.assert_allclose(beyond, inside, rtol=1e-9, atol=1e-9 * tire["FNOMIN"])


def test_the_side_force_is_continuous_at_90_degrees_and_keeps_its_sign(tire):
    parameters, code = tire.parameters(), code_for(tire.symbolic_model, "numpy")
    at = np.pi / 2 + np.array([-1e-6, 1e-6])
    before, after = code.forces(rows_at(tire, at), parameters).T
    np.testing.assert_allclose(after, before, rtol=1e-4, atol=1e-5 * tire["FNOMIN"])


def test_derivatives_follow_the_law(tire):
    code, parameters, step = code_for(tire.symbolic_model, "numpy"), tire.parameters(), 1e-6
    index = tire.inputs.index("alpha")
    computed = code.jacobian_inputs(rows_at(tire, ANGLES), parameters)[:, :, index].T
    ends = [code.forces(rows_at(tire, ANGLES + change), parameters) for change in (step, -step)]
    np.testing.assert_allclose(computed.reshape(ends[0].shape), (ends[0] - ends[1]) / (2 * step), rtol=1e-3,
                               atol=1e-3 * tire["FNOMIN"])  # fmt: skip


def test_lagged_slips_follow_the_same_slip(tire):
    if not tire.lags:
        pytest.skip("the model has no relaxation")
    t = np.linspace(0.0, 2.0, 41)
    courses = [
        evaluate(tire, pd.DataFrame({"t": t, "alpha": alpha, "Fz": tire["FNOMIN"], "V": 10.0}), Conventions())
        for alpha in (2.0, np.pi - 2.0)
    ]
    np.testing.assert_allclose(courses[0][list(tire.outputs)], courses[1][list(tire.outputs)], rtol=1e-9, atol=1e-6)
