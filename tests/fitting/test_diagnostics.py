"""The diagnostics of a fit find effects that were added to the data, and no others."""

from __future__ import annotations

import json
from dataclasses import replace
from itertools import product
from math import tau

import numpy as np
import pandas as pd
import pytest

from tirefmu.fitting.checks import (
    Residuals,
    by_condition,
    disagreeing_files,
    disagreeing_segments,
    slip_stiffnesses,
    sweep_differences,
)
from tirefmu.fitting.checks.ripple import ripple
from tirefmu.fitting.checks.undetermined import at_bounds, undetermined
from tirefmu.fitting.constraints import Margin
from tirefmu.fitting.reporting import constraint_rows, extrapolation_text, ripple_texts, significant_differences
from tirefmu.measurements import Noise, VirtualBench, alpha_sweeps

NOISE = 5.0
LOADS, CAMBERS = (220.0, 700.0, 1120.0), (0.0, 0.07)


def recorded(tire, seed=0, loads=LOADS, repeats=1, recording=0):
    """Return rows of alpha sweeps in adapted SAE, up and down, with white noise on Fy, at 100 Hz and 11 m/s."""
    program = alpha_sweeps(loads, CAMBERS, sample_rate=100.0)
    table = VirtualBench(tire, Noise.none()).run(program).with_signs("adapted-sae").table
    table = pd.concat([table] * repeats, ignore_index=True).assign(V=11.0)
    random = np.random.default_rng(seed)
    table["Fy"] += NOISE * random.normal(size=len(table))
    segment = np.cumsum(np.r_[0, np.abs(np.diff(table["Fz"])) > 100.0])  # a segment for each load in its turn
    table["t"] = np.arange(len(table)) / 100.0
    return table[["t", "kappa", "alpha", "gamma", "Fz", "V", "Fy"]].assign(recording=recording, segment=segment)


def residuals_of(tire, *tables):
    data, segments = [], 0
    for number, table in enumerate(tables):
        data.append(table.assign(recording=number, segment=table["segment"] + segments))
        segments += int(table["segment"].max()) + 1
    sources = tuple(f"file {number}" for number in range(len(tables)))
    return Residuals(pd.concat(data, ignore_index=True), sources, tire, "adapted-sae")


@pytest.fixture(scope="module")
def clean(known):
    return recorded(known)


def test_the_worst_operating_condition_is_identified(known, clean):
    odd = clean.copy()
    rows = (odd["Fz"] > 900.0) & (odd["gamma"] > 0.03)
    odd.loc[rows, "Fy"] += 40.0
    found = by_condition(residuals_of(known, odd))
    assert len(found) == len(LOADS) * len(CAMBERS)
    assert sum(each.rows for each in found) == len(odd)
    worst = max(found, key=lambda each: each.rmse)
    assert (worst.at["Fz"], worst.at["gamma"]) == pytest.approx((1120.0, 0.07), rel=0.02)
    assert worst.mean == pytest.approx(40.0, abs=2.0)
    assert min(each.rmse for each in found) == pytest.approx(NOISE, rel=0.1)


def test_an_offset_between_files_is_significant_and_noise_is_not(known, clean):
    shifted = recorded(known, seed=1).assign(Fy=lambda t: t["Fy"] + 12.0)
    (found,) = disagreeing_files(residuals_of(known, clean, shifted))
    assert (found.channel, found.first, found.second) == ("Fy", "file 0", "file 1")
    assert found.mean == pytest.approx(-12.0, abs=1.0)
    assert found.typical == pytest.approx(12.0, abs=1.0)
    assert found.sigmas < -20
    (quiet,) = disagreeing_files(residuals_of(known, clean, recorded(known, seed=1)))
    assert abs(quiet.sigmas) < 4
    assert quiet.typical < 2.0


def test_differences_have_the_requested_signs(known, clean):
    shifted = recorded(known, seed=1).assign(Fy=lambda t: t["Fy"] + 12.0)
    iso = replace(residuals_of(known, clean, shifted), signs="iso")
    assert disagreeing_files(iso)[0].mean == pytest.approx(12.0, abs=1.0)


def test_model_errors_are_not_inconsistent_data(known, clean):
    wrong = replace(known, values={**known.values, "PKY1": 0.8 * known.values["PKY1"]})
    (found,) = disagreeing_files(residuals_of(wrong, clean, recorded(known, seed=1)))
    assert abs(found.sigmas) < 4


def test_files_without_a_common_condition_are_not_compared(known):
    light, heavy = recorded(known, loads=(220.0, 400.0)), recorded(known, loads=(900.0, 1120.0))
    assert disagreeing_files(residuals_of(known, light, heavy)) == ()


def test_a_segment_with_an_offset_is_identified(known):
    table = recorded(known, repeats=3)
    assert disagreeing_segments(residuals_of(known, table))  # repeats are compared
    chosen = table["segment"].unique()[4]
    table.loc[table["segment"] == chosen, "Fy"] -= 10.0
    (found,) = disagreeing_segments(residuals_of(known, table))
    assert found.first == f"file 0, segment {chosen + 1}"
    assert found.mean == pytest.approx(-10.0, abs=1.0)


def test_a_lag_is_a_difference_between_up_and_down(known, clean):
    (quiet,) = sweep_differences(residuals_of(known, clean))
    assert abs(quiet.sigmas) < 4
    late = clean.copy()
    late["Fy"] = late["Fy"].shift(5, fill_value=0.0)
    (found,) = sweep_differences(residuals_of(known, late))
    assert (found.first, found.second) == ("file 0, alpha up", "down")
    assert abs(found.sigmas) > 20
    assert found.typical > 20.0


def test_a_ripple_is_found_at_its_radius(known, clean):
    radius, size = 0.21, 8.0  # UNLOADED_RADIUS is 0.23
    odd = clean.assign(Fy=clean["Fy"] + size * np.sin(11.0 * clean["t"] / radius))
    (found,) = ripple(residuals_of(known, odd))
    assert found.stands_out
    assert found.amplitude == pytest.approx(size, rel=0.1)
    assert found.radius == pytest.approx(radius, rel=0.01)
    assert found.frequency == pytest.approx(11.0 / (tau * radius), rel=0.01)
    assert found.share == pytest.approx(size**2 / 2 / (size**2 / 2 + NOISE**2), rel=0.1)
    assert "once per revolution" in ripple_texts((found,))[0]
    (quiet,) = ripple(residuals_of(known, clean))
    assert not quiet.stands_out
    assert quiet.amplitude < 1.5
    assert ripple_texts((quiet,)) == []


def test_ripple_requires_time_and_speed(known, clean):
    assert ripple(residuals_of(known, clean.drop(columns="t"))) == ()
    assert ripple(residuals_of(known, clean.drop(columns="V"))) == ()


def test_slip_stiffness_is_read_from_the_data(known, clean):
    soft = replace(known, values={**known.values, "PKY1": 0.9 * known.values["PKY1"]})
    for tire, off in ((known, 0.0), (soft, -0.1)):
        found = slip_stiffnesses(residuals_of(tire, clean))
        assert [each.channel for each in found] == ["Fy"] * len(LOADS) * len(CAMBERS)
        for each, (load, camber) in zip(found, product(LOADS, CAMBERS), strict=True):
            assert each.load == pytest.approx(load, rel=0.02)
            assert abs(each.at["gamma"]) == pytest.approx(camber, abs=2e-3)
            assert each.off == pytest.approx(off, abs=0.02)
            true = known.evaluate(pd.DataFrame({"alpha": [0.0], "Fz": [each.load]}), signs="adapted-sae")
            assert each.read == pytest.approx(float(true["K_yalpha"].iloc[0]), rel=0.05)


@pytest.mark.parametrize(("loads", "cambers", "slip", "coefficient", "reason"), [
    ((700.0,), CAMBERS, 0.2, "PDY2", "one load only"),
    (LOADS, (0.0,), 0.2, "PDY3", "no inclination"),
    (LOADS, CAMBERS, 0.02, "PDY1", "no alpha beyond 0.02 rad"),
])  # fmt: skip
def test_the_reason_is_the_missing_test_program(known, loads, cambers, slip, coefficient, reason):
    random, n = np.random.default_rng(2), 600
    alpha, load, camber = (random.uniform(-slip, slip, n), random.choice(loads, n), random.choice(cambers, n))
    table = pd.DataFrame({"kappa": 0.0, "alpha": alpha, "gamma": camber, "Fz": load})
    table["Fy"] = known.evaluate(table, signs="adapted-sae")["Fy"] + NOISE * random.normal(size=n)
    residuals = residuals_of(known, table.assign(segment=0))
    free = ["PCY1", "PDY1", "PDY2", "PDY3", "PEY1", "PKY1", "PKY2"]
    (found,) = undetermined(residuals, free, [(coefficient,)], {"Fy": float(n)})
    assert found.coefficients == (coefficient,)
    assert found.reason == reason


def test_an_active_bound_is_distinguished_from_a_coefficient_without_information(known, clean):
    data = residuals_of(known, clean.iloc[::7])
    free = ["PDY1", "PDY2", "PEY1", "PKY1", "PKY2", "PCY1", "PDX1"]
    found = {each.coefficients: each.reason for each in at_bounds(data, free, ["PDY1", "PDX1"], {"Fy": 500.0})}
    assert found["PDY1",] == "at a bound: the data pull beyond it"
    assert found["PDX1",].startswith("at a bound: not identifiable, ")
    assert at_bounds(data, free, [], {"Fy": 500.0}) == ()


@pytest.mark.parametrize(("cambers", "reason"), [
    ((0.0, 0.001), "no inclination"),
    ((0.0, 0.05), "inclination to one side only"),
    ((-0.05, 0.05), "no inclination beyond 2.9 deg"),
])  # fmt: skip
def test_the_missing_inclination_is_reported(known, clean, cambers, reason):
    table = clean.iloc[::7].assign(gamma=lambda t: np.resize(cambers, len(t)))
    table["Fy"] = known.evaluate(table, signs="adapted-sae")["Fy"] + NOISE
    (found,) = undetermined(residuals_of(known, table), ["PDY1", "PDY3"], [("PDY3",)], {"Fy": 0.01})
    assert found.reason == reason


def test_a_load_with_a_small_slip_range_is_reported(known):
    random, n = np.random.default_rng(3), 900
    load = random.choice(LOADS, n)
    kappa = np.where(load == 700.0, 0.3, 0.1) * random.uniform(-1, 1, n)
    table = pd.DataFrame({"kappa": kappa, "alpha": 0.0, "gamma": 0.0, "Fz": load})
    table["Fx"] = known.evaluate(table, signs="adapted-sae")["Fx"] + NOISE * random.normal(size=n)
    residuals = residuals_of(known, table.assign(segment=0))
    free = ["PCX1", "PDX1", "PDX2", "PEX1", "PEX2", "PEX3", "PKX1", "PKX2", "PKX3"]
    (found,) = undetermined(residuals, free, [("PEX2", "PEX3")], {"Fx": 5.0})
    assert found.coefficients == ("PEX2", "PEX3")
    assert found.reason == "no second load above 0.1 kappa"


def test_all_findings_are_in_strict_json(side_fit):
    result, recording = side_fit
    found = result.findings
    assert found is result.findings  # once
    assert {each.recording for each in found.conditions} == {recording.source}
    plain = json.loads(json.dumps(result.to_json(), allow_nan=False))
    assert len(plain["findings"]["conditions"]) == len(found.conditions) == 12
    assert plain["held_out"] == []
    assert not significant_differences(result)  # without noise nothing differs
    assert replace(result, residuals=None).findings.conditions == ()


def test_every_margin_is_reported_once_with_its_extrapolation(side_fit):
    far = Margin("mu_y > 0, 1.5 x the range", 0.5, 0.49, {"Fz": 1680.0}, "extrapolation:mu_y")
    result = replace(side_fit[0], margins=(*side_fit[0].margins, far))
    found = constraint_rows(result.margins)
    shown = [margin.name for each in found for margin in (each.inside, each.beyond) if margin is not None]
    assert sorted(shown) == sorted(margin.name for margin in result.margins)
    assert "1.5 times" in extrapolation_text(result)
    assert "not enforced outside the measured range" in extrapolation_text(side_fit[0])
    (friction,) = (each for each in found if each.constraint == "mu_y > 0")
    assert friction.beyond == far
