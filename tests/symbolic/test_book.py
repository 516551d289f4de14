"""Every model: each coefficient with its declaration, each line with its number, using earlier lines only."""

from __future__ import annotations

import math

import pytest

from tirefmu.symbolic.effects import EFFECTS
from tirefmu.symbolic.model.lines import reaching
from tirefmu.symbolic.models import MODELS, model_named
from tirefmu.symbolic.notation import Choice, Switch, Variant

UNITS = {
    "1", "rad", "rad^2", "N", "m", "N m", "N/rad", "N m/rad", "1/rad", "1/rad^2", "1/rad^3",
    "Pa", "m/s", "rad/s", "N/m", "N s/m", "1/m", "1/m^2",
}  # fmt: skip


@pytest.fixture(scope="module", params=MODELS)
def model(request):
    return MODELS[request.param]


def test_every_coefficient_has_a_complete_declaration(model):
    for name, declaration in model.coefficients.items():
        assert declaration.name == name
        assert declaration.unit in UNITS, name
        assert math.isfinite(declaration.lower), name
        assert math.isfinite(declaration.upper), name
        assert declaration.section in {section.title for section in model.sections}
        if declaration.neutral is None:
            assert declaration.start is not None, f"{name} has neither a neutral value nor a start"


def test_every_coefficient_is_declared_once(model):
    names = [name for section in model.sections for name in section.coefficients]
    assert len(names) == len(set(names))
    assert model.coefficients.keys() <= set(names)
    assert model.parameters[: len(model.coefficients)] == tuple(model.coefficients)


def test_every_declared_coefficient_has_a_model():
    for models in ([MODELS["mf96"]], [MODELS["mf52"], MODELS["mf61"], MODELS["mf62"]]):
        declared = {name for section in models[0].sections for name in section.coefficients}
        assert declared == set().union(*(model.coefficients for model in models))


def test_every_line_has_number_unit_and_description(model):
    for line in model.equations:
        assert line.number
        assert line.description, line.symbol
        assert line.unit in UNITS, line.symbol
        assert line.chapter


def test_every_line_uses_only_earlier_lines(model):
    earlier = {quantity.name for quantity in model.inputs} | set(model.parameters) | set(model.effects)
    for line in model.equations:
        assert {symbol.name for symbol in line.expression.free_symbols} <= earlier, line.symbol
        assert line.symbol.name not in earlier, f"{line.symbol} is filed twice"
        earlier.add(line.symbol.name)
    assert {quantity.name for quantity in model.outputs} <= earlier


def test_lines_stay_short(model):
    """A line with others substituted into it would be many times as long."""
    assert max(line.expression.count_ops() for line in model.lines()) <= 55


@pytest.mark.parametrize("effects", [None, [], ["camber_thrust"]])
def test_the_lines_contain_no_switch(model, effects):
    effects = effects and [name for name in effects if name in model.effects]
    for plain in (False, True):
        assert not any(line.expression.has(Switch, Choice, Variant) for line in model.lines(effects, plain=plain))


def test_inner_steps_reach_a_named_quantity(model):
    """Every line is used."""
    targets = {line.symbol.name for line in model.equations if line.named}
    assert reaching(model.equations, targets) == list(model.equations)


def test_effects_of_the_book_are_those_in_its_lines():
    assert set().union(*(model.effects for model in MODELS.values())) >= set(EFFECTS)
    for name, effect in EFFECTS.items():
        assert effect.name == name
        assert effect.physics


def test_a_coefficient_of_two_effects_goes_with_both():
    symbolic_model = model_named("mf96")
    assert "LHY" not in symbolic_model.owned("plysteer") | symbolic_model.owned("camber_thrust")
    assert "LHY" in symbolic_model.owned("plysteer", "camber_thrust")
    assert "PEX2" not in symbolic_model.owned("curvature_asym")
