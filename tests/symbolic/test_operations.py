"""The lines of a model as single operations: they compute what the printed code computes."""

from __future__ import annotations

import math

import numpy as np
import pytest
import sympy as sp

from tirefmu.symbolic.model.tape import run, taped
from tirefmu.symbolic.models import MODELS
from tirefmu.symbolic.notation import Chapter
from tirefmu.symbolic.printers.operations import ROLLING_RADIUS, TURNING, model_tape
from tirefmu.tires.code import code_for

#: Mid-range, off the ground, in reverse, with turn slip.
ROWS = {
    "kappa": (0.05, 0.0, -0.4, 0.02),
    "alpha": (-0.08, 0.0, 0.3, 0.01),
    "gamma": (0.03, 0.0, -0.1, 0.0),
    "Fz": (4100.0, -10.0, 900.0, 5000.0),
    "p": (2.1e5, 2.2e5, 1.5e5, 2.4e5),
    "V": (21.0, 10.0, -5.0, 3.0),
    "phit": (0.0, 0.0, 0.0, 0.1),
}


@pytest.mark.parametrize("model", MODELS)
def test_operations_compute_what_the_printed_code_computes(model):
    symbolic_model, tape = MODELS[model], model_tape(MODELS[model])
    printed, outputs = code_for(model, "numpy"), [quantity.name for quantity in symbolic_model.outputs]
    rng, options = np.random.default_rng(4), [0.0] * len(symbolic_model.options)
    defaults = np.array([declaration.default for declaration in symbolic_model.coefficients.values()])
    parameters = np.array([*(defaults + rng.uniform(0.05, 0.2, len(defaults))), *options])
    for row in range(4):
        inputs = np.array([ROWS[quantity.name][row] for quantity in symbolic_model.inputs])
        values = run(tape, dict(zip(tape.leaves, [*inputs, *parameters, 0.0], strict=True)))
        for routine, names in ((printed.forces, outputs), (printed.quantities, printed.quantities_names)):
            expected = routine(inputs[:, None], parameters)[:, 0]
            np.testing.assert_allclose([values[name] for name in names], expected, rtol=1e-9, atol=1e-9)


def test_the_radius_of_a_turning_wheel_depends_on_its_speed():
    tape = model_tape(MODELS["mf61"])
    leaves = dict.fromkeys(tape.leaves, 0.0) | {"UNLOADED_RADIUS": 0.3, "LONGVL": 16.0, "Q_RE0": 1.0, "Q_V1": 0.01}
    leaves |= {"NOMPRES": 1.0, "VERTICAL_STIFFNESS": 1.0, "FNOMIN": 1.0}
    still, turning = (run(tape, leaves | {TURNING: omega}) for omega in (0.0, 100.0))
    assert still[ROLLING_RADIUS] == pytest.approx(0.3)
    assert turning[ROLLING_RADIUS] == pytest.approx(0.3 * (1.0 + 0.01 * (100.0 * 0.3 / 16.0) ** 2))


def test_equal_expressions_are_computed_once():
    x = sp.Symbol("x", real=True)
    eq = Chapter("Twice")
    y = eq("1", "y", sp.sin(2 * x) ** 2)
    eq("2", "z", -sp.sin(2 * x) / (x + y) + 3)
    tape = taped(eq.equations, ["x"])
    assert [operation.code for operation in tape.operations].count("SIN") == 1
    assert [operation.begins for operation in tape.operations if operation.begins] == ["[1] y", "[2] z"]
    assert run(tape, {"x": 0.7})["z"] == pytest.approx(3 - math.sin(1.4) / (0.7 + math.sin(1.4) ** 2))


def test_a_function_without_an_operation_is_refused():
    eq = Chapter("Strange")
    eq("1", "y", sp.sinh(sp.Symbol("x", real=True)))
    with pytest.raises(NotImplementedError, match="sinh"):
        taped(eq.equations, ["x"])
