"""Mirrors: left and right of a symmetric tire, and one tire written in two sign conventions."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pandas as pd
import pytest

from tirefmu.symbolic.models import MODELS
from tirefmu.tires.property_file import mirror
from tirefmu.tires.signs import MIRRORED, reversed_columns

CASES = [
    (model, name)
    for model in ("mf96", "mf52", "mf61", "mf62")
    for name, declared in MODELS[model].coefficients.items()
    if declared.sided
]


def symmetric(tire, **values):
    return replace(tire, values={**mirror.symmetric(tire).values, **values})


def signs_of(names, reversed_names):
    return np.array([[-1.0 if name in reversed_names else 1.0] for name in names])


def asymmetry(tire, rows, forces_of):
    """Return the difference between the forces of the mirrored inputs and the mirrored forces."""
    turned = rows * signs_of(tire.inputs, MIRRORED)
    return np.abs(forces_of(tire, turned) - signs_of(tire.outputs, MIRRORED) * forces_of(tire, rows))


def test_a_tire_without_asymmetric_coefficients_is_symmetric(tire, points, forces_of, scale_of):
    assert np.max(asymmetry(symmetric(tire), points(tire), forces_of) / scale_of(tire)) < 1e-12


@pytest.mark.parametrize(("model", "name"), CASES)
def test_each_asymmetric_coefficient_makes_left_and_right_differ(made, points, forces_of, scale_of, model, name):
    tire = made(model, 0)
    asymmetric = symmetric(tire, **{name: tire.values[name]})
    assert np.max(asymmetry(asymmetric, points(tire), forces_of) / scale_of(tire)) > 1e-6


def test_the_image_of_a_tire_has_the_mirrored_forces(tire, points, forces_of, scale_of):
    rows, image = points(tire), mirror.mirrored(tire)
    turned = forces_of(image, rows * signs_of(tire.inputs, MIRRORED)) * signs_of(tire.outputs, MIRRORED)
    assert np.max(np.abs(turned - forces_of(tire, rows)) / scale_of(tire)) < 1e-12
    assert mirror.mirrored(image) == tire
    for name in MIRRORED & tire.ranges.keys():
        assert image.ranges[name] == tuple(-end for end in reversed(tire.ranges[name]))


def test_iso_and_adapted_sae_are_mirrors(tire, points, forces_of, scale_of):
    rows, iso = points(tire), tire.in_signs("iso")
    assert iso.signs == "iso"
    mirrored = signs_of(tire.outputs, reversed_columns("iso", "adapted-sae")) * forces_of(iso, rows)
    assert np.max(np.abs(mirrored - forces_of(tire, rows)) / scale_of(tire)) < 1e-13


@pytest.mark.parametrize("options", [{"convention": "book"}, {"slip_angle": "angle"}, {"limits": True}], ids=str)
def test_iso_and_adapted_sae_are_mirrors_with_every_option(tire, points, scale_of, options):
    """This includes radii, which have no sign."""
    table = pd.DataFrame(dict(zip(tire.inputs, points(tire), strict=True)))
    names = [*tire.outputs, *tire.symbolic_model.results]
    sizes = pd.Series(dict(zip(tire.outputs, scale_of(tire)[:, 0], strict=True)))
    iso, adapted = (tire.evaluate(table, signs=signs, **options)[names] for signs in ("iso", "adapted-sae"))
    for name in names:
        way = -1.0 if name in reversed_columns("iso", "adapted-sae") else 1.0
        size = sizes.get(name, np.abs(iso[name]).max())
        assert np.max(np.abs(way * iso[name] - adapted[name])) <= 1e-11 * size, name


def test_mirrored_twice_is_the_same_tire(tire):
    assert tire.in_signs("iso") != tire
    assert tire.in_signs("iso").in_signs("adapted-sae") == tire


@pytest.mark.parametrize("model", ["mf96", "mf52", "mf61", "mf62"])
def test_every_declared_sign_change_is_necessary(made, points, model):
    """A sign that is not mirrored changes a force or the deflection."""
    tire = made(model, 0)
    table, iso = pd.DataFrame(dict(zip(tire.inputs, points(tire), strict=True))), tire.in_signs("iso")
    shown = [*tire.outputs, *(name for name in ("R_l",) if name in tire.symbolic_model.results)]
    right = iso.evaluate(table)[shown]
    for name, declaration in tire.symbolic_model.coefficients.items():
        if declaration.flips:
            forgotten = replace(iso, values={**iso.values, name: tire.values[name]}).evaluate(table)[shown]
            # A power of a negative number is NaN, which is a difference as well.
            felt = ~(np.abs(forgotten - right) <= 1e-6 * np.abs(right).max())
            assert felt.to_numpy().any(), name
