"""Ripple with the wheel revolution is found with radius and amplitude; noise and sweeps are not significant."""

import numpy as np
import pytest

from tirefmu.estimation.periodic_lines import periodic_lines
from tirefmu.estimation.wheel_periodicity import once_per_revolution

RATE, RADIUS = 100.0, 0.23


def made(seconds=60.0, seed=0, amplitude=3.0, noise=1.0):
    """Return time, a speed that varies, and a channel that repeats with the wheel next to one that does not."""
    rng = np.random.default_rng(seed)
    t = np.arange(int(seconds * RATE)) / RATE
    speed = 10.0 + np.sin(0.1 * t)
    angle = np.cumsum(speed) / RATE / RADIUS
    channels = noise * rng.standard_normal((2, len(t)))
    channels[0] += amplitude * np.cos(angle + 0.4)
    return t, speed, channels


def found_in(t, speed, channels, segment=None, radius=0.3):
    return once_per_revolution(t, speed, channels, np.zeros(len(t), dtype=int) if segment is None else segment, radius)


@pytest.mark.parametrize("expected", [0.16, 0.23, 0.4])
def test_radius_frequency_and_amplitude_are_found_whatever_is_expected(expected):
    t, speed, channels = made()
    found = found_in(t, speed, channels, radius=expected)
    assert found.radius == pytest.approx(RADIUS, rel=0.01)
    assert found.frequency == pytest.approx(10.0 / (2.0 * np.pi * RADIUS), rel=0.03)
    assert found.amplitude[0] == pytest.approx(3.0, rel=0.05)
    assert found.share[0] == pytest.approx(4.5 / 5.5, rel=0.1)
    assert found.amplitude[1] < 0.3
    assert found.significant.tolist() == [True, False]


@pytest.mark.parametrize(("seconds", "recordings", "limit"), [(3.0, 200, 3), (6.0, 200, 3), (30.0, 70, 2)])
def test_noise_is_not_significant_however_short_the_recording(seconds, recordings, limit):
    """One of a thousand channels may be significant: the probability of three of 400, or two of 140, is 1 %."""
    lines = [found_in(*made(seconds, seed, amplitude=0.0)) for seed in range(recordings)]
    assert sum(int(line.significant.sum()) for line in lines) < limit


def test_a_slow_sweep_is_not_significant():
    t, speed, channels = made(amplitude=0.0)
    found = found_in(t, speed, channels + 50.0 * np.sin(2.0 * np.pi * t / 12.0))
    assert not found.significant.any()


def test_unused_rows_have_little_effect():
    t, speed, channels = made()
    channels[:, np.random.default_rng(1).random(len(t)) < 0.03] = np.nan
    found = found_in(t, speed, channels)
    assert found.radius == pytest.approx(RADIUS, rel=0.01)
    assert found.amplitude[0] == pytest.approx(3.0, rel=0.1)


def test_nothing_is_found_without_long_stretches_or_a_turning_wheel():
    t, speed, channels = made(10.0)
    assert found_in(t, 0.0 * speed, channels) is None
    assert found_in(t, speed, channels, np.arange(len(t)) // 100) is None  # a second each
    assert found_in(t, speed, np.zeros((0, len(t)))) is None
    assert found_in(t, 100.0 * speed, channels) is None  # fewer than four samples a revolution


# ------------------------------------------------------------------ Periodic disturbances on synthetic residuals


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
