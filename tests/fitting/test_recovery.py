"""A small version of benchmarks/recovery.py: recovery of a complete MF96 tire, intervals, other initial values."""

from __future__ import annotations

import numpy as np
import pandas as pd
import pytest

from tirefmu.boundary.errors import FitError
from tirefmu.fitting import fit
from tirefmu.fitting.constraints import chosen_constraints, grid, measured_values, operating_range
from tirefmu.measurements import Recording
from tirefmu.tires import Tire

from ..relatives import slow_relatives
from .known_tires import CHANNELS, NOMINAL, PRESSURES, SIZES, known_tire, moved, recorded

MODEL, ROWS = "mf96", 2500
TRUTH = known_tire(MODEL)
RECORDING = recorded(TRUTH, ROWS, correlation_time=0.5)


def difference(tire, other=TRUTH):
    """Return the largest root mean square difference of a channel, relative to its noise."""
    table = RECORDING.with_signs("adapted-sae").table
    inputs = {name: table[name].to_numpy() for name in TRUTH.inputs}
    one, two = tire.in_signs("adapted-sae").forces(**inputs), other.in_signs("adapted-sae").forces(**inputs)
    return max(float(np.sqrt(np.mean((one[name] - two[name]) ** 2))) / SIZES[name] for name in CHANNELS)


@pytest.fixture(scope="module")
def found():
    return fit([RECORDING], MODEL, nominal=NOMINAL)


def test_predictions_are_within_the_noise(found):
    assert found.ok, found.status
    assert difference(found.tire) < 0.4
    for channel in found.channels:
        assert channel.rmse == pytest.approx(SIZES[channel.channel], rel=0.1)


def test_intervals_contain_the_true_values(found):
    truth = TRUTH.in_signs(found.signs)
    known = [c for c in found.coefficients if np.isfinite(c.interval) and not c.at_bound]
    inside = [abs(c.value - truth.values[c.name]) <= c.interval for c in known]
    assert len(inside) > 60
    assert np.mean(inside) > 0.87  # one recording; benchmarks/recovery.py counts many
    assert np.mean([abs(c.value - truth.values[c.name]) <= 0.2 * c.interval for c in known]) < 0.6  # nor far too wide


@pytest.mark.slow
def test_another_start_has_the_same_solution(found):
    start = moved(TRUTH, 0.6, 2)
    assert difference(start) > 5.0
    result = fit([RECORDING], MODEL, start=start)
    assert result.ok, result.status
    assert difference(result.tire, found.tire) < 0.1


@pytest.mark.parametrize("model", ["mf96", "mf52", "mf61"])
def test_the_known_tires_satisfy_every_constraint(model):
    tire = known_tire(model)
    table = recorded(tire, 300, level=0.0).with_signs("adapted-sae").table
    ranges = operating_range(table, tire)
    nominal = {name: tire.nominal(name) for name in tire.inputs}
    for constraint in (c for channel in CHANNELS for c in chosen_constraints(model)[channel]):
        values = measured_values(
            tire.symbolic_model, constraint, grid(constraint, ranges, nominal, density=2), tire.parameters()
        )
        assert constraint.distance(values).min() > 0, constraint.name


# --------- MF5.2, MF6.1 and MF6.2: known tires recovered from data with pressure, with the constraints of these models


LATER = slow_relatives(["mf52", "mf61", "mf62"])


def inputs(seed, n):
    """Return sweeps of slip angle and of slip at held loads, inclinations and pressures, shuffled."""
    rng = np.random.default_rng(seed)
    combined = np.arange(n) % 2 == 1
    return pd.DataFrame(
        {
            "kappa": np.where(combined, rng.uniform(-0.2, 0.2, n), 0.0),
            "alpha": np.where(combined, rng.choice([0.0, -0.04, 0.08], n), rng.uniform(-0.2, 0.2, n)),
            "gamma": rng.choice([0.0, 0.03, 0.06], n),
            "Fz": rng.choice([600.0, 1200.0, 1800.0, 2600.0], n),
            "p": rng.choice(PRESSURES, n),
            "V": np.full(n, 11.2),
        }
    )


def measured(tire, seed=0, n=1500, noise=0.0):
    table = inputs(seed, n)
    rng = np.random.default_rng(seed + 1)
    forces = tire.forces(**{name: table[name].to_numpy() for name in table})
    sizes = {"Fx": 1500.0, "Fy": 1500.0, "Mz": 30.0}
    outputs = {name: forces[name] + noise * size * rng.normal(size=n) for name, size in sizes.items()}
    return Recording(table.assign(**outputs), "adapted-sae", "made")


@pytest.fixture(scope="module", params=LATER)
def fitted(request):
    return known_tire(request.param), fit([measured(known_tire(request.param), noise=0.01)], request.param)


def test_the_tire_is_recovered_from_generic_values(fitted):
    truth, result = fitted
    assert result.ok, result.status
    elsewhere = inputs(7, 2000)
    arguments = {name: elsewhere[name].to_numpy() for name in elsewhere}
    found, true = result.tire.in_signs("adapted-sae").forces(**arguments), truth.forces(**arguments)
    for name in ("Fx", "Fy", "Mz"):
        error = np.sqrt(np.mean((found[name] - true[name]) ** 2) / np.mean(true[name] ** 2))
        assert error < 0.015, name  # the noise is 1 % of a typical force


def test_nominal_values_are_set_and_noted(fitted):
    truth, result = fitted
    # The data's medians, not the true tire's: 1200 or 1800 N, of two digits.
    assert result.tire.values["FNOMIN"] in (1200.0, 1800.0, 1500.0)
    assert (result.tire.values["NOMPRES"], result.tire.values["INFLPRES"]) == (8.3e4, 8.3e4)
    assert result.tire.values["LONGVL"] == 11.2
    notes = "\n".join(result.notes)
    for text in ("nominal load not given", "nominal pressure p0 not given: the median, 83000 Pa", "radius R0"):
        assert text in notes
    declarations = truth.symbolic_model.coefficients
    assert not [c.name for c in result.coefficients if not declarations[c.name].fitted]
    # No row has turn slip.
    assert not [c.name for c in result.coefficients if declarations[c.name].section == "TURNSLIP_COEFFICIENTS"]
    assert set(result.tire.ranges) == {"kappa", "alpha", "gamma", "Fz", "p"}
    assert result.tire.ranges["p"] == (7e4, 9.7e4)


def test_pressure_coefficients_are_found_and_constraints_verified_over_pressure(fitted):
    truth, result = fitted
    coefficients = {c.name: c for c in result.coefficients}
    if "PPY3" in truth.symbolic_model.coefficients and "pressure_friction" in truth.symbolic_model.effects:
        assert coefficients["PPY3"].value == pytest.approx(truth.values["PPY3"], abs=0.02)
        assert coefficients["PPY3"].interval < 0.05
    margins = {margin.constraint: margin for margin in result.margins}
    expected = [c.text for channel in chosen_constraints(truth.model).values() for c in channel]
    assert list(margins) == expected
    assert {"K_xkappa > 0", "K_yalpha > 0", "D_t > 0", "E_y <= 1"} <= set(expected)
    assert set(margins["mu_y > 0"].at) == {"Fz", "gamma", "p"}


def test_the_scaling_recipe_adapts_a_tire_to_another_surface():
    truth = known_tire("mf61")
    icy = Tire("mf61", {**truth.values, "LMUX": 0.6, "LMUY": 0.55, "LKY": 0.8}, signs="adapted-sae")
    result = fit([measured(icy)], "mf61", start=truth, recipe="scaling")
    assert result.ok, result.status
    values = result.tire.in_signs("adapted-sae").values
    assert [values[n] for n in ("LMUX", "LMUY", "LKY")] == pytest.approx([0.6, 0.55, 0.8], rel=0.01)
    unscaled = [
        n for n, c in truth.symbolic_model.coefficients.items() if c.section in ("LATERAL_COEFFICIENTS", "VERTICAL")
    ]
    assert [values[n] for n in unscaled] == [truth.values[n] for n in unscaled]
    assert {truth.symbolic_model.coefficients[c.name].section for c in result.coefficients} == {"SCALING_COEFFICIENTS"}


def test_scaling_requires_a_start_tire():
    with pytest.raises(FitError, match="recipe scaling scales a given tire"):
        fit([measured(known_tire("mf61"), n=100)], "mf61", recipe="scaling")
