"""The lines of a model as single operations: they compute what the printed code computes."""

from __future__ import annotations

import math
import operator

import numpy as np
import pytest
import sympy as sp

from tirefmu.symbolic.model.tape import CODES, taped
from tirefmu.symbolic.models import MODELS
from tirefmu.symbolic.notation import Chapter
from tirefmu.symbolic.printers.operations import ROLLING_RADIUS, TURNING, model_tape
from tirefmu.tires.code import code_for

DOES = {
    "ADD": operator.add,
    "SUBTRACT": operator.sub,
    "MULTIPLY": operator.mul,
    "DIVIDE": np.divide,
    "POWER": np.power,
    "LESS": operator.lt,
    "AT_MOST": operator.le,
    "EQUAL": operator.eq,
    "AND": lambda x, y: bool(x) and bool(y),
    "OR": lambda x, y: bool(x) or bool(y),
    "CHOOSE": lambda condition, x, y: x if condition else y,
    "ROOT": np.sqrt,
    "SGN": np.sign,
    "SGN1": lambda x: np.sign(x) or 1.0,
    "ABSOLUTE": abs,
    "ATAN": np.arctan,
    "ACOS": np.arccos,
}
DOES |= {code: getattr(np, code.lower()) for code in CODES if code not in DOES}
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


def values_of(tape, leaves):
    slots = [*leaves, *tape.constants]
    with np.errstate(all="ignore"):  # in branches that are not taken
        for operation in tape.operations:
            slots.append(DOES[operation.code](*(slots[slot] for slot in operation.operands)))
    return {name: float(slots[i]) for name, i in tape.slots.items()}


@pytest.mark.parametrize("model", MODELS)
def test_operations_compute_what_the_printed_code_computes(model, golden):
    symbolic_model, tape = MODELS[model], model_tape(MODELS[model])
    printed, outputs = code_for(model, "numpy"), [quantity.name for quantity in symbolic_model.outputs]
    rng = np.random.default_rng(4)
    declarations = [
        each.neutral if each.neutral is not None else each.start for each in symbolic_model.coefficients.values()
    ]
    options = [0.0] * (len(symbolic_model.parameters) - len(declarations))
    parameters = np.array([*(np.array(declarations) + rng.uniform(0.05, 0.2, len(declarations))), *options])
    for row in range(4):
        inputs = np.array([ROWS[quantity.name][row] for quantity in symbolic_model.inputs])
        found = values_of(tape, [*map(np.float64, inputs), *parameters, np.float64(0.0)])
        for routine, names in ((printed.forces, outputs), (printed.quantities, printed.quantities_names)):
            expected = routine(inputs[:, None], parameters)[:, 0]
            np.testing.assert_allclose([found[name] for name in names], expected, rtol=1e-9, atol=1e-9)


def test_the_radius_of_a_turning_wheel_depends_on_its_speed():
    tape = model_tape(MODELS["mf61"])
    leaves = dict.fromkeys(tape.leaves, 0.0) | {"UNLOADED_RADIUS": 0.3, "LONGVL": 16.0, "Q_RE0": 1.0, "Q_V1": 0.01}
    leaves |= {"NOMPRES": 1.0, "VERTICAL_STIFFNESS": 1.0, "FNOMIN": 1.0}
    still, turning = (values_of(tape, list((leaves | {TURNING: omega}).values())) for omega in (0.0, 100.0))
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
    assert values_of(tape, [0.7])["z"] == pytest.approx(3 - math.sin(1.4) / (0.7 + math.sin(1.4) ** 2))


def test_a_function_without_an_operation_is_refused():
    eq = Chapter("Strange")
    eq("1", "y", sp.sinh(sp.Symbol("x", real=True)))
    with pytest.raises(NotImplementedError, match="sinh"):
        taped(eq.equations, ["x"])
