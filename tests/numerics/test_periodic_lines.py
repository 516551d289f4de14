"""Periodic disturbances on synthetic residuals."""

import numpy as np
import pytest

from tirefmu.numerics.periodic_lines import periodic_lines

T = np.arange(4000) / 50.0
FORCE = np.stack([100.0 * np.sin(2.0 * np.pi * T / 3.0) ** 3])  # sweeps with harmonics


def lines(rest, axes=None, force=FORCE):
    return periodic_lines(axes or {"t": T}, rest[None], np.ones((1, len(T)), dtype=bool), force)


def noise(seed=0):
    return np.random.default_rng(seed).standard_normal(len(T))


@pytest.mark.parametrize("seed", range(20))
def test_noise_has_no_lines(seed):
    coloured = np.convolve(noise(seed), [0.5, 0.3, 0.2], mode="same")
    assert lines(coloured) == []


def test_waves_are_found_in_time_and_in_distance():
    speed = 10.0 + 4.0 * np.sin(0.2 * T)
    distance = np.concatenate([[0.0], np.cumsum(0.5 * (speed[1:] + speed[:-1]) * np.diff(T))])
    rest = noise() + 1.5 * np.sin(2.0 * np.pi * distance / 3.4 + 0.3) + 1.0 * np.cos(2.0 * np.pi * 7.0 * T)
    found = lines(rest, {"t": T, "distance": distance})
    assert [one.over for one in found] == ["distance", "t"]
    assert 1.0 / found[0].frequency == pytest.approx(3.4, rel=1e-3)
    assert found[1].frequency == pytest.approx(7.0, rel=1e-3)


def test_frequencies_of_the_inputs_are_no_disturbances():
    """An error of the functional form repeats with the sweeps, as the forces do."""
    wrong = 3.0 * np.sin(2.0 * np.pi * T / 3.0 * 3.0)
    assert lines(noise() + wrong) == []


@pytest.mark.parametrize(("amplitude", "number"), [(0.2, 0), (0.35, 1)])
def test_waves_of_a_small_share_are_ignored_although_they_are_significant(amplitude, number):
    """In 40,000 rows both stand out of the spectrum; their shares of the mean square are 2 and 6 %."""
    t = np.arange(40_000) / 50.0
    rest = np.random.default_rng(0).standard_normal(len(t)) + amplitude * np.sin(2.0 * np.pi * 5.0 * t)
    force = np.sin(2.0 * np.pi * t / 3.0)
    assert len(periodic_lines({"t": t}, rest[None], np.ones((1, len(t)), dtype=bool), force[None])) == number
