"""The stored structure of the lines against the lines themselves."""

from __future__ import annotations

import random
from dataclasses import replace

import pytest

from tirefmu.boundary.errors import ModelError
from tirefmu.symbolic import models
from tirefmu.symbolic.model.lines import reaching
from tirefmu.symbolic.model.structure import Structure
from tirefmu.symbolic.models import MODELS, model_named, whole_library
from tirefmu.tires.code.printed import model_with, printed_folder

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
def test_straight_rows_read_what_the_straight_lines_read(name):
    model = MODELS[name]
    lines = model.lines(straight=True)
    for quantity in model.outputs:
        assert outside(model, model.structure.straight[quantity.name]) == outside(
            model, read_by(lines, [quantity.name])
        )


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
