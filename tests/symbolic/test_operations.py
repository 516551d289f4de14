"""The lines of a model as single operations: they compute what the printed code computes."""

from __future__ import annotations

import math
import random
from dataclasses import replace

import numpy as np
import pytest
import sympy as sp

from tirefmu.boundary.errors import ModelError
from tirefmu.symbolic import models
from tirefmu.symbolic.functions import absolute, sgn, sgn1
from tirefmu.symbolic.model.lines import reaching
from tirefmu.symbolic.model.structure import Structure
from tirefmu.symbolic.model.tape import run, taped
from tirefmu.symbolic.models import MODELS, model_named, whole_library
from tirefmu.symbolic.notation import Chapter
from tirefmu.symbolic.printers.expressions import CasadiPrinter, NumpyPrinter, PlainCPrinter
from tirefmu.symbolic.printers.operations import ROLLING_RADIUS, TURNING, model_tape
from tirefmu.tires.code import code_for
from tirefmu.tires.code.printed import model_with, printed_folder

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


# ------------------------------------------------------ The stored structure of the lines against the lines themselves


ALL = sorted(MODELS)


def read_by(lines, targets):
    return {symbol.name for line in reaching(lines, set(targets)) for symbol in line.expression.free_symbols}


def outside(model, names):
    """Return which of the names are inputs, coefficients or options: steps of lines may be merged."""
    return set(names) & {*model.parameters, *(quantity.name for quantity in model.inputs)}


@pytest.mark.parametrize("name", ALL)
def test_it_reaches_what_the_lines_reach(name):
    model = MODELS[name]
    rng = random.Random(name)
    targets = [quantity.name for quantity in model.outputs]
    sets = [set(model.effects), set(), *({effect for effect in model.effects if rng.random() < 0.5} for _ in range(2))]
    for effects in sets:
        lines = model.lines(effects)
        for wanted in ([*targets, *model.results], targets[:1], targets[-1:]):
            assert outside(model, model.reached(wanted, effects)) == outside(model, read_by(lines, wanted)), effects


@pytest.mark.parametrize("name", ALL)
def test_plain_rows_read_what_the_plain_lines_read(name):
    model = MODELS[name]
    lines = model.lines(plain=True)
    for quantity in model.outputs:
        assert outside(model, model.structure.plain[quantity.name]) == outside(model, read_by(lines, [quantity.name]))


def test_the_stored_text_contains_all_of_it():
    for model in MODELS.values():
        assert Structure.from_text(model.structure.to_text("a test")) == model.structure


def test_a_changed_model_does_not_use_it(made):
    stored = MODELS["mf96"]
    source = replace(stored.source, chapters=stored.source.chapters[:-1])
    changed = replace(stored, source=source, outputs=stored.outputs[:2])
    assert "QDZ1" in stored.coefficients
    assert "QDZ1" not in changed.coefficients
    toy = made()
    assert set(toy.coefficients) == {"UNLOADED_RADIUS", "FNOMIN", "UMAX", "USOFT", "CLONG", "CSIDE", "ARM"}


def test_it_is_stored_with_the_printed_code_for_exactly_these_effects():
    whole = whole_library(MODELS["fiala"])
    printed_folder(model_named("fiala", whole))
    models._EXTENDED.clear()  # as in another process
    printed = model_with("fiala", whole)
    assert printed.stored is not None
    assert printed.structure == replace(printed).structure  # derived from the lines
    milder = replace(whole[0], physics="another text")
    for added in (whole[1:], whole[::-1], (milder, *whole[1:])):
        other = model_with("fiala", added)
        assert other.stored is None
        assert set(other.effects) == {*MODELS["fiala"].effects, *(effect.name for effect in added)}


@pytest.mark.parametrize("text", ["", "[]", "{}", MODELS["mf96"].structure.to_text("a test")])
def test_an_outdated_one_is_an_error_where_it_is_used(made, tmp_path, text):
    toy, stored = made(), tmp_path / "toy.json"
    stored.write_text(text, encoding="ascii")
    toy.use(stored)
    with pytest.raises(ModelError, match=r'toy\.json is stale.*: run "tirefmu generate"'):
        _ = toy.coefficients
    assert set(replace(toy).coefficients) == set(made().coefficients)  # as the generator uses it


# ------------------------------------------------------ Expressions are printed in Python and in C with the same value


x, y, z = sp.symbols("x y z", real=True)
HALF = sp.Rational(1, 2)

EXPRESSIONS = {
    x**2 * y: ("y*x**2", "y*square(x)"),
    x**3: ("x**3", "cube(x)"),
    (x + y) ** 2: ("(x + y)**2", "square(x + y)"),
    x / (y * z**2): ("x/(y*z**2)", "x/(y*square(z))"),
    1 / sp.sqrt(x): ("1/np.sqrt(x)", "1.0/sqrt(x)"),
    x / sp.sqrt(y + 1): ("x/np.sqrt(1 + y)", "x/sqrt(1.0 + y)"),
    x / (y + 1) ** (3 * HALF): ("x/(1 + y)**1.5", "x/cubed_sqrt(1.0 + y)"),
    (x + 1) ** (3 * HALF): ("(1 + x)**1.5", "cubed_sqrt(1.0 + x)"),
    sp.exp(-x * y): ("np.exp(-x*y)", "exp(-x*y)"),
    -sp.atan(x) - y: ("-y - np.atan(x)", "-y - fast_atan(x)"),
    x - (y - z) * 2: ("x - 2*y + 2*z", "x - 2.0*y + 2.0*z"),
    HALF * x: ("0.5*x", "0.5*x"),
    -HALF * x: ("-0.5*x", "-0.5*x"),
    sp.Float("1e-6") + x: ("1e-06 + x", "1e-06 + x"),
    x * sp.cos(y) / sp.cos(z): ("x*np.cos(y)/np.cos(z)", "x*fast_cos(y)/fast_cos(z)"),
    x**4: ("x**4", "fourth(x)"),
    x**y: ("x**y", "pow(x, y)"),
    sp.cos(sp.atan(x)): ("1/np.sqrt(1 + x**2)", "1.0/sqrt(1.0 + square(x))"),
    sp.sin(sp.atan(x)): ("x/np.sqrt(1 + x**2)", "x/sqrt(1.0 + square(x))"),
    sp.tan(x) * sp.log(y): ("np.log(y)*np.tan(x)", "log(y)*fast_tan(x)"),
    sp.acos(z) / sp.pi: ("np.acos(z)/np.pi", "acos(z)/PI"),
    sgn(z) + absolute(z): ("np.abs(z) + np.sign(z)", "fabs(z) + sgn(z)"),
    sgn1(z): ("np.where(z >= 0, 1, np.sign(z))", "sgn1(z)"),
    sp.Piecewise((x, sp.Or(sp.And(x > 1, y < 2), sp.Eq(z, 0))), (y, True)): (
        "np.where(np.logical_or(z == 0, np.logical_and(x > 1, y < 2)), x, y)",
        "((z == 0.0) || ((x > 1.0) && (y < 2.0)) ? x : y)",
    ),
    sp.Piecewise((0, x <= 1), (y + z, True)): ("np.where(x <= 1, 0, y + z)", "(x <= 1.0 ? 0.0 : y + z)"),
}
POINT = {"x": 0.7, "y": 1.3, "z": -0.4}


@pytest.mark.parametrize("expression", EXPRESSIONS, ids=str)
def test_text(expression):
    python, c = EXPRESSIONS[expression]
    assert NumpyPrinter().doprint(expression) == python
    assert PlainCPrinter().doprint(expression) == c


@pytest.mark.parametrize("expression", EXPRESSIONS, ids=str)
def test_meaning(expression):
    expected = float(
        expression.subs({sp.Symbol(name, real=True): sp.Float(value, 30) for name, value in POINT.items()})
    )
    python = NumpyPrinter().doprint(expression)
    assert float(eval(python, {"np": np, **POINT})) == pytest.approx(expected, rel=1e-14)
    if "?" not in PlainCPrinter().doprint(expression):  # other C expressions are valid Python
        powers = {"square": lambda a: a * a, "cube": lambda a: a**3, "fourth": lambda a: a**4}
        powers |= {"cubed_sqrt": lambda a: a * math.sqrt(a), "PI": math.pi}
        powers |= {f"fast_{name}": getattr(math, name) for name in ("sin", "cos", "tan", "atan")}
        powers |= {"sgn": np.sign, "sgn1": lambda a: 1.0 if a >= 0 else -1.0}
        c = PlainCPrinter().doprint(expression)
        assert eval(c, {**vars(math), **powers, **POINT}) == pytest.approx(expected, rel=1e-14)


@pytest.mark.parametrize("power", [-3, 4, sp.Rational(5, 2)])
def test_other_powers_are_still_right_in_python(power):
    text = NumpyPrinter().doprint((x + 1) ** power * y)
    assert float(eval(text, {"np": np, **POINT})) == pytest.approx(1.7 ** float(power) * 1.3, rel=1e-14)


def test_casadi_combines_conditions_and_propagates_nan():
    both = sp.Piecewise((x, sp.And(x > 1, y < 2)), (sgn1(y), True))
    text = CasadiPrinter().doprint(both)
    assert text == "ca.if_else(ca.logic_and(x > 1, y < 2), x, ca.if_else(y >= 0, 1, ca.sign(y)))"
    assert math.isnan(float(eval(NumpyPrinter().doprint(sgn1(x)), {"np": np, "x": math.nan})))
