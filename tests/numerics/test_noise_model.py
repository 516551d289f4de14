import numpy as np
import pytest
from scipy.signal import lfilter

from tirefmu.numerics import ROWS_OF_PART, NoiseParts, Whitening, noise_parts

STEP = 0.02
NOISE = NoiseParts(white=0.05, short=1.0, drift=0.3, fading=0.5, memory=2.0)


def faded(rng, n, correlation):
    return lfilter([np.sqrt(1.0 - correlation**2)], [1.0, -correlation], rng.standard_normal(n + 2000))[2000:]


def made(rng, n, size=1.0):
    drift = np.sqrt(NOISE.drift) * size * faded(rng, n, np.exp(-STEP / NOISE.memory))
    return np.sqrt(NOISE.white) * rng.standard_normal(n) + np.sqrt(NOISE.short) * faded(rng, n, NOISE.fading) + drift


def test_the_whitened_rows_square_to_the_likelihood_of_the_present_rows():
    n, rng = 2 * ROWS_OF_PART + 20, np.random.default_rng(0)  # the filter joins parts, and fills the last one
    t = np.arange(n) * STEP
    t[30:] += 1.0  # a pause of the recording
    root = rng.uniform(0.5, 2.0, n)
    root[[5, 6, 7, 40, ROWS_OF_PART - 1, ROWS_OF_PART]] = 0.0
    there = root > 0.0
    size = root / np.sqrt(np.mean(root[there] ** 2))
    apart = np.abs(t[:, None] - t)
    covariance = (
        NOISE.white * np.eye(n)
        + NOISE.short * NOISE.fading ** (apart / STEP)
        + NOISE.drift * np.exp(-apart / NOISE.memory) * size[:, None] * size
    )
    rows = root[:, None] * rng.standard_normal((n, 3))
    white = Whitening((NOISE,), t, root[None])(rows[None])[0]
    expected = rows[there].T @ np.linalg.solve(covariance[np.ix_(there, there)], rows[there])
    np.testing.assert_allclose(white.T @ white, expected, rtol=1e-9)
    assert not white[~there].any()


def test_the_noise_parts_are_estimated_from_a_residual():
    rng, n = np.random.default_rng(1), 6000
    present = np.ones(n, dtype=bool)
    present[1000:1120] = present[4000:4120] = False
    found = noise_parts(np.where(present, made(rng, n), 0.0), present, STEP)
    assert found.drift == pytest.approx(NOISE.drift, rel=0.5)
    assert found.memory == pytest.approx(NOISE.memory, rel=0.7)
    assert found.short + found.white == pytest.approx(NOISE.short + NOISE.white, rel=0.15)


def test_a_slow_column_is_estimated_better_with_the_noise_known():
    rng, n = np.random.default_rng(2), 1500
    t, root = np.arange(n) * STEP, np.ones((1, n))
    column = np.sin(2.0 * np.pi * 0.4 * t)
    noise = np.stack([made(rng, n) for _ in range(200)], axis=-1)
    whitening = Whitening((NOISE,), t, root)
    a, b = whitening(column[None])[0], whitening(noise[None])[0]
    plain, weighed = column @ noise / (column @ column), a @ b / (a @ a)
    assert np.std(weighed) < np.std(plain)
    assert np.std(weighed) == pytest.approx(1.0 / np.sqrt(a @ a), rel=0.2)
