"""A fit with two solutions that the data do not distinguish reports both; intervals contain both."""

from __future__ import annotations

from math import radians

import numpy as np
import pytest

from tirefmu.fitting import fit
from tirefmu.measurements import ChannelNoise, Noise, VirtualBench, kappa_sweeps

from .known_tires import LOADS, NOMINAL, known_tire

#: Of the stiffness Fz (PKX1 + PKX2 df) exp(PKX3 df): to second order in df, PKX2 has two signs.
PAIR = {"PKX2", "PKX3"}


def fitted(noise=10.0, **settings):
    """Return the fit of a tire with a large PKX2 to drive and brake sweeps."""
    tire = known_tire("mf96").with_values(PKX2=7.0, PKX3=0.1)
    bench = VirtualBench(tire, Noise({"Fx": ChannelNoise(constant=noise)}), seed=1)
    recording = bench.run(kappa_sweeps(LOADS, [radians(0.0)], sample_rate=20.0))
    table = recording.with_signs("iso").table[["t", "kappa", "alpha", "gamma", "Fz", "Fx"]]
    return tire, table, fit(table, "mf96", nominal=NOMINAL, recipe="joint", sensor_errors=False, **settings)


@pytest.fixture(scope="module")
def both():
    return fitted()


def test_both_solutions_are_in_the_interval_and_in_the_verdict(both):
    tire, table, result = both
    second = {c.name: c for c in result.coefficients if c.other is not None}
    assert second.keys() >= PAIR
    for c in second.values():
        assert abs(c.other - c.value) < c.interval
    for name in PAIR:
        assert abs(second[name].value - tire.values[name]) < second[name].interval
    assert [reason for reason in result.verdict.reasons if reason.startswith("two solutions") and "PKX2" in reason]
    other = result.tire.with_values(**{name: c.other for name, c in second.items()}).evaluate(table)["Fx"]
    first = result.tire.evaluate(table)["Fx"]
    assert np.sqrt(np.mean((other - first) ** 2)) < 0.3 * result.rmse["Fx"]


def test_the_better_root_is_the_solution_from_either(both):
    _, _, result = both
    other = {c.name: c.other for c in result.coefficients if c.other is not None}
    _, _, repeated = fitted(start=result.tire.with_values(**other))
    assert repeated.tire.values["PKX2"] == pytest.approx(result.tire.values["PKX2"], rel=0.05)


def test_better_data_have_one_solution():
    _, _, result = fitted(0.6)
    assert not [c.name for c in result.coefficients if c.other is not None]
