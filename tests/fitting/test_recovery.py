"""A small version of benchmarks/recovery.py: recovery of a complete MF96 tire, intervals, other initial values."""

from __future__ import annotations

import numpy as np
import pytest

from tirefmu.fitting import fit
from tirefmu.fitting.constraints.constraint_functions import measured_values
from tirefmu.fitting.constraints.physical import chosen_constraints, grid, operating_range

from .known_tires import CHANNELS, NOMINAL, SIZES, known_tire, moved, recorded

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
