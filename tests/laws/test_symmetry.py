"""Mirrors: left and right of a symmetric tire, and one tire written in two sign conventions."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

#: What makes a tire's left differ from its right. QBZ4 and QDZ3 are linear in the inclination where a symmetric
#: tire has its square or its size; PKY3 and QBZ5 have its sign.
ASYMMETRIC = (
    "PHY1", "PHY2", "PVY1", "PVY2", "PEY3", "PKY3",
    "RHX1", "RBY3", "RVY1", "RVY2",
    "QBZ4", "QBZ5", "QDZ3", "QDZ6", "QDZ7", "QEZ4", "QHZ1", "QHZ2", "SSZ1",
)  # fmt: skip
#: A mirror turns the side force and the moment round, and leaves the longitudinal force.
ODD_FORCES = np.array([[1.0], [-1.0], [-1.0]])


def symmetric(tire, **values):
    return replace(tire, values={**tire.values, **dict.fromkeys(ASYMMETRIC, 0.0), **values})


def asymmetry(tire, rows, forces_of):
    """Return how far the forces of the mirrored inputs are from the mirrored forces."""
    turned = rows * np.array([[-1.0 if name in ("alpha", "gamma") else 1.0] for name in tire.inputs])
    return np.abs(forces_of(tire, turned) - ODD_FORCES * forces_of(tire, rows))


def test_left_is_right_without_asymmetric_coefficients(tire, points, forces_of, scale_of):
    rows = points(tire)
    assert np.max(asymmetry(symmetric(tire), rows, forces_of) / scale_of(tire)) < 1e-12


@pytest.mark.parametrize("name", ASYMMETRIC)
def test_each_asymmetric_coefficient_tells_left_from_right(tire, points, forces_of, scale_of, name):
    lopsided = symmetric(tire, **{name: tire.values[name]})
    assert np.max(asymmetry(lopsided, points(tire), forces_of) / scale_of(tire)) > 1e-6


def test_iso_and_adapted_sae_are_mirrors(tire, points, forces_of, scale_of):
    rows = points(tire)
    iso = tire.in_signs("iso")
    assert iso.signs == "iso"
    mirrored = ODD_FORCES * forces_of(iso, rows)
    assert np.max(np.abs(mirrored - forces_of(tire, rows)) / scale_of(tire)) < 1e-13


def test_mirrored_twice_is_the_same_tire(tire):
    assert tire.in_signs("iso") != tire
    assert tire.in_signs("iso").in_signs("adapted-sae") == tire


def test_every_coefficient_that_flips_must(tire, points, forces_of, scale_of):
    """A sign left behind in the mirror shows in the forces."""
    rows, iso = points(tire), tire.in_signs("iso")
    forces = forces_of(iso, rows)
    for name, card in tire.book.coefficients.items():
        if card.flips:
            forgotten = replace(iso, values={**iso.values, name: tire.values[name]})
            assert np.max(np.abs(forces_of(forgotten, rows) - forces) / scale_of(tire)) > 1e-6, name
