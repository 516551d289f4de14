"""Mirrors: left and right of a symmetric tire, and one tire written in two sign conventions."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pandas as pd
import pytest

from tirefmu.tires.signs import MIRRORED, reversed_columns

#: Coefficients that make a tire asymmetric, in every model. QBZ4 and QDZ3 are linear in the inclination where
#: a symmetric tire has its square or its size.
ASYMMETRIC = (
    "PHY1", "PHY2", "PVY1", "PVY2", "PEY3",
    "RHX1", "RBY3", "RVY1", "RVY2",
    "QBZ4", "QDZ3", "QDZ6", "QDZ7", "QEZ4", "QHZ1", "QHZ2", "SSZ1",
)  # fmt: skip
#: PKY3 and QBZ5 have the sign of the inclination in MF96, its size later; an overturning moment at rest has a side.
ASYMMETRIC_BY_MODEL = {"mf96": (*ASYMMETRIC, "PKY3", "QBZ5")} | dict.fromkeys(
    ("mf52", "mf61", "mf62"), (*ASYMMETRIC, "QSX1")
)
CASES = [(model, name) for model, names in ASYMMETRIC_BY_MODEL.items() for name in names]


def symmetric(tire, **values):
    return replace(
        tire, values={**tire.values, **dict.fromkeys(ASYMMETRIC_BY_MODEL.get(tire.model, ()), 0.0), **values}
    )


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


@pytest.mark.parametrize("model", ASYMMETRIC_BY_MODEL)
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
