"""Ripple with the wheel revolution is found with radius and amplitude; noise and sweeps are not significant."""

import numpy as np
import pytest

from tirefmu.numerics import once_per_revolution

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
