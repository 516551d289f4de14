"""A fit of measured recordings, which are not part of the project."""

from __future__ import annotations

import pytest

from tirefmu.fitting import fit


@pytest.fixture(scope="module")
def measured(data_folder):
    """Return the joint fit of cornering and of drive and brake: about 40 s."""
    return fit([data_folder / "cornering.mat", data_folder / "drivebrake.mat"])


def test_the_fit_follows_the_data(measured):
    assert measured.status == "converged"
    assert measured.channel("cornering.mat", "Fy").r2 >= 0.995
    assert measured.channel("drivebrake.mat", "Fx").r2 >= 0.98


def test_every_condition_holds_over_the_operating_range(measured):
    assert len(measured.margins) == 15
    for margin in measured.margins:
        assert margin.margin >= -1e-6, margin


def test_the_tire_is_told_in_iso_and_its_bounds_in_the_signs_of_the_bench(measured):
    assert measured.tire.signs == "iso"
    assert measured.signs == "adapted-sae"
    coefficients = {coefficient.name: coefficient for coefficient in measured.coefficients}
    assert coefficients["PKY1"].value == -measured.tire.values["PKY1"] > 0
    for coefficient in coefficients.values():
        assert coefficient.lower <= coefficient.value <= coefficient.upper, coefficient
