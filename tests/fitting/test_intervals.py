"""Confidence intervals of forces and quantities: the delta method, signs, coverage."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pandas as pd
import pytest

from tirefmu.boundary.errors import FitError, UnknownName
from tirefmu.fitting import draw_figures
from tirefmu.fitting.reporting import report_page
from tirefmu.measurements import ChannelNoise, Noise, Recording, VirtualBench, alpha_sweeps

TABLE = pd.DataFrame({"alpha": [-0.1, -0.02, 0.0, 0.05], "Fz": [300.0, 500.0, 800.0, 1100.0], "gamma": 0.02})


@pytest.fixture(scope="module")
def noisy(known, make):
    """Return the fit of a noisy recording of the side force."""
    return make.fit(make.sideways(known, noise=Noise()))


@pytest.mark.slow
def test_the_error_is_the_spread_over_random_coefficients(noisy):
    """Tires with random coefficients from the covariance scatter by the standard error, without errors of the form."""
    alone = replace(noisy, uncertainty=replace(noisy.uncertainty, discrepancies=()))
    matrix, tire = noisy.uncertainty.complete, noisy.tire
    random = np.random.default_rng(1).multivariate_normal(np.zeros(len(matrix)), 1e-6 * matrix.to_numpy(), 400)
    values = np.array([tire.values[name] for name in matrix.index])
    tires = [
        replace(tire, values={**tire.values, **dict(zip(matrix.index, values + step, strict=True))}) for step in random
    ]
    evaluated = [tire.evaluate(TABLE, code="numpy") for tire in tires]
    for quantity in ("Fy", "K_yalpha", "mu_y"):
        interval = alone.interval(quantity, TABLE)
        spread = np.std([table[quantity] for table in evaluated], axis=0)
        np.testing.assert_allclose(interval["value"], tire.evaluate(TABLE)[quantity], rtol=1e-12)
        np.testing.assert_allclose(1e3 * spread, interval["error"], rtol=0.15)
        np.testing.assert_allclose(interval["upper"] - interval["lower"], 2 * 1.959964 * interval["error"], rtol=1e-6)


def test_intervals_do_not_depend_on_the_signs(noisy):
    """The table in adapted SAE, and the result in adapted SAE, give the same interval with the other sign."""
    adapted = noisy.interval("Fy", TABLE, signs="adapted-sae")
    iso = noisy.interval("Fy", TABLE)
    np.testing.assert_allclose(adapted["lower"], -iso["upper"], rtol=1e-9)
    other = noisy.in_signs("adapted-sae")
    pd.testing.assert_frame_equal(other.interval("K_yalpha", TABLE), noisy.interval("K_yalpha", TABLE), rtol=1e-9)


def test_intervals_are_listed_in_the_json(noisy):
    listed = noisy.to_json()["intervals"]
    assert {each["quantity"] for each in listed} == {"K_yalpha", "mu_y", "Fy"}
    for each in listed:
        assert each["lower"] < each["value"] < each["upper"]
    loads = [each["at"]["Fz"] for each in listed if each["quantity"] == "K_yalpha"]
    assert loads == pytest.approx(noisy.residuals.levels["Fz"])


@pytest.mark.usefixtures("drawn_figures")
def test_bands_are_drawn_and_reported(noisy, known, make, tmp_path):
    recording = make.sideways(known, noise=Noise())
    with_bands = draw_figures(noisy, recording, tmp_path / "a")
    without = draw_figures(noisy.tire, recording, tmp_path / "b")
    for one, two in zip(with_bands, without, strict=True):
        assert (one.read_bytes() != two.read_bytes()) == (one.stem in ("pure_Fy", "stiffness", "friction"))
    assert "Intervals over load" in report_page(noisy, [])


def test_bad_requests(noisy):
    with pytest.raises(UnknownName, match="K_yalfa"):
        noisy.interval("K_yalfa", TABLE)
    with pytest.raises(FitError, match="confidence level 95"):
        noisy.interval("Fy", TABLE, level=95)


@pytest.mark.slow
def test_true_curves_are_covered(known, make):
    """Of six benches. `benchmarks/recovery.py` measures the coverage over 100, with white and with correlated noise."""
    inside = []
    truth = known.in_signs("iso").evaluate(TABLE)
    noise = Noise({"Fy": ChannelNoise(constant=15.0)}, correlation_time=0.0)
    for seed in range(6):
        program = alpha_sweeps((220.0, 500.0, 800.0, 1120.0), [0.0, 0.035, 0.07], sample_rate=5.0)
        table = VirtualBench(known, noise, seed=seed).run(program).table.drop(columns=["Fx", "Mz"])
        result = make.fit(Recording(table, "adapted-sae", "bench"))
        for quantity in ("Fy", "K_yalpha"):
            found = result.interval(quantity, TABLE)
            inside += list((found["lower"] <= truth[quantity]) & (truth[quantity] <= found["upper"]))
    assert np.mean(inside) >= 0.8
