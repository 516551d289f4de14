"""An effect that is switched off in the lines is the full model with the effect's coefficients at neutral."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import numpy as np
import pandas as pd
import pytest

from tirefmu.symbolic.model import INDISPENSABLE
from tirefmu.symbolic.model.lines import reaching
from tirefmu.symbolic.models import MODELS
from tirefmu.symbolic.printers.expressions import NumpyPrinter

#: The coefficients of the relaxation lengths of MF5.2 are among those of the forces.
RELAXATION = {"mf52": {"LONGITUDINAL_COEFFICIENTS", "LATERAL_COEFFICIENTS"}}
EFFECTS = [(name, effect) for name, model in MODELS.items() for effect in model.effects]


@cache
def printed(expression):
    """Print the right-hand side of a line in NumPy."""
    return compile(NumpyPrinter().doprint(expression), "<line>", "eval")


@cache
def pruned_lines(model, present):
    """Return the lines that lead to a force, without the other effects."""
    symbolic_model = MODELS[model]
    return reaching(symbolic_model.lines(present), {quantity.name for quantity in symbolic_model.outputs})


def forces_of_lines(tire, present, rows):
    """Evaluate the pruned lines independently of the generated code."""
    options = dict(zip(tire.symbolic_model.parameters, tire.parameters(), strict=True))
    space = {"np": np, **options, **tire.values, **dict(zip(tire.inputs, rows, strict=True))}
    for line in pruned_lines(tire.model, frozenset(present)):
        space[line.symbol.name] = eval(printed(line.expression), space)
    return np.stack([np.broadcast_to(space[name], rows.shape[1]) for name in tire.outputs])


def check(tire, present, rows, forces_of, scale_of):
    # load_stiffness off: sin(2 atan(x)) for 2x with x = 1e-6, to 1e-12 of the stiffness; the rest is rounding.
    pruned = replace(tire, effects=present)
    assert pruned.has == set(present)
    difference = forces_of(pruned, rows) - forces_of_lines(tire, present, rows)
    assert np.max(np.abs(difference) / scale_of(tire)) < 1e-9


def test_all_effects_present_is_the_printed_model(tire, points, forces_of, scale_of):
    check(tire, list(tire.symbolic_model.effects), points(tire), forces_of, scale_of)


def test_each_effect_off(model_tire, points, forces_of, scale_of):
    for effect in model_tire.symbolic_model.effects:
        check(model_tire, model_tire.symbolic_model.effects.keys() - {effect}, points(model_tire), forces_of, scale_of)


def test_each_effect_alone_and_none(model_tire, points, forces_of, scale_of):
    # MF5.2 and 6.2 have the effects of MF6.1, in lines that they mostly share.
    alone = model_tire.symbolic_model.effects if model_tire.model in ("mf96", "mf61") else ()
    for present in ([], *([effect] for effect in alone)):
        check(model_tire, present, points(model_tire), forces_of, scale_of)


def test_random_subsets(model_tire, points, forces_of, scale_of):
    rng = np.random.default_rng(1)
    for _ in range(5):
        present = [effect for effect in model_tire.symbolic_model.effects if rng.random() < 0.5]
        check(model_tire, present, points(model_tire), forces_of, scale_of)


def test_each_effect_changes_an_output(tire, points, forces_of, scale_of):
    """Otherwise an effect that is off would equal one that is on."""
    rows = points(tire)
    forces = forces_of(tire, rows)
    model = tire.symbolic_model
    for effect in model.effects.keys() - model.relaxing_effects:  # these act over time only
        without = forces_of(replace(tire, effects=model.effects.keys() - {effect}), rows)
        assert np.max(np.abs(without - forces) / scale_of(tire)) > 1e-5, effect


@pytest.mark.parametrize(("model", "effect"), EFFECTS)
def test_each_effect_owns_coefficients(model, effect):
    # relax_load has the length in addition to its change, so relax_lat alone owns no coefficient while it is present.
    together = {"relax_lat", "relax_load"} if effect == "relax_lat" else {effect}
    assert MODELS[model].owned(*(together & MODELS[model].effects.keys()))


@pytest.mark.parametrize("model", MODELS)
def test_every_coefficient_reaches_an_output(model):
    """Or a result. The others are values of absent inputs, limits, or sizes that other packages require of any tire."""
    symbolic_model = MODELS[model]
    elsewhere = {quantity.nominal for quantity in symbolic_model.inputs} | set(INDISPENSABLE)
    assert symbolic_model.live() | elsewhere >= symbolic_model.coefficients.keys()


@pytest.mark.parametrize("model", MODELS)
def test_the_core_reaches_an_output_without_any_effect(model):
    symbolic_model = MODELS[model]
    ranges = {
        name for name, declaration in symbolic_model.coefficients.items() if declaration.section.endswith("_RANGE")
    }
    elsewhere = {quantity.nominal for quantity in symbolic_model.inputs} | set(INDISPENSABLE)
    assert symbolic_model.core <= symbolic_model.live([]) | elsewhere | ranges
    # Given values belong to no effect and not to the core: scaling factors, coefficients of radii and deflection.
    rest = [symbolic_model.coefficients[name] for name in symbolic_model.live([]) - symbolic_model.core - ranges]
    assert {declaration.section for declaration in rest if declaration.fitted} <= RELAXATION.get(model, set())


def test_coefficients_of_an_absent_effect_have_no_influence(magic_tire, points, forces_of):
    rows = points(magic_tire)
    effect = "camber_thrust"
    plain = replace(magic_tire, effects=magic_tire.symbolic_model.effects.keys() - {effect})
    shouting = {**magic_tire.values, **dict.fromkeys(magic_tire.symbolic_model.owned(effect), 99.0)}
    np.testing.assert_array_equal(forces_of(replace(plain, values=shouting), rows), forces_of(plain, rows))
    assert all(
        plain.values[name] == magic_tire.symbolic_model.coefficients[name].neutral
        for name in magic_tire.symbolic_model.owned(effect)
    )


def test_without_load_stiffness_cornering_stiffness_is_proportional_to_load(magic_tire):
    alone = {"load_stiffness", "camber_stiffness", "pressure_stiffness"} & magic_tire.symbolic_model.effects.keys()
    plain = replace(magic_tire, effects=magic_tire.symbolic_model.effects.keys() - alone)
    loads = np.linspace(0.1, 2.0, 9) * magic_tire.values["FNOMIN"]
    answer = plain.evaluate(pd.DataFrame({"Fz": loads}), signs="adapted-sae")
    scales = [magic_tire.values[name] for name in ("LKA", "LFZ0", "LKY") if name in magic_tire.values]
    expected = magic_tire.values["PKY1"] * np.prod(scales[:2] if magic_tire.model == "mf96" else scales) * loads
    np.testing.assert_allclose(answer["K_yalpha"], expected, rtol=1e-9)
