import numpy as np
import pytest

from tirefmu.estimation.smoothing import smoothed


def sweeps(n=3000):
    return 0.15 * (2.0 * np.abs(2.0 * ((np.arange(n) / 150.0) % 1.0) - 1.0) - 1.0)


@pytest.mark.parametrize("noise", [2e-4, 1e-3, 4e-3])
def test_smoothing_reduces_the_error_of_sweeps(noise):
    true = sweeps()
    raw = true + noise * np.random.default_rng(1).standard_normal(len(true))
    clean, found = smoothed(raw)
    assert np.sqrt(np.mean((clean - true) ** 2)) < 0.75 * noise
    assert found == pytest.approx(noise, rel=0.2)


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
