"""An effect that is switched off in the lines is the full model with the effect's coefficients at neutral."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pandas as pd
import pytest

from tirefmu.symbolic import MODELS
from tirefmu.symbolic.model import reaching
from tirefmu.symbolic.printers.expressions import ArrayPrinter

EFFECTS = [(model, effect) for model, book in MODELS.items() for effect in book.effects]


def forces_of_lines(tire, lines, rows):
    """Evaluate lines with some effects pruned away, printed here and now."""
    printer = ArrayPrinter("np", "np.where")
    space = {"np": np, **tire.values, **dict(zip(tire.inputs, rows, strict=True))}
    for line in reaching(lines, tire.outputs):
        space[line.symbol.name] = eval(printer.doprint(line.expression), space)
    return np.stack([np.broadcast_to(space[name], rows.shape[1]) for name in tire.outputs])


def check(tire, present, rows, forces_of, scale_of):
    # load_stiffness off: sin(2 atan(x)) for 2x with x = 1e-6, to 1e-12 of the stiffness; the rest is rounding.
    pruned = replace(tire, effects=present)
    assert pruned.has == set(present)
    difference = forces_of(pruned, rows) - forces_of_lines(tire, tire.book.lines(present), rows)
    assert np.max(np.abs(difference) / scale_of(tire)) < 1e-9


def test_all_effects_present_is_the_printed_model(tire, points, forces_of, scale_of):
    check(tire, list(tire.book.effects), points(tire), forces_of, scale_of)


def test_each_effect_off(tire, points, forces_of, scale_of):
    for effect in tire.book.effects:
        check(tire, tire.book.effects.keys() - {effect}, points(tire), forces_of, scale_of)


def test_each_effect_alone_and_none(tire, points, forces_of, scale_of):
    for effect in tire.book.effects:
        check(tire, [effect], points(tire), forces_of, scale_of)
    check(tire, [], points(tire), forces_of, scale_of)


def test_random_subsets(tire, points, forces_of, scale_of):
    rng = np.random.default_rng(1)
    for _ in range(20):
        present = [effect for effect in tire.book.effects if rng.random() < 0.5]
        check(tire, present, points(tire), forces_of, scale_of)


def test_each_effect_is_felt(tire, points, forces_of, scale_of):
    """Else being off would not differ from being on."""
    rows = points(tire)
    for effect in tire.book.effects:
        without = forces_of(replace(tire, effects=tire.book.effects.keys() - {effect}), rows)
        assert np.max(np.abs(without - forces_of(tire, rows)) / scale_of(tire)) > 1e-5, effect


@pytest.mark.parametrize(("model", "effect"), EFFECTS)
def test_each_effect_owns_coefficients(model, effect):
    assert MODELS[model].owned(effect)


@pytest.mark.parametrize("model", MODELS)
def test_every_coefficient_reaches_an_output(model):
    book = MODELS[model]
    assert book.live() == book.coefficients.keys()


@pytest.mark.parametrize("model", MODELS)
def test_the_core_reaches_an_output_without_any_effect(model):
    book = MODELS[model]
    assert book.core <= book.live([])
    # What no effect owns and is not the core: scaling factors.
    rest = book.live([]) - book.core
    assert {book.coefficients[name].section for name in rest} == {"SCALING_COEFFICIENTS"}


def test_coefficients_of_an_absent_effect_have_no_say(tire, points, forces_of):
    rows = points(tire)
    effect = "camber_thrust"
    plain = replace(tire, effects=tire.book.effects.keys() - {effect})
    shouting = {**tire.values, **dict.fromkeys(tire.book.owned(effect), 99.0)}
    np.testing.assert_array_equal(forces_of(replace(plain, values=shouting), rows), forces_of(plain, rows))
    assert all(plain.values[name] == tire.book.coefficients[name].neutral for name in tire.book.owned(effect))


def test_without_load_stiffness_cornering_stiffness_is_proportional_to_load(tire):
    plain = replace(tire, effects=tire.book.effects.keys() - {"load_stiffness", "camber_stiffness"})
    loads = np.linspace(0.1, 2.0, 9) * tire.values["FNOMIN"]
    answer = plain.evaluate(pd.DataFrame({"Fz": loads}), signs="adapted-sae")
    expected = tire.values["PKY1"] * tire.values["LKA"] * tire.values["LFZ0"] * loads
    np.testing.assert_allclose(answer["K_yalpha"], expected, rtol=1e-9)
