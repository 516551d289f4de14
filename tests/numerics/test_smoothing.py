import numpy as np
import pytest
from scipy.signal import savgol_filter

from tirefmu.numerics import parabolas, smoothed, without_spikes


def sweeps(n=3000):
    return 0.15 * (2.0 * np.abs(2.0 * ((np.arange(n) / 150.0) % 1.0) - 1.0) - 1.0)


@pytest.mark.parametrize("noise", [2e-4, 1e-3, 4e-3])
def test_smoothing_reduces_the_error_of_sweeps(noise):
    true = sweeps()
    raw = true + noise * np.random.default_rng(1).standard_normal(len(true))
    clean, found = smoothed(raw)
    assert np.sqrt(np.mean((clean - true) ** 2)) < 0.75 * noise
    assert found == pytest.approx(noise, rel=0.2)


@pytest.mark.parametrize("rows", [22, 30, 43, 71])
def test_the_noise_of_a_load_is_removed_from_short_segments(rows):
    # A sweep of a log at 5 Hz has 43 rows. A lag of the load would otherwise take its place: it removes noise, too.
    raw = 900.0 + 10.0 * np.random.default_rng(7).standard_normal((20, rows))
    errors = [smoothed(segment)[0] - 900.0 for segment in raw]
    assert np.sqrt(np.mean(np.square(errors))) < 0.75 * 10.0


def test_a_short_sweep_keeps_its_turning_point():
    true = 0.15 * (1.0 - 2.0 * np.abs(np.linspace(-1.0, 1.0, 43)))
    errors = [smoothed(true + 1e-3 * np.random.default_rng(seed).standard_normal(43))[0] - true for seed in range(40)]
    assert np.sqrt(np.mean(np.square(errors))) < 1e-3
    assert np.abs(np.mean(errors, axis=0)).max() < 2e-3


def test_a_step_is_not_smoothed():
    true = np.repeat([0.0, 0.1, -0.05], 500)
    raw = true + 2e-4 * np.random.default_rng(2).standard_normal(1500)
    clean, _ = smoothed(raw)
    assert np.max(np.abs(clean - true)) < 10 * 2e-4


def test_exact_and_constant_channels_are_not_changed():
    for values in (sweeps(), np.full(2000, 3.0)):
        clean, _ = smoothed(values)
        np.testing.assert_allclose(clean, values, atol=1e-3 * (np.ptp(values) + 1e-12))


def test_smoothing_does_not_shift_in_time():
    true = 0.1 * np.sin(np.arange(3000) / 30.0)
    raw = true + 5e-4 * np.random.default_rng(3).standard_normal(3000)
    clean, _ = smoothed(raw)
    slope = np.gradient(true)
    lag = float(slope @ (clean - true) / (slope @ slope))
    assert abs(lag) < 0.05


def test_spikes_are_removed_and_steps_and_turning_points_are_not():
    rng = np.random.default_rng(4)
    steps = np.repeat([2.0, 2.7, 1.8, 2.2], 250)
    for true, noise in ((sweeps(), 1e-4), (steps, 2e-3)):
        raw = true + noise * rng.standard_normal(len(true))
        rows = np.arange(57, len(true) - 50, 91)
        spiked = raw.copy()
        spiked[rows] += 8.0 * noise * rng.choice([-1.0, 1.0], len(rows))
        clean, without = smoothed(spiked)[0], smoothed(raw)[0]
        assert np.mean(np.abs(clean - true)[rows] < 4.0 * noise) >= 0.9  # a few lie on turning points
        others = np.delete(np.arange(len(true)), rows)
        assert np.sqrt(np.mean((clean - true)[others] ** 2)) < 1.1 * np.sqrt(np.mean((without - true)[others] ** 2))


def test_fast_changes_of_a_coarse_channel_are_no_spikes():
    rng = np.random.default_rng(5)
    coarse = np.cumsum(rng.standard_normal(2000)) * np.repeat(rng.integers(0, 2, 100), 20)
    raw = coarse + 1e-3 * rng.standard_normal(2000)
    changed = np.flatnonzero(without_spikes(raw, 1e-3) != raw)
    assert len(changed) < 4
    apex = -1e-3 * np.linspace(0.5, 3.0, 50)[:, None] * np.arange(-5, 6) ** 2.0
    for values in apex:
        np.testing.assert_array_equal(without_spikes(values, 1e-3), values)


@pytest.mark.parametrize("width", [3, 5, 11, 37])
def test_parabolas_are_the_filter_of_savitzky_and_golay(width):
    values = np.random.default_rng(4).standard_normal(80)
    np.testing.assert_allclose(parabolas(values, width), savgol_filter(values, width, 2), atol=1e-13)
    np.testing.assert_allclose(parabolas(values[:width], width), savgol_filter(values[:width], width, 2), atol=1e-13)
